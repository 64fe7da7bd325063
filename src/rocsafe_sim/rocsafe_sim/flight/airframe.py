# SPDX-License-Identifier: Apache-2.0
"""What a vehicle can do: its flight, its hover time, its battery."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.motion.battery import HOVER_POWER_W, PowerModel
from rocsafe_geo.motion.performance import Performance


@dataclass(frozen=True, slots=True, kw_only=True)
class Airframe:
    """Performance of a multirotor.

    Attributes
    ----------
    performance : of its flight, and the wind.
    hover_s : standing time at a viewpoint, at whose end it photographs; 0: it passes viewpoints
        without a stop and photographs on the way.
    endurance_s : time in the air on a full battery, however it flies.
    reserve_fraction : part of a full battery with which it wants to land.
    fails_after_s : time from a flight's take-off to the failure of its battery; 0: never.
    collision_radius_m : within which nothing may stand; 0: it passes through everything.
    hover_power_w
        Power in hover in still air, W.
    """

    performance: Performance
    hover_s: float
    endurance_s: float
    reserve_fraction: float
    hover_power_w: float = HOVER_POWER_W
    fails_after_s: float = 0.0
    collision_radius_m: float = 0.4

    def __post_init__(self) -> None:
        require_not_negative('hover_s', self.hover_s)
        require_positive('endurance_s', self.endurance_s)
        require_not_negative('fails_after_s', self.fails_after_s)
        require_not_negative('collision_radius_m', self.collision_radius_m)
        require_between('reserve_fraction', self.reserve_fraction, 0.0, 0.9)
        _ = self.power

    @property
    def power(self) -> PowerModel:
        """Power in flight; at the largest airspeed a battery lasts for `endurance_s`."""
        return PowerModel(
            hover_power_w=self.hover_power_w,
            endurance_s=self.endurance_s,
            top_airspeed_mps=self.performance.airspeed_mps,
        )
