# SPDX-License-Identifier: Apache-2.0
"""Routes drawn over a picture: where the lens says, and behind what hides them."""

import json
import math

import numpy as np
import pytest
import rasterio
import yaml
from rasterio.transform import from_origin

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.command_line.plume_overview import RunPlume, draw_plume, read_plume
from rocsafe_scene.command_line.routes_overview import RunRoutes, draw_routes, read_run
from rocsafe_scene.errors import SceneError

LENS = PinholeCamera(math.radians(90.0), 201, 201)
POSE = (np.array([0.0, 0.0, 100.0]), rotation_enu_from_optical(math.pi / 2))
ORIGIN = GeoPosition(53.28, -9.06, 60.0)


def routes_through(*places) -> RunRoutes:
    """Return one vehicle's plan from home over `places` and back."""
    home = [-80.0, -80.0, 0.0]
    return RunRoutes(ORIGIN, {'rav1': np.array([home, *places, home], float)}, {})


def test_a_viewpoint_is_drawn_where_the_lens_says():
    """At 30 m up, 35 m east of the camera's foot: half way to the right edge of a 90 deg lens."""
    image = np.zeros((201, 201, 3), np.uint8)
    depth = np.full((201, 201), 100.0)
    drawn = draw_routes(image, depth, LENS, POSE, routes_through([35.0, 0.0, 30.0]))
    assert drawn[100, 150].any()
    assert not drawn[100, 50].any()


def test_what_stands_in_front_hides_a_line():
    """Behind a wall that fills the view nothing is drawn."""
    image = np.zeros((201, 201, 3), np.uint8)
    depth = np.full((201, 201), 20.0)
    assert not draw_routes(image, depth, LENS, POSE, routes_through([35.0, 0.0, 30.0])).any()


def test_a_run_is_read(tmp_path):
    """Viewpoints come back as metres about the scenario's origin; readings as they are."""
    frame = LocalFrame(ORIGIN)
    east, north, up = 12.0, -7.0, 32.0
    place = frame.position_of((east, north, up))
    stop = {
        'latitude_deg': place.latitude_deg,
        'longitude_deg': place.longitude_deg,
        'altitude_m': place.altitude_m,
    }
    origin = {'latitude_deg': 53.28, 'longitude_deg': -9.06, 'ground_altitude_m': 60.0}
    (tmp_path / 'scenario.yaml').write_text(yaml.safe_dump({'origin': origin}))
    plan = {'routes': [{'vehicle': 'rav1', 'home': stop, 'viewpoints': [stop, stop]}]}
    (tmp_path / 'plan.json').write_text(json.dumps(plan))
    (tmp_path / 'readings.csv').write_text('vehicle,east_m,north_m,up_m\nrav1,1.0,2.0,3.0\n')
    routes = read_run(tmp_path)
    assert np.allclose(routes.survey, [[east, north, up]] * 2, atol=1e-6)
    assert np.allclose(routes.flown['rav1'], [[1.0, 2.0, 3.0]])


def test_what_is_no_run_is_told_in_one_line(tmp_path):
    """The line names the file that is missing."""
    with pytest.raises(SceneError, match=r'--overview = .*scenario.yaml: No such file'):
        read_run(tmp_path)


def test_a_plume_is_laid_over_what_stands_in_it():
    """Strong 40 to 60 m east of the camera's foot, seen from 100 m up; the sky stays clear."""
    ppm = np.zeros((20, 20))
    ppm[:, 14:16] = 50.0
    plume = RunPlume(ppm, -100.0, 100.0, 10.0)
    image = np.full((201, 201, 3), 100, np.uint8)
    depth = np.full((201, 201), 100.0)
    depth[:20] = np.inf
    drawn = draw_plume(image, depth, LENS, POSE, plume).astype(int)
    assert drawn[100, 150, 2] > 130
    assert (drawn[100, :110] == 100).all()
    assert (drawn[:20] == 100).all()


def test_the_plume_of_a_run_lies_about_its_origin(tmp_path):
    """Its file may have another origin, here 100 m to the north of that of the run."""
    assert read_plume(tmp_path, ORIGIN) is None
    north = LocalFrame(ORIGIN).position_of((0.0, 100.0, 0.0))
    crs = f'+proj=tmerc +lat_0={north.latitude_deg} +lon_0={north.longitude_deg} +datum=WGS84'
    with rasterio.open(
        tmp_path / 'plume.tif', 'w', driver='GTiff', width=4, height=3, count=1,
        dtype='float32', crs=crs, transform=from_origin(-20.0, 15.0, 10.0, 10.0),
    ) as file:  # fmt: skip
        file.write(np.ones((3, 4), np.float32), 1)
    plume = read_plume(tmp_path, ORIGIN)
    assert plume is not None
    assert (plume.west_m, plume.north_m) == pytest.approx((-20.0, 115.0), abs=0.01)
    (tmp_path / 'plume.tif').write_bytes(b'no picture')
    with pytest.raises(SceneError, match='cannot be read'):
        read_plume(tmp_path, ORIGIN)
