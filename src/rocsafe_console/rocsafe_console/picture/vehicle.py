# SPDX-License-Identifier: Apache-2.0
"""What is known of one vehicle now."""

import math
from dataclasses import dataclass, field
from typing import Any

from rocsafe_console.picture.estimates import BatteryDrain, Trend, way_home_s
from rocsafe_console.picture.frame_bytes import (
    OLD_DOSE,
    OLD_PLACE,
    SIMULATED,
    TAKEN,
    VehicleFrame,
)
from rocsafe_console.picture.freshness import DOSE_STALE_S, STALE_S
from rocsafe_console.picture.track import Track
from rocsafe_geo.position import GeoPosition, distance_m

STATE_NAMES = (
    'unknown', 'disarmed', 'armed', 'taking off', 'flying', 'holding', 'returning', 'landing',
    'landed', 'lost', 'crashed', 'waiting',
)  # fmt: skip
# The same states on wheels.
GROUND_NAMES = {1: 'parked', 4: 'driving', 5: 'standing', 8: 'arrived'}
LOST, CRASHED = 9, 10
ON_GROUND = frozenset({1, 2, 8, 11})


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleReport:
    """A vehicle's state as it tells it; the names are those of VehicleState."""

    name: str
    state: int
    stamp_s: float
    is_simulated: bool = False
    viewpoint_count: int = 0
    viewpoints_visited: int = 0
    shots_taken: int = 0
    shots_pending: int = 0
    battery_fraction: float = math.nan
    text: str = ''
    advice: str = ''
    latitude_deg: float = math.nan
    longitude_deg: float = math.nan
    altitude_m: float = math.nan
    speed_mps: float = math.nan
    taken_by: str = ''
    plan_id: str = ''
    is_ground: bool = False

    @property
    def state_name(self) -> str:
        """State in words."""
        if self.is_ground and self.state in GROUND_NAMES:
            return GROUND_NAMES[self.state]
        return STATE_NAMES[self.state] if self.state < len(STATE_NAMES) else 'unknown'


@dataclass(frozen=True, slots=True, kw_only=True)
class Holder:
    """Holder of the control lease of a vehicle, as its topic `control` tells."""

    holder: str = ''
    mission: str = ''
    lease: str = ''
    epoch: int = 0
    expires_s: float = 0.0
    text: str = ''


@dataclass(slots=True)
class Vehicle:
    """What is known of a vehicle; it is changed by the picture only.

    Attributes
    ----------
    number
        Its number in frames.
    revision
        Rises when its state, its holder or who has taken it changes: an order names the revision
        that the operator saw.
    heard_s
        When it was last heard alive, seconds of the wall; -infinity: never.
    placed_s, measured_s, dosed_s
        The same of its place, its dose rate and its dose: a receiver or detector may fall silent
        alone.
    """

    number: int
    name: str
    revision: int
    report: VehicleReport
    holder: Holder = field(default_factory=Holder)
    home: tuple[float, float, float] | None = None
    heard_s: float = -math.inf
    placed_s: float = -math.inf
    measured_s: float = -math.inf
    dosed_s: float = -math.inf
    latitude_deg: float = math.nan
    longitude_deg: float = math.nan
    altitude_m: float = math.nan
    dose_rate_usvh: float = math.nan
    dose_usv: float = math.nan
    dose_is_lower_limit: bool = False
    fastest_mps: float = 0.0
    drain: BatteryDrain = field(default_factory=BatteryDrain)
    trend: Trend = field(default_factory=Trend)
    track: Track = field(default_factory=Track)

    @property
    def is_aloft(self) -> bool:
        """Whether it is in the air, as far as it tells."""
        return not self.report.is_ground and self.report.state not in ON_GROUND | {
            0, LOST, CRASHED,
        }  # fmt: skip

    @property
    def way_home_s(self) -> float:
        """Estimated time to fly home, seconds; NaN if home or place is unknown."""
        if self.home is None or not math.isfinite(self.latitude_deg + self.longitude_deg):
            return math.nan
        here = GeoPosition(self.latitude_deg, self.longitude_deg)
        return way_home_s(distance_m(here, GeoPosition(*self.home[:2])), self.fastest_mps)

    def frame(self, now_s: float) -> VehicleFrame:
        """Return what a frame tells of it."""
        report = self.report
        flags = SIMULATED * report.is_simulated | TAKEN * bool(report.taken_by)
        flags |= OLD_PLACE * (now_s - self.placed_s > STALE_S)
        flags |= OLD_DOSE * (now_s - self.dosed_s > DOSE_STALE_S)
        below_m = self.home[2] if self.home is not None and math.isfinite(self.home[2]) else 0.0
        return VehicleFrame(
            number=self.number,
            state=report.state,
            flags=flags,
            latitude_deg=self.latitude_deg,
            longitude_deg=self.longitude_deg,
            height_m=self.altitude_m - below_m,
            speed_mps=report.speed_mps,
            battery_fraction=report.battery_fraction,
            visited_fraction=(
                report.viewpoints_visited / report.viewpoint_count
                if report.viewpoint_count
                else math.nan
            ),
            age_s=now_s - self.heard_s,
            dose_rate_usvh=self.dose_rate_now(now_s),
        )

    def dose_rate_now(self, now_s: float) -> float:
        """Return the dose rate where it is, microsievert per hour; NaN if the last one is old."""
        return self.dose_rate_usvh if now_s - self.measured_s <= STALE_S else math.nan

    def to_plain(self) -> dict[str, Any]:
        """Return what changes rarely, fit for JSON."""
        report, holder = self.report, self.holder
        return {
            'number': self.number,
            'name': self.name,
            'revision': self.revision,
            'state': report.state,
            'state_name': report.state_name,
            'is_simulated': report.is_simulated,
            'is_ground': report.is_ground,
            'plan_id': report.plan_id,
            'text': report.text,
            'advice': report.advice,
            'taken_by': report.taken_by,
            'holder': holder.holder,
            'mission': holder.mission,
            'viewpoint_count': report.viewpoint_count,
            'home': self.home,
        }

    def slow_facts(self) -> dict[str, Any]:
        """Return what changes by the second, fit for JSON."""
        way_home_s, left_s = self.way_home_s, self.drain.left_s
        return {
            'visited': self.report.viewpoints_visited,
            'dose_usv': self.dose_usv,
            'dose_is_lower_limit': self.dose_is_lower_limit,
            'way_home_s': round(way_home_s) if math.isfinite(way_home_s) else None,
            'battery_left_s': round(left_s) if math.isfinite(left_s) else None,
        }
