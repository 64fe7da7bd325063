# SPDX-License-Identifier: Apache-2.0
"""Limits of flights, and the settings of a vehicle that are checked against them."""

from dataclasses import dataclass

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.parameters import ParameterReader
from rocsafe_mavlink.plan.fence import Fence


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLimits:
    """Limits of a flight.

    Attributes
    ----------
    lowest_m
        Least height of a waypoint above home.
    max_height_agl_m
        Greatest height of a waypoint above the ground: 120 m is the limit of the open category in
        the European Union (Regulation 2019/947, UAS.OPEN.010). Where the ground is not known it
        bounds the height above home.
    furthest_m
        Distance of a waypoint from home.
    longest_s
        Duration of the flight.
    smallest_charge
        Charge of the battery at the start, 0 to 1.
    fewest_satellites
        Satellites that the receiver must use.
    climb_mps, descent_mps
        Vertical speeds from which the duration is estimated.
    longest_to_home_m
        Distance between the home of the plan and that of the vehicle.
    must_return_on_link_loss
        Whether a vehicle that loses its link has to come back.
    reserve
        Share of the charge that must be left after the flight.
    max_wind_mps, max_gust_mps
        Greatest mean and largest speed of the air in the last minute; 0: no limit.
    separation_m
        Least distance to other vehicles of the bridge at a take-off; 0: none is kept.
    returns_in_wind
        Whether a vehicle in the air is called home when they are exceeded; else that is offered.
    """

    lowest_m: float = 5.0
    max_height_agl_m: float = 120.0
    furthest_m: float = 2000.0
    longest_s: float = 1500.0
    smallest_charge: float = 0.5
    fewest_satellites: int = 6
    climb_mps: float = 2.5
    descent_mps: float = 1.0
    longest_to_home_m: float = 30.0
    must_return_on_link_loss: bool = False
    reserve: float = 0.1
    max_wind_mps: float = 0.0
    max_gust_mps: float = 0.0
    separation_m: float = 0.0
    returns_in_wind: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSettings:
    """What was read from a vehicle besides its telemetry.

    Attributes
    ----------
    parameters
        Its parameters; None: not read.
    fence
        Polygons of its fence; None: not read.
    fence_error
        Why its fence cannot be read; empty while it may be.
    rally
        Its rally points; None: not read.
    rally_error
        Why its rally points cannot be read; empty while they may be.
    station
        Our own system; -1: not known.
    has_twin
        Whether another station was heard that says to be this system.
    """

    parameters: ParameterReader | None = None
    fence: Fence | None = None
    fence_error: str = ''
    rally: tuple[GeoPosition, ...] | None = None
    rally_error: str = ''
    station: int = -1
    has_twin: bool = False
