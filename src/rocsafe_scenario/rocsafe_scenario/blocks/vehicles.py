# SPDX-License-Identifier: Apache-2.0
"""The blocks of a scenario's drones, simulated and real."""

from typing import Literal

from pydantic import Field, model_validator

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_scenario.blocks.block import Block, LatLon, SensorName, VehicleName, defaults_of

_VEHICLE, _AUTOPILOT = defaults_of(Vehicle), defaults_of(Autopilot)

# Keys that only the planner needs.
PLANNING_KEYS = (
    'battery_swap_s', 'end', 'is_open', 'sensors', 'cruise_power_w', 'hover_power_w',
)  # fmt: skip
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
