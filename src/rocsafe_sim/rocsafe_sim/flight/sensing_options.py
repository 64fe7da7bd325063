# SPDX-License-Identifier: Apache-2.0
"""Options of what simulated vehicles see and measure, in the air and on the ground."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_geo.option import option
from rocsafe_geo.origin_options import OriginOptions
from rocsafe_scene.flat_ground.ground_photograph import NO_SCENE, SCENE_NAMES
from rocsafe_sim.clock.cadence import period_ns

SCENE_GROUND = 'scene'
FLAT, ENGINE = 'flat', 'engine'
# Messages count seconds in 31 bits.
LATEST_S = 2.0**31 - 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class SensingOptions(OriginOptions):
    """Errors of receiver and attitude, the scene, and how a node takes part in a simulation."""

    gps_horizontal_std_m: float = option(0.02, 'GPS error in east and in north, m', 0.0, 100.0)
    gps_vertical_std_m: float = option(0.04, 'GPS error in altitude, m', 0.0, 100.0)
    tilt_std_deg: float = option(0.5, 'sway in roll and in pitch at a photograph, deg', 0.0, 20.0)
    attitude_std_deg: float = option(0.1, 'error of the measured attitude, deg', 0.0, 20.0)
    fix_rate_hz: float = option(5.0, 'rate of fix, velocity and odom, Hz', 0.01, 1e3)
    camera_backend: str = option(FLAT, 'flat: the ground as a picture; engine: a scene in space')
    scene_file: str = option('', 'path of the scene, for the engine')
    scene_start_s: float = option(0.0, 'start of motion in the scene, s since 1970', 0.0, LATEST_S)
    ground: str = option(SCENE_GROUND, 'scene: its photograph, or path of a GeoTIFF')
    scene: str = option(NO_SCENE, f'on the ground scene: {", ".join(SCENE_NAMES)}')
    seed: int = option(1, 'seed of all random numbers', 0, 2**31 - 1)
    spool_directory: str = option('', 'folder of journal and photographs; empty: memory only')
    lock_step: bool = option(True, 'step with the world; otherwise with the wall clock')

    def __post_init__(self) -> None:
        require_positive('fix_rate_hz', self.fix_rate_hz)
        for name in (
            'gps_horizontal_std_m',
            'gps_vertical_std_m',
            'tilt_std_deg',
            'attitude_std_deg',
        ):
            require_not_negative(name, getattr(self, name))
        require_scene(self.scene)
        self._require_backend()

    def _require_backend(self) -> None:
        if self.ground == 'procedural':
            raise ValueError(f"ground is 'procedural': is called {SCENE_GROUND!r} now")
        if self.camera_backend not in (FLAT, ENGINE):
            raise ValueError(
                f'camera_backend is {self.camera_backend!r}: must be {FLAT} or {ENGINE}'
            )
        if self.camera_backend == ENGINE and not self.scene_file:
            raise ValueError(
                "scene_file is '': must be the path of a scene for camera_backend engine"
            )

    @property
    def fix_period_ns(self) -> int:
        """Simulated time between two fixes, nanoseconds."""
        return period_ns(self.fix_rate_hz)


def require_scene(scene: str) -> None:
    """Raise `ValueError` unless there is such a scene."""
    if scene not in SCENE_NAMES:
        raise ValueError(f'scene is {scene!r}: must be one of {", ".join(SCENE_NAMES)}')
