# SPDX-License-Identifier: Apache-2.0
"""Options of the node `rgv`: one simulated ground vehicle."""

from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.limits import require_between, require_not_negative
from rocsafe_geo.option import option
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.value_file import read_values
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.driving.chassis import Chassis
from rocsafe_sim.flight.sensing_options import FLAT, SensingOptions

# Over the flat ground the camera must not see the horizon: there is none.
FLAT_PITCH_DEG, SCENE_PITCH_DEG = -50.0, -15.0
FLAT_FOV_DEG = 35.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RgvOptions(SensingOptions):
    """Options of the node `rgv`: one ground vehicle, named after its namespace."""

    home_latitude_deg: float = option(0.0, 'latitude of its home, deg', -90.0, 90.0)
    home_longitude_deg: float = option(0.0, 'longitude of its home, deg', -180.0, 180.0)
    mast_m: float = option(
        1.0, 'height of receiver, detectors and camera above the ground, m', 0.1, 5.0
    )
    reading_period_s: float = option(
        0.2, 'time between two readings of its detector, s; 0: it has none', 0.0, 60.0
    )
    gas_sensors: tuple[str, ...] = option((), 'names of its gas sensors')
    gas_period_s: float = option(1.2, 'time between two readings of each, s', 0.01, 700.0)
    width_m: float = option(0.7, 'width across the tracks, m', 0.1, 10.0)
    endurance_s: float = option(8000.0, 'driving time on a full battery, s', 1.0, 604_800.0)
    camera_file: str = option('', 'YAML file of its camera, see docs/cameras.md; empty: forward')

    def __post_init__(self) -> None:
        # Not super(): with slots the class is made a second time.
        SensingOptions.__post_init__(self)
        require_between('mast_m', self.mast_m, 0.1, 5.0, 'm')
        require_not_negative('reading_period_s', self.reading_period_s, 's')
        self.chassis()

    @property
    def home(self) -> GeoPosition:
        """Place at which it stands, on the ground of the mission's origin."""
        return GeoPosition(self.home_latitude_deg, self.home_longitude_deg, 0.0)

    def chassis(self) -> Chassis:
        """Return its chassis."""
        return Chassis(width_m=self.width_m, endurance_s=self.endurance_s)

    def camera(self) -> CameraSettings:
        """Return its camera.

        Raises
        ------
        ValueFileError
            If its file cannot be read, naming each mistake.
        """
        if self.camera_file:
            return read_values(Path(self.camera_file), CameraSettings)
        if self.camera_backend == FLAT:
            return CameraSettings(pitch_deg=FLAT_PITCH_DEG, horizontal_fov_deg=FLAT_FOV_DEG)
        return CameraSettings(pitch_deg=SCENE_PITCH_DEG)
