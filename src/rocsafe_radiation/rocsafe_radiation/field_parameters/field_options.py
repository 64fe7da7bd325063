# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``radiation_field``."""

from dataclasses import dataclass, field
from typing import ClassVar

from rocsafe_radiation.detection.detector import DETECTOR_NAMES, IDEAL
from rocsafe_radiation.physics.field import MODELS, PAPER_MODEL, SMALLEST_SOURCE_RADIUS_M


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldOptions:
    """Options of the field node."""

    # Of groups of earlier parameters, those that every user of a group had to give.
    MOVED_PARAMETERS: ClassVar = dict.fromkeys(
        (
            'source_names', 'corner_latitudes_deg', 'box_materials', 'shielding', 'shielding_file',
            'terrain_file', 'terrain_provider', 'ground_altitude_m', 'background_usvh',
            'background_variation', 'background_length_m', 'background_cosmic',
        ),
        'in the file of field_file',
    ) | {'position_source': 'vehicles_at_their_fix'}  # fmt: skip

    field_file: str = field(
        default='',
        metadata={
            'doc': 'YAML file of sources, shields, background and ground, see docs/radiation.md; '
            'empty: no source'
        },
    )
    model: str = field(
        default=PAPER_MODEL,
        metadata={
            'doc': 'law of the dose rate; paper: sigma / d^2, air: attenuated, shielded: as air, '
            'with shields and the things of a scene in the way'
        },
    )
    vehicles: tuple[str, ...] = field(
        default=(), metadata={'doc': 'namespaces of the vehicles that carry a detector'}
    )
    start_time_s: float = field(
        default=0.0,
        metadata={
            'doc': 'start of the mission, seconds since 1970; tracks count from it',
            'min': 0.0,
            'max': 2e11,
        },
    )
    source_radius_m: float = field(
        default=0.1,
        metadata={
            'doc': 'distance below which the dose rate grows no further, metres',
            'min': SMALLEST_SOURCE_RADIUS_M,
            'max': 1e3,
        },
    )
    detector: str = field(
        default=IDEAL,
        metadata={'doc': f'kind of detector: {", ".join(DETECTOR_NAMES)}'},
    )
    window_s: float = field(
        default=1.0,
        metadata={
            'doc': 'time over which a detector counts, seconds; the ideal one has none',
            'min': 1e-3,
            'max': 3600.0,
        },
    )
    seed: int = field(
        default=0,
        metadata={'doc': 'seed of counts and background', 'min': 0, 'max': 2**31 - 1},
    )
    vehicles_at_their_fix: tuple[str, ...] = field(
        default=(),
        metadata={'doc': 'vehicles whose true place nobody publishes: real ones'},
    )
    lock_step: bool = field(
        default=True, metadata={'doc': 'take part in lock-step simulation as radiation_field'}
    )

    def __post_init__(self) -> None:
        _require_choice('model', self.model, MODELS)
        _require_choice('detector', self.detector, DETECTOR_NAMES)
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')

    @property
    def start_time_ns(self) -> int:
        """Start of the mission, nanoseconds since 1970."""
        return round(self.start_time_s * 1e9)


def _require_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f'{name} = {value!r} must be one of: {", ".join(choices)}')
