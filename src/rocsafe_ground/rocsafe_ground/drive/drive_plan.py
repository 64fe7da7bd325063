# SPDX-License-Identifier: Apache-2.0
"""Plan of a drive of a ground vehicle, with its predicted time and dose."""

import math
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_positive
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.dose.forecast import DoseForecast
from rocsafe_ground.dose.toxic_load import GasExposure
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.evidence.evidence_point import EvidencePoint

# People turn back at this dose rate, so that the vehicle can be touched and its way be walked:
# IAEA, EPR-First Responders. The same as of drones, see `rocsafe_radiation`.
DEFAULT_TURN_BACK_USVH = 1e5
DEFAULT_CURVE_POINTS = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveRequest:
    """What is asked of a route.

    Attributes
    ----------
    start
        Where the vehicle stands, and where it comes back to.
    end
        Where it comes back to instead; None: the start.
    blocked
        Where something stands that the map does not show.
    evidence
        Points to visit.
    dose_budget_usv
        Of the whole drive, dwells included, which it keeps with a probability of `confidence`.
    load_budget
        Of toxic load by the upper 95 % of a gas that was found, times that of its level 2.
    vehicle
        What drives.
    turn_back_usvh
        No part of the way has a higher dose rate.
    turn_back_ppm
        Nor a higher concentration of a gas that was found, by its upper 95 %.
    confidence
        Share of draws of the sources in which the dose is within the budget.
    draws
        Number of draws.
    seed
        Of the draws.
    curve_points
        Budgets for which the time is told, at most; 0: none.
    """

    start: GeoPosition
    evidence: tuple[EvidencePoint, ...]
    dose_budget_usv: float
    vehicle: GroundVehicle = field(default_factory=GroundVehicle)
    turn_back_usvh: float = DEFAULT_TURN_BACK_USVH
    confidence: float = 0.95
    draws: int = 256
    seed: int = 0
    curve_points: int = DEFAULT_CURVE_POINTS
    end: GeoPosition | None = None
    blocked: tuple[GeoPosition, ...] = ()
    load_budget: float = math.inf
    turn_back_ppm: float = math.inf

    def __post_init__(self) -> None:
        if not self.evidence:
            raise ValueError('evidence is empty: must have at least one point')
        names = [point.id for point in self.evidence]
        if twice := sorted({name for name in names if names.count(name) > 1}):
            text = 'is there twice: each point must have its own name'
            raise ValueError(f'evidence: {twice[0]} {text}')
        require_positive('dose_budget_usv', self.dose_budget_usv, 'uSv')
        if not self.load_budget > 0.0:
            raise ValueError(f'load_budget = {self.load_budget:g}: must be above 0')
        require_between('confidence', self.confidence, 0.5, 0.999)
        require_between('draws', self.draws, 16, 100_000)
        require_between('curve_points', self.curve_points, 0, 100)


@dataclass(frozen=True, slots=True, kw_only=True)
class DriveStop:
    """A place on the way.

    Attributes
    ----------
    place
        Position; the altitude is unknown.
    east_m, north_m
        The same in the frame of the map.
    speed_mps
        On the straight line that leads to it; 0 at the start.
    dwell_s
        How long the vehicle stands there.
    evidence
        Id of the evidence point; empty at a bend.
    look_rad
        Where the vehicle looks while it stands, from east to north.
    duration_s, dose_usv
        Time and estimated dose of that line and of the stand.
    """

    place: GeoPosition
    east_m: float
    north_m: float
    speed_mps: float = 0.0
    dwell_s: float = 0.0
    evidence: str = ''
    look_rad: float = 0.0
    duration_s: float = 0.0
    dose_usv: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class LeftOut:
    """An evidence point that is not visited, and why; the text names what would admit it."""

    evidence: str
    why: str


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class DrivePlan:
    """A route with its proof.

    Attributes
    ----------
    request
        What was asked.
    stops
        Start, bends and evidence points in driving order, and the start again.
    track : (n, 4)
        East and north, seconds after the start, dose rate as estimated: along the lines.
    time_s
        Driving and dwells.
    forecast
        Dose of the drive.
    bound_s
        No trip over the same cells within the same budget takes less.
    grid_time_s
        Of the trip over cells, before it was straightened: what `bound_s` is to be compared with.
    price_s_per_usv
        Seconds that one more microsievert saves, about.
    fastest_s, fastest_usv
        Time and estimated dose of the fastest trip to the same points.
    standing_usv
        Estimated dose of the dwells, which is part of both.
    left_out
        Points not visited.
    curve
        Budget of dose and time of a drive within it, for the same points.
    gas
        Gas along the drive; None: none was found.
    oldest_s
        How long before the newest photograph some ground on the way was photographed: what moved
        since is not known; NaN: nor is that.
    """

    request: DriveRequest
    stops: tuple[DriveStop, ...]
    track: FloatArray
    time_s: float
    forecast: DoseForecast
    bound_s: float
    grid_time_s: float
    price_s_per_usv: float
    fastest_s: float
    fastest_usv: float
    standing_usv: float
    left_out: tuple[LeftOut, ...]
    curve: tuple[tuple[float, float], ...]
    gas: GasExposure | None = None
    oldest_s: float = math.nan

    @property
    def length_m(self) -> float:
        """Length of the way."""
        steps = self.track[1:, :2] - self.track[:-1, :2]
        return float(np.hypot(steps[:, 0], steps[:, 1]).sum())

    @property
    def gap_fraction(self) -> float:
        """Bound of the share by which the time of the trip over cells is above the optimum."""
        return max(0.0, 1.0 - self.bound_s / self.grid_time_s)
