# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``radiation_field``."""

from dataclasses import dataclass
from typing import ClassVar

from rocsafe_geo.option import option
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

    field_file: str = option(
        '',
        'YAML file of sources, shields, background and ground, see docs/radiation.md; '
        'empty: no source',
    )
    model: str = option(
        PAPER_MODEL,
        'law of the dose rate; paper: sigma / d^2, air: attenuated, shielded: as air, '
        'with shields and the things of a scene in the way',
    )
    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles that carry a detector')
    start_time_s: float = option(
        0.0, 'start of the mission, seconds since 1970; tracks count from it', 0.0, 2e11
    )
    source_radius_m: float = option(
        0.1,
        'distance below which the dose rate grows no further, metres',
        SMALLEST_SOURCE_RADIUS_M,
        1e3,
    )
    detector: str = option(IDEAL, f'kind of detector: {", ".join(DETECTOR_NAMES)}')
    window_s: float = option(
        1.0, 'time over which a detector counts, seconds; the ideal one has none', 1e-3, 3600.0
    )
    seed: int = option(0, 'seed of counts and background', 0, 2**31 - 1)
    vehicles_at_their_fix: tuple[str, ...] = option(
        (), 'vehicles whose true place nobody publishes: real ones'
    )
    lock_step: bool = option(True, 'take part in lock-step simulation as radiation_field')

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
