# SPDX-License-Identifier: Apache-2.0
"""The light of a scene that is changed while it is watched: sun by time, fog, wetness."""

from dataclasses import dataclass, field

from rocsafe_geo.limits import require_between
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.scene.sunlight import Air

FASTEST_SUN = 1e5
LONGEST_STEP_S = 86_400.0


@dataclass(frozen=True, slots=True, kw_only=True)
class MovingSun:
    """Where the sun stands as simulated time goes on.

    Attributes
    ----------
    sun_ns
        Time by which it stands at `from_ns`, nanoseconds since 1970.
    from_ns
        Simulated time from which on it does, nanoseconds since 1970.
    speed
        Time of the sun over simulated time; 0: it stands still.
    step_s
        It moves whenever so much simulated time has passed, seconds.
    """

    sun_ns: int
    from_ns: int
    speed: float = 0.0
    step_s: float = 60.0

    def __post_init__(self) -> None:
        require_between('sun_speed', self.speed, 0.0, FASTEST_SUN)
        require_between('sun_step_s', self.step_s, 1.0, LONGEST_STEP_S, 's')

    def at(self, time_ns: int) -> int:
        """Return the time by which the sun stands at a simulated time, nanoseconds."""
        step_ns = round(self.step_s * NS_PER_S)
        passed_ns = max(0, time_ns - self.from_ns) // step_ns * step_ns
        return self.sun_ns + round(self.speed * passed_ns)


@dataclass(frozen=True, slots=True, kw_only=True)
class LightOrder:
    """Sun and air of a scene from now on; without a sun it stands as the scenario says."""

    sun: MovingSun | None = None
    air: Air = field(default_factory=Air)
