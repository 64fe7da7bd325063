# SPDX-License-Identifier: Apache-2.0
"""The blocks of a scenario file, each with its keys, units, limits and defaults.

Values are not converted: a string is not a number, and an unknown key is refused.
"""

from collections.abc import Callable
from dataclasses import fields
from datetime import datetime, timezone
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field, model_validator

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.regions.area import MOST_CORNERS
from rocsafe_geo.storage.utc_time import in_utc, time_of_text
from rocsafe_planner.plan.survey_options import (
    MAX_VIEWPOINTS_LIMIT,
    AirspaceOptions,
    CoverageOptions,
    Effort,
    Grid,
    Objective,
    Separation,
    SeparationOptions,
    SpacingRule,
)
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_scenario.limits import LARGEST_BUDGET_S, LARGEST_HEIGHT_M, LARGEST_SPEED

DEFAULT_START = datetime(2025, 6, 1, 10, 0, tzinfo=timezone.utc)
# Seconds of messages end on 2038-01-19; missions take days at most.
EARLIEST_START = datetime(1970, 1, 1, tzinfo=timezone.utc)
LATEST_START = datetime(2038, 1, 1, tzinfo=timezone.utc)
# Names of ROS nodes and namespaces, reserved.
RESERVED_NAMES = frozenset(
    {'advisor', 'air', 'clock', 'collector', 'estimator', 'fleet', 'fleet_verbs', 'hazard',
     'localizer', 'mission', 'mosaic', 'orchestrator', 'plan', 'planner', 'radiation_field',
     'recorder', 'region', 'scene', 'shots', 'sim', 'world'}
)  # fmt: skip


def _defaults(values: type) -> dict[str, Any]:
    """Return the defaults of a dataclass: each is written once, where the value is defined."""
    return {field.name: field.default for field in fields(values)}


_COVERAGE, _AIRSPACE = _defaults(CoverageOptions), _defaults(AirspaceOptions)
_SEPARATION, _EFFORT = _defaults(SeparationOptions), _defaults(Effort)
_VEHICLE, _AUTOPILOT = _defaults(Vehicle), _defaults(Autopilot)

# Keys that only the planner needs.
PLANNING_KEYS = (
    'battery_swap_s', 'end', 'is_open', 'sensors', 'cruise_power_w', 'hover_power_w',
)  # fmt: skip


def _within(name: str, low: float, high: float) -> Callable[[float], float]:
    def check(value: float) -> float:
        if not low <= value <= high:
            raise ValueError(f'{name} must be within {low:g} to {high:g}')
        return value

    return check


def _vehicle_name(name: str) -> str:
    if not name or not name[0].isalpha() or not name.replace('_', 'a').isalnum():
        raise ValueError('a vehicle name is a ROS namespace: a letter, then letters, digits or _')
    if not name.isascii() or '__' in name or name.endswith('_'):
        raise ValueError('a vehicle name is a ROS namespace: ASCII, no __ and no _ at its end')
    if name in RESERVED_NAMES:
        raise ValueError('is the name of a ROCSAFE node or topic; choose another')
    return name


def _in_messages(start: datetime) -> datetime:
    """Refuse a time that no message can carry: ROS counts seconds since 1970 in 31 bits."""
    if not EARLIEST_START <= start <= LATEST_START:
        limits = f'{EARLIEST_START:%Y-%m-%d} to {LATEST_START:%Y-%m-%d}'
        raise ValueError(f'must be within {limits}: messages of ROS carry no other times')
    return start


UtcTime = Annotated[datetime, BeforeValidator(time_of_text), AfterValidator(in_utc)]
Latitude = Annotated[float, AfterValidator(_within('latitude', -90.0, 90.0))]
Longitude = Annotated[float, AfterValidator(_within('longitude', -180.0, 180.0))]
LatLon = tuple[Latitude, Longitude]
SensorName = Annotated[str, Field(pattern=r'^[A-Za-z][A-Za-z0-9_]*$', max_length=64)]
VehicleName = Annotated[str, Field(max_length=32), AfterValidator(_vehicle_name)]


class Block(BaseModel):
    """Settings of every block: unknown keys refused, nothing converted, no infinity, frozen."""

    model_config = ConfigDict(extra='forbid', strict=True, frozen=True, allow_inf_nan=False)


class ClockBlock(Block):
    """Simulated time: `speed` simulated seconds a second, 0 = as fast as the machine can."""

    speed: float = Field(default=0.0, ge=0.0, le=LARGEST_SPEED)
    step_s: float = Field(default=0.1, ge=0.001, le=1.0)
    start: Annotated[UtcTime, AfterValidator(_in_messages)] = DEFAULT_START


class OriginBlock(Block):
    """Origin of the local frame; without a position it is the centroid of the region.

    `ground_altitude_m` is that of the flat ground, above the WGS84 ellipsoid.
    """

    latitude_deg: Latitude | None = None
    longitude_deg: Longitude | None = None
    ground_altitude_m: float = Field(default=0.0, ge=-500.0, le=9000.0)


class RegionBlock(Block):
    """A polygon with holes, written here or in a GeoJSON or KML file.

    Only vehicles that carry all `sensors` survey it.
    """

    polygon: tuple[LatLon, ...] | None = Field(default=None, min_length=3, max_length=MOST_CORNERS)
    holes: tuple[Annotated[tuple[LatLon, ...], Field(min_length=3)], ...] = ()
    file: str | None = None
    sensors: tuple[SensorName, ...] = ()


class AirspaceBlock(Block):
    """What flights keep away from, and the wind: see `AirspaceOptions`."""

    clearance_m: float = Field(default=_AIRSPACE['clearance_m'], ge=0.0, le=1000.0)
    terrain_clearance_m: float = Field(
        default=_AIRSPACE['terrain_clearance_m'], gt=0.0, le=LARGEST_HEIGHT_M
    )
    max_height_agl_m: float = Field(
        default=_AIRSPACE['max_height_agl_m'], gt=0.0, le=LARGEST_HEIGHT_M
    )
    wind_mps: tuple[float, float] = _AIRSPACE['wind_mps']

    def options(self) -> AirspaceOptions:
        """Return it as the planner takes it."""
        return AirspaceOptions(**self.model_dump())


class SeparationBlock(Block):
    """How far apart vehicles stay in the air: see `SeparationOptions`."""

    distance_m: float = Field(default=_SEPARATION['distance_m'], ge=0.0, le=10_000.0)
    by: Separation = _SEPARATION['by']


class FleetBlock(Block):
    """Whether each vehicle has an agent: they go on without an orchestrator.

    `link`: the way of their packets between hosts.
    """

    agents: bool = False
    link: Literal['dds', 'zenoh'] = 'dds'


class EffortBlock(Block):
    """Which method plans, what it minimises, for how long: see `Effort`.

    An empty `method` is the planner's default.
    """

    method: str = ''
    objective: Objective = _EFFORT['objective']
    budget_s: float = Field(default=_EFFORT['budget_s'], ge=0.0, le=LARGEST_BUDGET_S)


class SurveyBlock(Block):
    """How the region is photographed (see `CoverageOptions`), and how the plan is made."""

    height_agl_m: float = Field(gt=0.0, le=LARGEST_HEIGHT_M)
    spacing_rule: SpacingRule = _COVERAGE['spacing_rule']
    overlap_fraction: float = Field(default=_COVERAGE['overlap_fraction'], ge=0.0, le=0.95)
    front_overlap_fraction: float | None = Field(
        default=_COVERAGE['front_overlap_fraction'], ge=0.0, le=0.95
    )
    grid: Grid = _COVERAGE['grid']
    max_viewpoints: int = Field(default=_COVERAGE['max_viewpoints'], ge=1, le=MAX_VIEWPOINTS_LIMIT)
    terrain_file: str = ''
    airspace: AirspaceBlock = AirspaceBlock()
    separation: SeparationBlock = SeparationBlock()
    effort: EffortBlock = EffortBlock()

    def coverage(self) -> CoverageOptions:
        """Return where photographs are taken, as the planner takes it."""
        return CoverageOptions(**self.model_dump(include=set(_COVERAGE)))


# Home of a real vehicle where the scenario leaves it out: the vehicle reports it.
HOME_OF_VEHICLE: LatLon = (0.0, 0.0)
# Keys of a vehicle that say where it is found, not what it can do.
LINK_KEYS = frozenset({'link', 'drone'})


class DetectorBlock(Block):
    """A real detector whose lines the suite reads itself; the keys are those of the node detector.

    Just one of `serial`, `udp` and `tunnel` says where the lines come in.
    """

    serial: str = ''
    baud: int = Field(default=9600, ge=50)
    udp: str = ''
    allow_lan: bool = False
    tunnel: bool = False
    format: str = 'dose_rate'
    format_file: str = ''
    silent_after_s: float = Field(default=5.0, gt=0.0, le=3600.0)
    delay_s: float = Field(default=0.0, ge=0.0, le=60.0)

    @model_validator(mode='after')
    def _has_one_source(self) -> 'DetectorBlock':
        if [bool(self.serial), bool(self.udp), self.tunnel].count(True) != 1:
            raise ValueError('must have one of serial, udp and tunnel')
        return self


class DroneBlock(Block):
    """More of a real vehicle.

    Attributes
    ----------
    system, component
        MAVLink numbers of its autopilot.
    image_folder
        Folder of its JPEG files, or a stream; empty: no images.
    signing_key_file
        Signing key, mode 0600; empty: unsigned.
    allow_lan
        Whether its link may wait for vehicles beyond this machine.
    unsigned
        Whether a link beyond this machine may be without signatures.
    geoid_separation_m
        Height of the geoid above the ellipsoid, metres; None: the vehicle tells.
    max_wind_mps, max_gust_mps
        Greatest mean wind and gust of a minute in which it flies; 0: no limit.
    on_wind
        What happens when they are exceeded in the air: a return is offered, or ordered.
    detector
        ``simulated``: reads the simulated field at its fix. ``own``: a driver that the user starts
        publishes ``radiation`` in the namespace of the vehicle. Or where its lines come in.
    """

    system: int = Field(default=1, ge=1, le=255)
    component: int = Field(default=1, ge=1, le=255)
    image_folder: str = ''
    signing_key_file: str = ''
    allow_lan: bool = False
    unsigned: bool = False
    geoid_separation_m: float | None = Field(default=None, ge=-110.0, le=110.0)
    max_wind_mps: float = Field(default=0.0, ge=0.0, le=50.0)
    max_gust_mps: float = Field(default=0.0, ge=0.0, le=50.0)
    on_wind: Literal['warn', 'return'] = 'warn'
    detector: Literal['simulated', 'own'] | DetectorBlock = 'simulated'


class AutopilotBlock(Block):
    """How a vehicle speeds up, turns, climbs and lands; the defaults are ArduCopter's.

    See the message Autopilot. `waypoint_radius_m` counts where viewpoints are passed without a
    stop: with `hover_s: 0`.
    """

    jerk_mps3: float = Field(default=_AUTOPILOT['jerk_mps3'], gt=0.0, le=1e12)
    smoothing_s: float = Field(default=_AUTOPILOT['smoothing_s'], ge=0.0, le=10.0)
    vertical_acceleration_mps2: float = Field(
        default=_AUTOPILOT['vertical_acceleration_mps2'], gt=0.0, le=1e9
    )
    vertical_jerk_mps3: float = Field(default=_AUTOPILOT['vertical_jerk_mps3'], gt=0.0, le=1e12)
    waypoint_radius_m: float = Field(default=_AUTOPILOT['waypoint_radius_m'], ge=0.0, le=100.0)
    lean_angle_deg: float = Field(default=_AUTOPILOT['lean_angle_deg'], ge=1.0, le=80.0)
    drag_per_m: float = Field(default=_AUTOPILOT['drag_per_m'], ge=1e-6, le=100.0)
    landing_speed_mps: float = Field(default=_AUTOPILOT['landing_speed_mps'], gt=0.0, le=100.0)
    landing_height_m: float = Field(default=_AUTOPILOT['landing_height_m'], ge=0.0, le=1000.0)
    take_off_delay_s: float = Field(default=_AUTOPILOT['take_off_delay_s'], ge=0.0, le=600.0)
    home_wait_s: float = Field(default=_AUTOPILOT['home_wait_s'], ge=0.0, le=600.0)
    landed_delay_s: float = Field(default=_AUTOPILOT['landed_delay_s'], ge=0.0, le=600.0)


class VehicleBlock(Block):
    """A vehicle: its name, which is its ROS namespace, its home and what it can do.

    One with a `link` is real, and may leave its home to be told by the vehicle.
    """

    name: VehicleName
    home: LatLon = HOME_OF_VEHICLE
    cruise_speed_mps: float = Field(default=_VEHICLE['cruise_speed_mps'], gt=0.0, le=100.0)
    acceleration_mps2: float = Field(default=_VEHICLE['acceleration_mps2'], gt=0.0, le=50.0)
    climb_rate_mps: float = Field(default=_VEHICLE['climb_rate_mps'], gt=0.0, le=50.0)
    descent_rate_mps: float = Field(default=_VEHICLE['descent_rate_mps'], gt=0.0, le=50.0)
    hover_s: float = Field(default=_VEHICLE['hover_s'], ge=0.0, le=600.0)
    endurance_s: float = Field(default=1500.0, gt=0.0, le=604_800.0)
    reserve_fraction: float = Field(default=0.1, ge=0.0, le=0.9)
    battery_swap_s: float | None = Field(default=_VEHICLE['battery_swap_s'], ge=0.0, le=86_400.0)
    end: LatLon | None = None
    is_open: bool = False
    fails_after_s: float = Field(default=0.0, ge=0.0, le=1e6)
    sensors: tuple[SensorName, ...] = ()
    cruise_power_w: float = Field(default=_VEHICLE['cruise_power_w'], gt=0.0, le=1e6)
    hover_power_w: float = Field(default=_VEHICLE['hover_power_w'], gt=0.0, le=1e6)
    autopilot: AutopilotBlock = AutopilotBlock()
    link: str = ''
    drone: DroneBlock = DroneBlock()

    @property
    def has_home(self) -> bool:
        """Whether its home is known."""
        return self.home != HOME_OF_VEHICLE

    @property
    def usable_endurance_s(self) -> float:
        """Flight time that a plan may use: the reserve is kept."""
        return self.endurance_s * (1.0 - self.reserve_fraction)
