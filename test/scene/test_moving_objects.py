# SPDX-License-Identifier: Apache-2.0
"""What moves in a scene is seen by a mission's photographs where it is at their time."""

import math

import numpy as np
import pytest
from test.scene.scenes import small_environment
from test.sim.flights import ROUTE, START_NS
from test.sim.vehicle_files import cameras_file

from rocsafe_geo.position import GeoPosition
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.options import RavOptions

pytest.importorskip('panda3d', reason='panda3d is not installed')
from rocsafe_scene.cameras import engine_camera
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.shared_parts import make_shared

# Crosses the route's viewpoints, which are photographed within a minute and a half.
PATH = (
    {'time_s': 0.0, 'at': (-8.0, 10.0)},
    {'time_s': 60.0, 'at': (20.0, 10.0)},
    {'time_s': 120.0, 'at': (20.0, 20.0)},
)
VAN = {'name': 'van', 'make': 'ambulance', 'at': (0.0, 0.0), 'path': PATH}


SMALL = {'image_width_px': 160, 'image_height_px': 120}


def pictures_of_a_flight(monkeypatch, tmp_path):
    """Return the scene and all pictures of a flight over it."""
    environment = small_environment(VAN, relief_m=0.0)
    monkeypatch.setattr(engine_camera, 'read_scene', lambda _path: environment.description)
    monkeypatch.setattr(engine_camera, 'build', lambda *_arguments: environment)
    options = RavOptions(
        camera_backend='engine', scene_file='a scene', scene_start_s=START_NS / 1e9,
        cameras_file=cameras_file(tmp_path, {**SMALL, 'oversampling': 1}),
        origin_latitude_deg=53.28, tilt_std_deg=0.0,
    )  # fmt: skip
    home = options.frame().position_of(ROUTE.home_enu)
    place = GeoPosition(home.latitude_deg, home.longitude_deg, 0.0)
    rav = make_rav(options, 'rav1', place, make_shared(options), None)
    rav.step(START_NS)
    rav.vehicle.fly_route(ROUTE)
    pictures = []
    while rav.vehicle.summary() is None and rav.vehicle.time_ns < START_NS + 300 * 10**9:
        rav.step(rav.vehicle.time_ns + 5 * 10**8)
        pictures += rav.pictures
    return environment, pictures


@pytest.mark.slow
def test_photographs_show_moving_things_where_they_are(drawing, monkeypatch, tmp_path):
    """The centroid of the van's pixels is the place of its path at the time of each exposure."""
    environment, pictures = pictures_of_a_flight(monkeypatch, tmp_path)
    assert len(pictures) == len(ROUTE.waypoints)
    van, seen = environment.objects[0], []
    for picture in pictures:
        place, _ = van.path.shift_at((picture.time_ns - START_NS) / 1e9)
        rows, columns = np.nonzero(picture.truth.numbers == van.number)
        if len(rows):
            lens = CameraSettings(**SMALL).lens
            depth = picture.truth.depth_m[rows, columns]
            pixels = np.stack([columns, rows, np.ones(len(rows))]) * depth
            world = picture.rotation_enu_from_optical @ np.linalg.solve(lens.matrix, pixels)
            middle = world.mean(axis=1) + picture.position_enu
            assert math.dist(middle[:2], place[:2]) < 1.5
            seen.append(tuple(place[:2].tolist()))
    assert len(seen) >= 2
    assert max(math.dist(a, b) for a in seen for b in seen) > 4.0
