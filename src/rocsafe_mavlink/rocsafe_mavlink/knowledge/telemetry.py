# SPDX-License-Identifier: Apache-2.0
"""State of one autopilot as its messages report it; `reducer` updates it."""

import math
from dataclasses import dataclass
from enum import Enum, IntEnum, IntFlag

from rocsafe_geo.angle import heading_of_yaw_rad
from rocsafe_geo.position import GeoPosition

NEVER = -math.inf
# Age of the last heartbeat from which a vehicle counts as stale, as lost.
STALE_AFTER_S = 3.0
# A mode that was accepted or announced shows within this time, even if two heartbeats are lost.
MODE_SHOWS_S = 3.5
LOST_AFTER_S = 10.0
# Estimates of the wind are kept so long: the mean and the gust are of the last minute.
WIND_KEPT_S = 60.0
# MAV_TYPE of a ground vehicle.
GROUND_ROVER = 10
# A vehicle this far above its home is in the air, whatever its landed state says: more
# than the error of a barometer, less than any flight.
SURELY_UP_M = 8.0
# A vehicle that does not say so has left the ground above this height.
LEFT_GROUND_M = 1.0
FIX_3D = 3
FIX_NONE = 0


class Contact(Enum):
    """How long ago a vehicle was heard."""

    NONE = 'never heard'
    FRESH = 'fresh'
    STALE = 'stale'
    LOST = 'lost'


class Landed(IntEnum):
    """MAV_LANDED_STATE."""

    UNDEFINED = 0
    ON_GROUND = 1
    IN_AIR = 2
    TAKEOFF = 3
    LANDING = 4


class SystemStatus(IntEnum):
    """MAV_STATE, the values that are used here."""

    UNINIT = 0
    BOOT = 1
    CALIBRATING = 2
    STANDBY = 3
    ACTIVE = 4
    CRITICAL = 5
    EMERGENCY = 6


class MissionPhase(IntEnum):
    """MISSION_STATE."""

    UNKNOWN = 0
    NONE = 1
    NOT_STARTED = 2
    ACTIVE = 3
    PAUSED = 4
    COMPLETE = 5


class EkfFlag(IntFlag):
    """Flags of the position estimate that decide whether it can be used."""

    HORIZONTAL_VELOCITY = 2
    ABSOLUTE_HORIZONTAL_POSITION = 16
    CONSTANT_POSITION = 128


@dataclass(frozen=True, slots=True, kw_only=True)
class Gps:
    """Last report of the GPS receiver.

    Attributes
    ----------
    fix_type
        3 and above is a position with height.
    satellites
        Satellites in use; -1 if not known.
    time_us
        Time of the receiver's solution.
    changed_s
        Steady time at which `time_us` last changed.
    horizontal_std_m, vertical_std_m
        Standard deviations, metres; NaN if the receiver does not tell.
    """

    fix_type: int = FIX_NONE
    satellites: int = -1
    time_us: int = 0
    changed_s: float = NEVER
    horizontal_std_m: float = math.nan
    vertical_std_m: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class Motion:
    """Position and velocity as the autopilot estimates them.

    Attributes
    ----------
    position
        Altitude above the ellipsoid, NaN if the geoid is not known here.
    altitude_msl_m
        Altitude above mean sea level.
    height_above_home_m
        Height above home, by the autopilot.
    velocity_enu_mps
        Velocity east, north, up.
    yaw_rad
        Yaw after REP 103; NaN if not known.
    boot_s
        Time since the start of the autopilot.
    heard_s
        Steady time of arrival.
    """

    position: GeoPosition
    altitude_msl_m: float
    height_above_home_m: float
    velocity_enu_mps: tuple[float, float, float]
    yaw_rad: float
    boot_s: float
    heard_s: float

    @property
    def heading_deg(self) -> float:
        """Compass heading, 0 to 360; NaN if not known."""
        return math.degrees(heading_of_yaw_rad(self.yaw_rad))


@dataclass(frozen=True, slots=True, kw_only=True)
class Attitude:
    """Attitude after REP 103: yaw 0 is east, positive pitch lowers the nose."""

    roll_rad: float
    pitch_rad: float
    yaw_rad: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Home:
    """Place to which the autopilot will return; its altitude is above mean sea level."""

    latitude_deg: float
    longitude_deg: float
    altitude_msl_m: float

    @property
    def place(self) -> GeoPosition:
        """Latitude and longitude."""
        return GeoPosition(self.latitude_deg, self.longitude_deg)


@dataclass(frozen=True, slots=True, kw_only=True)
class Battery:
    """Charge; NaN where the autopilot does not tell."""

    fraction: float = math.nan
    voltage_v: float = math.nan
    current_a: float = math.nan


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionStatus:
    """Progress of the autopilot in its mission, in its own item numbers.

    Attributes
    ----------
    current
        Item to which it flies; -1 if it has not said.
    reached
        Highest item that it reported reached since it was armed; -1 if none.
    phase
        Phase of its mission.
    total
        Number of items that lie on it, without its home; 0 if it does not tell.
    """

    current: int = -1
    reached: int = -1
    phase: MissionPhase = MissionPhase.UNKNOWN
    total: int = 0


@dataclass(frozen=True, slots=True, kw_only=True)
class Aim:
    """Place to which an autopilot flies; its altitude is above mean sea level."""

    latitude_deg: float
    longitude_deg: float
    altitude_msl_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Aircraft:
    """Another aircraft, as its transponder reports it.

    Attributes
    ----------
    icao
        24-bit address.
    callsign
        Its name; empty if it does not tell.
    position
        Latitude and longitude; the altitude is not used.
    altitude_msl_m
        Altitude; NaN if it does not tell.
    is_pressure
        Whether that is a pressure altitude.
    velocity_enu_mps
        Velocity east, north, up; None if it does not tell.
    heard_s
        Steady time of its last word.
    """

    icao: int
    callsign: str
    position: GeoPosition
    altitude_msl_m: float
    is_pressure: bool
    velocity_enu_mps: tuple[float, float, float] | None
    heard_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Wind:
    """Speed of the air as the autopilot estimates it, metres a second.

    Attributes
    ----------
    heard
        Steady time and level speed of each estimate of the last minute.
    """

    heard: tuple[tuple[float, float], ...] = ()

    def after(self, speed_mps: float, now_s: float) -> 'Wind':
        """Return the wind after another estimate; one a second is kept."""
        kept = tuple(one for one in self.heard if now_s - one[0] < WIND_KEPT_S)
        if kept and now_s - kept[-1][0] < 1.0:
            kept = (*kept[:-1], (kept[-1][0], max(kept[-1][1], speed_mps)))
            return Wind(heard=kept)
        return Wind(heard=(*kept, (now_s, speed_mps)))

    def mean_mps(self, now_s: float) -> float:
        """Return the mean of the last minute; NaN if nothing was heard."""
        speeds = self._speeds(now_s)
        return sum(speeds) / len(speeds) if speeds else math.nan

    def gust_mps(self, now_s: float) -> float:
        """Return the largest of the last minute; NaN if nothing was heard."""
        return max(self._speeds(now_s), default=math.nan)

    def _speeds(self, now_s: float) -> list[float]:
        return [speed for at_s, speed in self.heard if now_s - at_s < WIND_KEPT_S]


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleTelemetry:
    """All that one autopilot, (system, component), said of itself.

    Attributes
    ----------
    heartbeat_s
        Steady time of its last heartbeat.
    autopilot
        MAV_AUTOPILOT of its heartbeat, None before the first.
    vehicle_type
        MAV_TYPE of its heartbeat.
    has_flown
        Whether it was in the air since it was last seen started.
    is_prearm_ok
        Its pre-arm bit; it means nothing in a mode that cannot be armed.
    geoid_separation_m
        Height of the geoid above the ellipsoid; NaN if not known; kept while armed.
    jumped_s
        Steady time at which the position last moved faster than any multicopter flies.
    is_fence_breached
        Whether it reports a breach of its fence.
    aim
        Place to which it flies in its present mode; None if it has not told.
    tells_aim
        Whether it tells such places at all.
    traffic
        Other aircraft that its receiver hears.
    wind
        The wind that it estimates.
    """

    system: int
    component: int
    heartbeat_s: float = NEVER
    autopilot: int | None = None
    vehicle_type: int = 0
    custom_mode: int = 0
    status: int = SystemStatus.UNINIT
    is_armed: bool = False
    has_flown: bool = False
    landed: Landed = Landed.UNDEFINED
    is_prearm_ok: bool = False
    gps: Gps = Gps()
    ekf_flags: int | None = None
    motion: Motion | None = None
    attitude: Attitude | None = None
    home: Home | None = None
    battery: Battery = Battery()
    mission: MissionStatus = MissionStatus()
    geoid_separation_m: float = math.nan
    jumped_s: float = NEVER
    is_fence_breached: bool = False
    aim: Aim | None = None
    tells_aim: bool = False
    traffic: tuple[Aircraft, ...] = ()
    wind: Wind = Wind()

    def contact(self, now_s: float) -> Contact:
        """Return how recent its last heartbeat is at `now_s`."""
        age_s = now_s - self.heartbeat_s
        if self.autopilot is None:
            return Contact.NONE
        if age_s < STALE_AFTER_S:
            return Contact.FRESH
        return Contact.STALE if age_s < LOST_AFTER_S else Contact.LOST

    @property
    def is_in_failsafe(self) -> bool:
        """Whether its status is critical or worse with the motors on."""
        return self.is_armed and self.status >= SystemStatus.CRITICAL

    @property
    def is_on_ground(self) -> bool:
        """Whether the motors are off, or it reports that it stands on the ground.

        Its height counts for more than its landed state, which may be old or wrong.
        """
        return not self.is_armed or (self.landed is Landed.ON_GROUND and not self.is_surely_up)

    @property
    def is_airborne(self) -> bool:
        """Whether it says that it flies, or is far above its home."""
        return self.landed is Landed.IN_AIR or self.is_surely_up

    @property
    def has_left_ground(self) -> bool:
        """Whether it flies, if only just; a ground vehicle need not."""
        is_up = self.motion is not None and self.motion.height_above_home_m > LEFT_GROUND_M
        return self.landed is Landed.IN_AIR or is_up or self.vehicle_type == GROUND_ROVER

    @property
    def is_surely_up(self) -> bool:
        """Whether it is far above its home, and does not drive there."""
        if self.motion is None or self.vehicle_type == GROUND_ROVER:
            return False
        return self.motion.height_above_home_m > SURELY_UP_M
