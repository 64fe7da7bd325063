# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``air``."""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class AirOptions:
    """Options of the node ``air``."""

    air_file: str = field(
        default='',
        metadata={
            'doc': 'YAML file of wind, releases and sensors, see docs/dispersion.md; empty: clean '
            'and still air'
        },
    )
    vehicles: tuple[str, ...] = field(
        default=(), metadata={'doc': 'namespaces of the vehicles that carry the sensors'}
    )
    start_time_s: float = field(
        default=0.0,
        metadata={
            'doc': 'start of the mission, seconds since 1970; releases count from it',
            'min': 0.0,
            'max': 2e11,
        },
    )
    window_s: float = field(
        default=1.0,
        metadata={'doc': 'time between two readings, seconds', 'min': 0.1, 'max': 600.0},
    )
    seed: int = field(
        default=0,
        metadata={'doc': 'seed of gusts, filaments and noise', 'min': 0, 'max': 2**31 - 1},
    )
    vehicles_at_their_fix: tuple[str, ...] = field(
        default=(),
        metadata={'doc': 'vehicles whose true place nobody publishes: real ones'},
    )
    lock_step: bool = field(
        default=True, metadata={'doc': 'take part in lock-step simulation as air'}
    )

    def __post_init__(self) -> None:
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')

    @property
    def start_time_ns(self) -> int:
        """Start of the mission, nanoseconds since 1970."""
        return round(self.start_time_s * 1e9)
