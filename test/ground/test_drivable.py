# SPDX-License-Identifier: Apache-2.0
"""Where a vehicle can drive: things finer than cells, relief, exclusions, ages."""

import json
import math

import numpy as np
import pytest
from test.ground.villages import HALF_M, ORIGIN, PIXEL_M, position, write_bands, write_village

from rocsafe_geo.position import GeoPosition
from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drivable.raster import Bands, read_bands
from rocsafe_ground.drivable.relief import relief_of
from rocsafe_ground.drivable.route_grid import RouteGrid
from rocsafe_ground.drivable.things import distances_m, in_cells, parts_of, thing_parts
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DriveRequest
from rocsafe_ground.drive.ground_map import MapFiles, MapReader, read_ground_map
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.evidence.evidence_point import EvidencePoint
from rocsafe_ground.products.files import write_ground

SIDE_M = 20.0
VEHICLE = GroundVehicle()


def grid_of(cell_m):
    """Return a square grid about the origin."""
    cells = round(SIDE_M / cell_m)
    return RouteGrid(
        origin=ORIGIN, west_m=-SIDE_M / 2, south_m=-SIDE_M / 2, cell_m=cell_m, rows=cells,
        columns=cells,
    )  # fmt: skip


def looks(tmp_path, is_blocked):
    """Return what pixels of 0.1 m look like: blocked where a function of east and north says."""
    middle = np.arange(-HALF_M + 0.05, HALF_M, 0.1)
    east, north = np.meshgrid(middle, middle[::-1])
    blocked = is_blocked(east, north).astype(np.float32)
    write_bands(tmp_path / 'looks.tif', np.stack([blocked, np.ones_like(blocked)]), 0.1)
    return read_bands(tmp_path / 'looks.tif')


@pytest.mark.parametrize('shift', np.linspace(0.0, 0.5, 6).tolist())
def test_small_thing_is_kept_from_wherever_cells_cut_it(tmp_path, shift):
    """A drum of 0.57 m across covers no quarter of a cell much if it lies on a corner of four."""
    shown = looks(tmp_path, lambda east, north: np.hypot(east - shift, north - shift) < 0.285)
    parts = thing_parts(shown, grid_of(0.5), 0.35)
    distance = distances_m(parts, grid_of(0.5))
    east, north = grid_of(0.5).places()
    truth = np.hypot(east - shift, north - shift) - 0.285
    far = truth > 0.3
    assert np.abs(distance - truth)[far].max() < 0.2
    assert in_cells(parts, grid_of(0.5)).any()


def test_thin_tape_is_no_thing(tmp_path):
    """A line of 0.1 m is less than a third of any square of 0.5 m."""
    shown = looks(tmp_path, lambda east, _north: np.abs(east - 3.0) < 0.05)
    assert not thing_parts(shown, grid_of(0.5), 0.35).any()


def test_noise_of_colours_is_no_thing(tmp_path):
    """A pixel in ten: hardly anywhere a third of a square."""
    noise = np.random.default_rng(1)
    shown = looks(tmp_path, lambda east, _north: noise.random(east.shape) < 0.1)
    assert thing_parts(shown, grid_of(0.5), 0.35).mean() < 0.002


@pytest.mark.parametrize('cell_m', [0.25, 0.5, 1.0, 2.0])
def test_cells_of_any_size_keep_the_clearance_of_the_driver(cell_m):
    """Also half way between the middles of two free cells."""
    kept = VEHICLE.kept_m(cell_m)
    assert kept >= VEHICLE.reach_m
    assert kept**2 - (0.5 * cell_m) ** 2 >= VEHICLE.clearance_m**2 - 1e-9


class Heights:
    """An elevation model by a function of the cell's number."""

    def __init__(self, heights):
        self.heights = heights

    def altitudes_m(self, _latitudes, _longitudes):
        """Return the heights of all cells."""
        return self.heights.ravel()


def test_plane_is_not_rough_and_rubble_is():
    """However steep the plane is; roughness is the deviation about it."""
    grid = grid_of(0.5)
    east, north = grid.places()
    plane = 80.0 + 0.3 * east - 0.2 * north
    assert relief_of(Heights(plane), grid, VEHICLE).roughness_m[2:-2, 2:-2].max() < 1e-6
    rubble = plane + np.random.default_rng(2).normal(0.0, 0.1, plane.shape)
    found = relief_of(Heights(rubble), grid, VEHICLE).roughness_m[2:-2, 2:-2]
    # Three of nine degrees of freedom are those of the plane.
    assert np.sqrt((found**2).mean()) == pytest.approx(0.1 * np.sqrt(6.0 / 9.0), rel=0.05)


def terrain_of(folder, roughness_m):
    """Write an elevation model that is rough in the east."""
    middle = np.arange(-HALF_M + PIXEL_M, HALF_M, 2 * PIXEL_M)
    east, _ = np.meshgrid(middle, middle)
    noise = np.random.default_rng(3).normal(0.0, 1.0, east.shape)
    heights = np.where(east > 0.0, 60.0 + roughness_m * noise, 60.0).astype(np.float32)
    write_bands(folder / 'terrain.tif', heights[None], 2 * PIXEL_M)
    return folder / 'terrain.tif'


@pytest.mark.slow
def test_rough_ground_is_slow_and_rougher_ground_is_not_driven(tmp_path):
    """Up to a quarter of the highest step."""
    folder = write_village(tmp_path)
    level = read_ground_map(MapFiles(folder=folder), VEHICLE, 0.5, 1e5)
    uneven, rubble = (
        read_ground_map(
            MapFiles(folder=folder, terrain=terrain_of(folder, rough)), VEHICLE, 0.5, 1e5
        )
        for rough in (0.015, 0.15)
    )
    east, _ = level.grid.places()
    is_both = (east > 2.0) & level.is_free & uneven.is_free
    slower = uneven.ground.slowness_spm[is_both] / level.ground.slowness_spm[is_both]
    assert is_both.sum() > 1000
    assert 1.05 < slower.mean() < 1.6
    assert not (rubble.is_free & (east > 2.0)).any()
    assert (rubble.reasons == Reason.ROUGH).sum() > 1000
    assert (rubble.is_free == level.is_free)[east < -2.0].all()


def exclusion(*corners):
    """Return a feature as a plan has it, and one of a region that is no exclusion."""
    ring = [(place.longitude_deg, place.latitude_deg) for place in (position(*c) for c in corners)]
    shape = {'type': 'Polygon', 'coordinates': [[*ring, ring[0]]]}
    return [
        {'type': 'Feature', 'geometry': shape, 'properties': {'kind': kind}}
        for kind in ('exclusion', 'region')
    ]


def test_exclusions_of_the_plan_of_a_run_are_not_entered(tmp_path):
    """As zones of an operator; the region of the survey is none."""
    folder = write_village(tmp_path)
    zone, region = exclusion((-30.0, -30.0), (-10.0, -30.0), (-10.0, -10.0), (-30.0, -10.0))
    plan = folder / 'plan.geojson'
    plan.write_text(json.dumps({'type': 'FeatureCollection', 'features': [region]}))
    reader = MapReader()
    assert reader.read(MapFiles(folder=folder), VEHICLE, 0.5, 1e5).is_free.any()
    plan.write_text(json.dumps({'type': 'FeatureCollection', 'features': [zone, region]}))
    ground = reader.read(MapFiles(folder=folder), VEHICLE, 0.5, 1e5)
    east, north = ground.grid.places()
    is_in = (np.abs(east + 20.0) < 10.0) & (np.abs(north + 20.0) < 10.0)
    assert (ground.reasons[is_in] == Reason.KEEP_OUT).all()
    assert ground.is_free[~is_in].any()
    plan.write_text('{"features": 3}')
    with pytest.raises(ValueError, match=r'plan\.geojson: cannot be read'):
        reader.read(MapFiles(folder=folder), VEHICLE, 0.5, 1e5)


def test_ground_is_kept_while_only_dose_rates_change(tmp_path):
    """A new dose map costs no new look at the mosaic."""
    folder, reader = write_village(tmp_path), MapReader()
    first = reader.read(MapFiles(folder=folder), VEHICLE, 0.5, 1e5)
    write_village(tmp_path / 'other', source=(5.0, 5.0))
    (tmp_path / 'other' / 'sources.json').replace(folder / 'sources.json')
    (tmp_path / 'other' / 'dose_map.tif').replace(folder / 'dose_map.tif')
    second = reader.read(MapFiles(folder=folder), VEHICLE, 0.5, 1e5)
    assert second.ground is first.ground
    assert (second.field.mean_usvh != first.field.mean_usvh).any()


@pytest.mark.slow
def test_age_of_each_cell_is_known(tmp_path):
    """That of the oldest photograph that a drive relies on, too."""
    folder = write_village(tmp_path)
    side = round(2.0 * HALF_M)
    ages = np.zeros((side, side), np.float32)
    ages[:, : side // 2] = 600.0
    untold = np.full_like(ages, np.nan)
    (folder / 'map').mkdir()
    write_bands(folder / 'map' / 'error.tif', np.stack([untold, untold, ages]), 1.0)
    ground = read_ground_map(MapFiles(folder=folder), VEHICLE, 0.5, 1e5)
    plans = [
        plan_drive(
            DriveRequest(
                start=position(east, -20.0), dose_budget_usv=1e6, curve_points=0,
                evidence=(EvidencePoint(id='m', position=position(20.0, -25.0)),),
            ),
            ground,
        )
        for east in (10.0, -10.0)
    ]  # fmt: skip
    assert [plan.oldest_s for plan in plans] == [0.0, 600.0]
    write_ground(tmp_path / 'ground.tif', ground)
    written: Bands = read_bands(tmp_path / 'ground.tif')
    west, east = written.values[4][:, :70], written.values[4][:, 90:]
    assert np.nanmax(np.abs(west - 600.0)) == 0.0
    assert np.nanmax(east) == 0.0


@pytest.mark.parametrize(('cell_m', 'parts'), [(0.05, 1), (0.2, 1), (0.5, 3), (1.0, 5)])
def test_parts_of_cells_are_about_as_large_in_every_grid(cell_m, parts):
    """Their number is odd: the middle of a cell is the middle of a part."""
    assert parts_of(grid_of(cell_m)) == parts


@pytest.mark.parametrize('reach_m', [0.0, 0.6, 3.0, math.inf])
@pytest.mark.parametrize('place', [(0.0, 0.0), (-4.9, 6.1), (30.0, 0.0), (-1.2, -40.0)])
def test_cells_within_reach_are_those_of_the_whole_grid(place, reach_m):
    """Also where the circle leaves the grid, or the place is beyond it."""
    grid = RouteGrid(
        origin=GeoPosition(53.28, -9.06, 0.0), west_m=-5.0, south_m=-7.0, cell_m=0.5,
        rows=28, columns=20,
    )  # fmt: skip
    east, north = grid.places()
    distances = np.hypot(east - place[0], north - place[1]).ravel()
    cells, found = grid.cells_within(*place, reach_m)
    assert cells.tolist() == np.flatnonzero(distances <= reach_m).tolist()
    assert found == pytest.approx(distances[cells])
