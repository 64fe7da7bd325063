# SPDX-License-Identifier: Apache-2.0
"""Options of the node `viewer`."""

import math
from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.option import option
from rocsafe_geo.origin_options import OriginOptions
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.cameras.engine_camera import EngineRequest
from rocsafe_scene.scene.map_cache import default_folder
from rocsafe_sim.flight.sensing_options import LATEST_S


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewerOptions(OriginOptions):
    """Options of the node `viewer`: a live view of the scene of a mission."""

    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles that are shown')
    scene_file: str = option('', 'path of the scene')
    scene_start_s: float = option(0.0, 'start of motion in the scene, s since 1970', 0.0, LATEST_S)
    seed: int = option(1, 'seed of the scene', 0, 2**31 - 1)
    eye_m: tuple[float, ...] = option((0.0, -120.0, 90.0), 'place of the camera: east, north, up')
    target_m: tuple[float, ...] = option((0.0, 0.0, 0.0), 'place at which it looks')
    follow: str = option('', 'vehicle that it is behind; empty: it stays at eye_m')
    width_px: int = option(960, 'width of the view', 64, 4096)
    height_px: int = option(600, 'height of the view', 64, 4096)
    fov_deg: float = option(60.0, 'field of view across the width, deg', 5.0, 150.0)
    rate_hz: float = option(5.0, 'most pictures a second of wall time', 0.1, 60.0)
    window: bool = option(False, 'show it in a window; otherwise on the topic scene/view alone')

    def __post_init__(self) -> None:
        for name in ('eye_m', 'target_m'):
            place = getattr(self, name)
            if len(place) != 3 or not all(map(math.isfinite, place)):
                raise ValueError(f'{name} is {list(place)}: must be three numbers')
        if math.dist(self.eye_m, self.target_m) < 1e-3:
            raise ValueError(f'target_m is {list(self.target_m)}: must differ from eye_m')
        if self.follow and self.follow not in self.vehicles:
            raise ValueError(f'follow is {self.follow!r}: must be one of the vehicles')
        if not self.scene_file:
            raise ValueError("scene_file is '': must be the path of a scene")

    @property
    def lens(self) -> PinholeCamera:
        """Lens of the view."""
        return PinholeCamera(math.radians(self.fov_deg), self.width_px, self.height_px)

    def scene(self) -> EngineRequest:
        """Return the scene that is looked at."""
        return EngineRequest(
            scene_file=Path(self.scene_file), seed=self.seed, origin=self.origin(),
            start_ns=round(self.scene_start_s * NS_PER_S), cache=default_folder(),
        )  # fmt: skip
