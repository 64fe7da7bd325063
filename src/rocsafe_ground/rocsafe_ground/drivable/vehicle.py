# SPDX-License-Identifier: Apache-2.0
"""What a ground vehicle can do."""

import math
from dataclasses import dataclass

from rocsafe_geo.limits import require_between, require_not_negative, require_positive
from rocsafe_geo.motion.ground_motion import ROUTE_MARGIN_M


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundVehicle:
    """A ground vehicle as the router sees it. Defaults are those of a tracked robot of 50 kg.

    Attributes
    ----------
    width_m
        Across the tracks.
    margin_m
        Distance to keep from obstacles beside half the width: errors of map and position.
    road_mps, grass_mps, rough_mps
        Speed on asphalt and gravel, on short grass, and on bare or ploughed soil.
    largest_slope_deg
        Of ground that it can climb.
    largest_step_m
        Height of an edge that it can climb.
    endurance_s
        Driving time on a full battery, without the reserve.
    """

    width_m: float = 0.7
    margin_m: float = ROUTE_MARGIN_M
    road_mps: float = 1.5
    grass_mps: float = 1.0
    rough_mps: float = 0.6
    largest_slope_deg: float = 25.0
    largest_step_m: float = 0.2
    endurance_s: float = 7200.0

    def __post_init__(self) -> None:
        require_between('width_m', self.width_m, 0.1, 10.0, 'm')
        require_not_negative('margin_m', self.margin_m, 'm')
        for name in ('road_mps', 'grass_mps', 'rough_mps'):
            require_between(name, getattr(self, name), 0.01, 30.0, 'm/s')
        require_between('largest_slope_deg', self.largest_slope_deg, 0.0, 60.0, 'deg')
        require_not_negative('largest_step_m', self.largest_step_m, 'm')
        require_positive('endurance_s', self.endurance_s, 's')

    @property
    def reach_m(self) -> float:
        """How far its middle stays from obstacles."""
        return 0.5 * self.width_m + self.margin_m

    @property
    def clearance_m(self) -> float:
        """Least distance of a line of its route from obstacles: that which its driver keeps."""
        return 0.5 * (self.width_m + self.margin_m)

    def kept_m(self, cell_m: float) -> float:
        """Return how far from obstacles the middles of free cells are.

        Between the middles of neighbours a route comes nearer, the more the larger the cells are.
        """
        return max(self.reach_m, math.hypot(self.clearance_m, 0.5 * cell_m))
