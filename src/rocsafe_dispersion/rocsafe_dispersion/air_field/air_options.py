# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``air``."""

from dataclasses import dataclass

from rocsafe_geo.option import option


@dataclass(frozen=True, slots=True, kw_only=True)
class AirOptions:
    """Options of the node ``air``."""

    air_file: str = option(
        '',
        'YAML file of wind, releases and sensors, see docs/dispersion.md; empty: clean '
        'and still air',
    )
    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles that carry the sensors')
    start_time_s: float = option(
        0.0, 'start of the mission, seconds since 1970; releases count from it', 0.0, 2e11
    )
    window_s: float = option(1.0, 'time between two readings, seconds', 0.1, 600.0)
    seed: int = option(0, 'seed of gusts, filaments and noise', 0, 2**31 - 1)
    vehicles_at_their_fix: tuple[str, ...] = option(
        (), 'vehicles whose true place nobody publishes: real ones'
    )
    lock_step: bool = option(True, 'take part in lock-step simulation as air')

    def __post_init__(self) -> None:
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')

    @property
    def start_time_ns(self) -> int:
        """Start of the mission, nanoseconds since 1970."""
        return round(self.start_time_s * 1e9)
