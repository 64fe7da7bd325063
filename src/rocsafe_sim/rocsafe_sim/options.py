# SPDX-License-Identifier: Apache-2.0
"""Options of the nodes of this package."""

from collections.abc import Mapping
from dataclasses import dataclass, fields
from pathlib import Path
from typing import ClassVar

from rocsafe_geo.limits import require_between, require_not_negative
from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.option import option
from rocsafe_geo.origin_options import OriginOptions
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.value_file import read_values
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.flat_ground.ground_photograph import NO_SCENE, SCENE_NAMES
from rocsafe_sim.cameras.camera_settings import CameraRig, CameraSettings
from rocsafe_sim.flight.flight_options import FlightOptions
from rocsafe_sim.flight.sensing_options import ENGINE, LATEST_S, require_scene
from rocsafe_sim.sensors.sensing_noise import LARGEST_SWAY_STDS
from rocsafe_sim.sensors.sensor_settings import SensorRig

LARGEST_VIEW_ANGLE_DEG = 70.0
IN_CAMERAS_FILE = 'of a camera in the file that cameras_file names'


@dataclass(frozen=True, slots=True, kw_only=True)
class WorldOptions:
    """Options of the node `world`."""

    MOVED_PARAMETERS: ClassVar[Mapping[str, str]] = dict.fromkeys(
        ('seed', *(setting.name for setting in fields(OriginOptions))),
        'a parameter of rav and fleet only',
    )

    step_s: float = option(0.1, 'simulated time between two steps, s', 1e-3, 10.0)
    speed: float = option(0.0, 'simulated seconds per second; 0: as fast as possible', 0.0, 1e3)
    participants: tuple[str, ...] = option((), 'names of those who must finish each step')
    autostart: bool = option(True, 'let time run from the start; otherwise world/run starts it')
    pause_when_idle: bool = option(False, 'pause when all participants have become idle')
    pause_on_news: bool = option(False, 'pause when a loss is announced, or a hold is obeyed')
    start_time_s: float = option(0.0, 'time of the first step, s since 1970', 0.0, LATEST_S)
    scene: str = option(NO_SCENE, f'objects shown as markers: {", ".join(SCENE_NAMES)}')

    def __post_init__(self) -> None:
        require_between('step_s', self.step_s, 1e-3, 10.0)
        require_between('speed', self.speed, 0.0, 1e3)
        require_not_negative('start_time_s', self.start_time_s)
        require_scene(self.scene)
        _require_names('participants', self.participants)

    @property
    def step_ns(self) -> int:
        """Simulated time between two steps, nanoseconds."""
        return round(self.step_s * NS_PER_S)

    @property
    def start_ns(self) -> int:
        """Simulated time of the first step, nanoseconds since 1970; above zero."""
        whole, part = divmod(self.start_time_s, 1.0)
        # /clock tells nodes nothing at time 0, which ROS takes for "no time yet".
        return max(int(whole) * NS_PER_S + round(part * NS_PER_S), self.step_ns)


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleOptions(FlightOptions):
    """What all simulated vehicles have in common; see config/rocsafe.yaml."""

    MOVED_PARAMETERS: ClassVar[Mapping[str, str]] = {
        'cameras': 'a list in the file that cameras_file names',
        'camera_horizontal_fov_deg': f'horizontal_fov_deg {IN_CAMERAS_FILE}',
        'camera_oversampling': f'oversampling {IN_CAMERAS_FILE}',
        **{
            name: f'{name} {IN_CAMERAS_FILE}'
            for name in ('image_width_px', 'image_height_px', 'jpeg_quality', 'stream_rate_hz')
        },
        **{
            setting.name: f'{setting.name} in the file that autopilot_file names'
            for setting in fields(Autopilot)
        },
        'drag_power_w_s2_per_m2': 'a constant of rocsafe_geo.motion.battery',
        'voltage_v': 'a constant of rocsafe_geo.motion.battery',
        'scene_cache': 'the folder rocsafe of XDG_CACHE_HOME',
    }

    cameras_file: str = option(
        '', 'YAML file of the cameras, see docs/cameras.md; empty: one that looks down'
    )
    sensors_file: str = option(
        '', 'YAML file of further sensors, see docs/sensors.md; empty: none'
    )

    def sensors(self) -> SensorRig:
        """Return the sensors of motion, air, field and distance of a vehicle.

        Raises
        ------
        ValueFileError
            If the file cannot be read, naming each mistake.
        """
        return (
            read_values(Path(self.sensors_file), SensorRig) if self.sensors_file else SensorRig()
        )

    def cameras(self) -> tuple[CameraSettings, ...]:
        """Return the cameras of a vehicle; the first takes the photographs of the survey.

        Raises
        ------
        ValueFileError
            If the file cannot be read, naming each mistake.
        ValueError
            If a camera would see the horizon of the flat ground, which has none.
        """
        rig = read_values(Path(self.cameras_file), CameraRig) if self.cameras_file else CameraRig()
        for index, camera in enumerate(rig.cameras):
            if self.camera_backend == ENGINE and (index or camera.gimbal):
                continue
            tilt_deg = 0.0 if camera.gimbal else LARGEST_SWAY_STDS * self.tilt_std_deg
            require_between(
                f'angle of the image corner of cameras[{index}], with tilt, from the vertical',
                camera.steepest_view_deg + tilt_deg,
                0.0,
                LARGEST_VIEW_ANGLE_DEG,
                'deg',
            )
        return rig.cameras


@dataclass(frozen=True, slots=True, kw_only=True)
class RavOptions(VehicleOptions):
    """Options of the node `rav`: one vehicle, named after its namespace."""

    home_latitude_deg: float = option(0.0, 'latitude of its home, deg', -90.0, 90.0)
    home_longitude_deg: float = option(0.0, 'longitude of its home, deg', -180.0, 180.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetVehicle:
    """One vehicle of a fleet.

    Attributes
    ----------
    name
        Name, which is its namespace.
    home
        Latitude and longitude of its home, degrees.
    """

    name: str
    home: tuple[float, float]

    def __post_init__(self) -> None:
        _ = self.home_position

    @property
    def home_position(self) -> GeoPosition:
        """Place at which it stands, on the ground of the mission's origin."""
        return GeoPosition(*self.home, 0.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetVehicles:
    """The vehicles of the node `fleet`, as the file of its parameter `fleet_file` lists them."""

    vehicles: tuple[FleetVehicle, ...]

    def __post_init__(self) -> None:
        _require_names('vehicles', tuple(vehicle.name for vehicle in self.vehicles))


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetOptions(VehicleOptions):
    """Options of the node `fleet`: many vehicles, alike but for names and homes."""

    MOVED_PARAMETERS: ClassVar[Mapping[str, str]] = {
        **VehicleOptions.MOVED_PARAMETERS,
        'vehicles': 'a list in the file that fleet_file names',
        'home_latitudes_deg': 'home in the file that fleet_file names',
        'home_longitudes_deg': 'home in the file that fleet_file names',
    }

    fleet_file: str = option('', 'YAML file of the names and homes of the vehicles')

    def vehicles(self) -> tuple[FleetVehicle, ...]:
        """Return the vehicles.

        Raises
        ------
        ValueFileError
            If the file cannot be read, naming each mistake.
        ValueError
            If no file is named.
        """
        if not self.fleet_file:
            raise ValueError("fleet_file is '': must be the path of a file of vehicles")
        return read_values(Path(self.fleet_file), FleetVehicles).vehicles


def _require_names(option: str, names: tuple[str, ...]) -> None:
    if not all(names) or len(set(names)) < len(names):
        raise ValueError(f'{option} = {list(names)}: names must not be empty and all differ')
