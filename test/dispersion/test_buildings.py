# SPDX-License-Identifier: Apache-2.0
"""Wind around buildings and hills: air is conserved, walls stop it, houses shelter."""

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from rocsafe_dispersion.buildings.building_wind import building_wind, wind_around
from rocsafe_dispersion.buildings.site_box import site_box
from rocsafe_dispersion.buildings.voxels import solid_cells
from rocsafe_dispersion.buildings.wakes import Block, blocks_of
from rocsafe_dispersion.command_line.site_wind_command import main as site_wind
from rocsafe_dispersion.plume.carriers import Carriers, Parcels
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.scene_solids import SceneSolids, Thing
from rocsafe_geo.solids.solids_file import write_solids
from rocsafe_geo.terrain.height_grid import GridFrame, HeightGrid
from rocsafe_geo.wind.air_grid import AirGrid
from rocsafe_geo.wind.gusts import GustyWind
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.site_wind import SitePattern, SiteWind
from rocsafe_geo.wind.site_wind_file import read_pattern, write_pattern
from rocsafe_geo.wind.wind_field import ProfileWind
from rocsafe_geo.wind.wind_vector import WindVector

GRID = AirGrid(
    west_m=-60.0, south_m=-40.0, bottom_m=0.0, cell_m=2.0, layer_m=2.0, columns=80, rows=40,
    layers=20,
)  # fmt: skip
WIND = ProfileWind(
    layer=SurfaceLayer(friction_velocity_mps=0.4, roughness_m=0.1),
    wind=WindVector(towards_east_mps=5.0, towards_north_mps=0.0),
)
FLAT = np.zeros((GRID.columns, GRID.rows))


def house() -> np.ndarray:
    """Return the cells of a house of 10 x 16 x 10 m around the origin."""
    solid = np.zeros(GRID.shape, bool)
    solid[28:33, 16:24, :5] = True
    return solid


def box_thing(low: tuple[float, float, float], high: tuple[float, float, float]) -> Thing:
    """Return a closed box."""
    corners = np.array([[(low, high)[k >> i & 1][i] for i in range(3)] for k in range(8)])
    quads = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]
    triangles = [corners[[a, b, c]] for q in quads for a, b, c in (q[:3], (q[0], *q[2:]))]
    return Thing(name='box', material='brick', fill=0.1, corners_enu_m=np.float32(triangles))


def ground(height: float = 0.0, slope: float = 0.0) -> HeightGrid:
    """Return a plain that rises to the east."""
    frame = GridFrame(west_m=-100.0, south_m=-100.0, cell_m=50.0, columns=6, rows=5)
    east = -100.0 + 50.0 * np.arange(6)
    return HeightGrid(frame, np.tile(height + slope * east, (5, 1)))


def site(pattern: SitePattern, wind: ProfileWind = WIND) -> SiteWind:
    """Return the wind on a site."""
    return SiteWind(pattern=pattern, open_wind=wind)


@pytest.mark.parametrize('towards', [(5.0, 0.0), (-2.0, 3.0), (0.0, -8.0)])
def test_no_air_is_lost_and_none_enters_a_wall(towards: tuple[float, float]):
    """The divergence is at most 1e-3 of the speed over the cell size; walls have no flow."""
    wind = ProfileWind(
        layer=WIND.layer,
        wind=WindVector(towards_east_mps=towards[0], towards_north_mps=towards[1]),
    )
    solid = house()
    pattern = wind_around(GRID, solid, FLAT, wind)
    for faces in (pattern.east, pattern.north):
        speed = max(np.abs(part).max() for part in faces.parts)
        assert np.abs(faces.divergence(GRID)[~solid]).max() <= 1e-3 * speed / GRID.cell_m
        assert not faces.east[28:34, 16:24, :5].any()
        assert not faces.north[28:33, 16:25, :5].any()
        assert not faces.up[28:33, 16:24, :6].any()
        assert not faces.up[:, :, 0].any()


def test_flow_through_planes_is_the_same():
    """What enters in the west and through the other sides leaves in the east."""
    faces = wind_around(GRID, house(), FLAT, WIND).east
    area = GRID.cell_m * GRID.layer_m
    enters = faces.east[0].sum() * area + faces.north[:, 0].sum() * area
    leaves = faces.east[-1].sum() * area + faces.north[:, -1].sum() * area
    leaves += faces.up[:, :, -1].sum() * GRID.cell_m**2
    assert leaves == pytest.approx(enters, rel=1e-3)


def test_wind_over_a_plain_stays_as_it_is():
    """Without buildings nothing is to be corrected, at any height, in any wind, gusts included."""
    pattern = wind_around(GRID, np.zeros(GRID.shape, bool), FLAT, WIND)
    places = np.array([[0.0, 0.0, 0.5], [0.0, 0.0, 5.0], [20.0, 10.0, 15.9]])
    other = replace(WIND, wind=WindVector(towards_east_mps=-1.0, towards_north_mps=3.0))
    for wind in (WIND, other):
        found = site(pattern, wind).velocities_mps(0.0, places)
        assert found == pytest.approx(wind.velocities_mps(0.0, places), rel=0.02, abs=2e-3)


def test_house_shelters_and_channels():
    """Behind it the air flows back or slowly, beside and above it faster than before."""
    wind = site(wind_around(GRID, house(), FLAT, WIND))
    places = np.array([[12.0, 0.0, 3.0], [1.0, 12.0, 3.0], [1.0, 0.0, 13.0]])
    free = WIND.velocities_mps(0.0, places)[:, 0]
    found = wind.velocities_mps(0.0, places)[:, 0]
    assert found[0] < 0.3 * free[0]
    assert found[1] > 1.05 * free[1]
    assert found[2] > free[2]


def test_gusts_do_not_blow_through_walls():
    """Within a house nothing moves, whatever the wind does."""
    gusty = GustyWind(mean=WIND, sigma_east_mps=3.0, sigma_north_mps=3.0, seed=4)
    wind = site(wind_around(GRID, house(), FLAT, WIND), gusty)
    found = [wind.velocities_mps(time, np.array([[0.9, 0.1, 4.0]])) for time in (0.0, 40.0)]
    assert not np.any(found)
    beside = [wind.velocities_mps(time, np.array([[-50.0, 20.0, 4.0]])) for time in (0.0, 40.0)]
    assert np.abs(beside[0] - beside[1]).max() > 0.1


def test_beyond_the_box_the_wind_is_undisturbed():
    """Also above it."""
    wind = site(wind_around(GRID, house(), FLAT, WIND))
    places = np.array([[500.0, 0.0, 3.0], [0.0, 0.0, 80.0]])
    assert np.array_equal(wind.velocities_mps(0.0, places), WIND.velocities_mps(0.0, places))


def test_pattern_survives_its_file(tmp_path: Path):
    """All of it; another file is refused in one line."""
    pattern = wind_around(GRID, house(), FLAT, WIND)
    file = tmp_path / 'wind.npz'
    write_pattern(file, pattern)
    places = np.random.default_rng(1).uniform((-60, -40, 0), (100, 40, 40), (200, 3))
    found = site(read_pattern(file)).velocities_mps(0.0, places)
    assert np.array_equal(found, site(pattern).velocities_mps(0.0, places))
    for broken in ({'format': np.array('x')}, {'floor': np.zeros(3)}, {'east_0': np.zeros(2)}):
        with np.load(file) as arrays:
            np.savez(tmp_path / 'broken.npz', **{**arrays, **broken})
        with pytest.raises(ValueError, match=r'^wind .*broken.npz: .*must') as caught:
            read_pattern(tmp_path / 'broken.npz')
        assert '\n' not in str(caught.value)
    file.write_bytes(b'PK no archive')
    with pytest.raises(ValueError, match=r'wind .*wind.npz'):
        read_pattern(file)
    with pytest.raises(ValueError, match=r'no such file'):
        read_pattern(tmp_path / 'gone.npz')


def caught_at(released_m: tuple[float, float]) -> Parcels:
    """Return the parcels after four minutes of a release upwind of a house or in its lee."""
    wind = site(wind_around(GRID, house(), FLAT, WIND))
    release = Release(place_m=released_m, height_m=1.0, rate_g_s=1.0)
    travel = similarity_travel(WIND.layer, 1.0)
    return Carriers(release, travel, wind, 1.0, 600.0).at(240.0)


@pytest.mark.slow
def test_gas_goes_round_a_house_and_leaves_its_lee():
    """No parcel ends within its walls; what is released in the lee is gone after two minutes."""
    upwind, lee = caught_at((-30.0, 1.0)), caught_at((8.0, 0.0))
    for parcels in (upwind, lee):
        east, north = parcels.places_m.T
        is_within = (np.abs(east - 1.0) < 4.0) & (np.abs(north) < 7.0)
        assert not is_within.any()
        assert (east[:120] > 100.0).all()
        assert parcels.masses_g.sum() == pytest.approx(240.0, rel=1e-6)
    # The open wind would carry them straight on.
    passing = np.abs(upwind.places_m[:, 0] - 1.0) < 4.0
    assert (np.abs(upwind.places_m[passing, 1]) > 7.0).all()


def test_back_flow_has_the_length_of_the_formula():
    """A cube: 1.8 / 1.24 heights; a long wall: 1.8 W / (0.3^0.3 (1 + 0.24 W/H))."""
    cube = Block(along_m=0, across_m=0, length_m=10.0, width_m=10.0, height_m=10.0)
    assert cube.cavity_m == pytest.approx(14.516, abs=1e-3)
    wall = Block(along_m=0, across_m=0, length_m=1.0, width_m=100.0, height_m=10.0)
    assert wall.cavity_m == pytest.approx(180.0 / (0.3**0.3 * 3.4), rel=1e-6)


def test_houses_are_told_apart():
    """Each with its own size."""
    heights = np.zeros((GRID.columns, GRID.rows))
    heights[10:15, 10:14], heights[40:42, 20:30] = 6.0, 9.0
    found = list(blocks_of(GRID, heights, WIND.wind))
    sizes = [(one.length_m, one.width_m, one.height_m) for one in found]
    assert sizes == [(10.0, 8.0, 6.0), (4.0, 20.0, 9.0)]


def test_scene_becomes_cells():
    """Ground and things fill the cells that they reach."""
    thing = box_thing((-9.9, -5.9, 1.0), (9.9, 5.9, 8.9))
    solids = SceneSolids(
        origin=GeoPosition(53.0, -9.0, 50.0), things=(thing,), ground=(ground(2.0),)
    )
    solid = solid_cells(GRID, solids)
    east, north, up = GRID.middles_m()
    expected = (up < 2.0) | (
        (np.abs(east) < 10.0)[:, None, None] & (np.abs(north) < 6.0)[:, None] & (up < 9.0)
    )
    assert np.array_equal(solid, expected)


def test_wind_follows_the_ground():
    """Over a slope it rises, and heights are those above the ground."""
    solids = SceneSolids(
        origin=GeoPosition(53.0, -9.0, 50.0), things=(), ground=(ground(8.0, 0.1),)
    )
    wind = site(building_wind(GRID, solids, WIND))
    found = wind.velocities_mps(0.0, np.array([[0.0, 0.0, 6.0], [0.0, 0.0, 12.0]]))
    assert (found[:, 2] > 0.02 * found[:, 0]).all()
    assert (found[:, 2] < 0.2 * found[:, 0]).all()
    assert wind.ground_up_m(np.array([[1.0, 1.0], [500.0, 0.0]])) == pytest.approx([8.1, 0.0])
    low = wind.velocities_mps(0.0, np.array([[x, 1.0, 0.3] for x in (-20.0, -7.0, 1.0, 9.0)]))
    assert (low[:, 0] > 0.5).all()  # the steps of the cells hold no air up


def test_fences_and_people_do_not_hold_the_air_up():
    """A house does."""
    fence = box_thing((-20.0, 10.0, 0.0), (20.0, 10.1, 2.0))
    person = box_thing((0.0, 20.0, 0.0), (0.5, 20.5, 1.8))
    hut = box_thing((-3.9, -19.9, 0.0), (3.9, -12.1, 3.9))
    solids = SceneSolids(
        origin=GeoPosition(53.0, -9.0, 50.0), things=(fence, person, hut), ground=(ground(),)
    )
    solid = solid_cells(GRID, solids)
    north = np.broadcast_to(GRID.middles_m()[1][:, None], solid.shape)[solid]
    assert solid.any()
    assert (north < -12.0).all()


def test_box_reaches_beyond_things_and_has_larger_cells_on_a_large_site():
    """Five heights beyond, three above; 40,000 columns at most."""
    near = box_thing((-5.0, -5.0, 0.0), (5.0, 5.0, 10.0))
    far = box_thing((795.0, 595.0, 0.0), (805.0, 605.0, 9.0))
    origin = GeoPosition(53.0, -9.0, 50.0)
    small = site_box(SceneSolids(origin=origin, things=(near,), ground=(ground(),)))
    assert (small.west_m, small.south_m, small.cell_m) == (-55.0, -55.0, 2.0)
    assert small.shape == (55, 55, 20)
    large = site_box(SceneSolids(origin=origin, things=(near, far), ground=(ground(),)))
    assert large.cell_m > 2.0
    assert large.columns * large.rows <= 41_000
    empty = site_box(SceneSolids(origin=origin, things=(), ground=(ground(4.0),)))
    assert empty.columns * empty.cell_m >= 250.0


def test_command_writes_the_wind_of_a_file_of_solids(tmp_path: Path, capsys):
    """And says in one line what is wrong with its values."""
    hut = box_thing((-3.9, -19.9, 0.0), (3.9, -12.1, 3.9))
    solids = SceneSolids(origin=GeoPosition(53.0, -9.0, 50.0), things=(hut,), ground=(ground(),))
    write_solids(tmp_path / 'solids.npz', solids)
    given = [str(tmp_path / 'solids.npz'), '--out', str(tmp_path / 'wind.npz'), '--towards']
    assert site_wind([*given, '-3.0', '1.0', '--stability', 'B']) == 0
    assert read_pattern(tmp_path / 'wind.npz').layer.obukhov_length_m < 0.0
    capsys.readouterr()
    for values, named in (
        (['0', '0'], 'at least 0.5 m/s'),
        (['nan', '1'], 'towards_east_mps'),
        (['3', '1', '--cell', '0'], 'cell'),
        (['3', '1', '--roughness', '9'], 'roughness_m'),
    ):
        assert site_wind([*given, *values]) == 2
        error = capsys.readouterr().err
        assert named in error
        assert error.count('\n') == 1


@pytest.mark.parametrize(
    'make',
    [
        lambda: AirGrid(
            west_m=0, south_m=0, bottom_m=0, cell_m=0, layer_m=1, columns=9, rows=9, layers=9
        ),
        lambda: AirGrid(
            west_m=math.nan,
            south_m=0,
            bottom_m=0,
            cell_m=1,
            layer_m=1,
            columns=9,
            rows=9,
            layers=9,
        ),
        lambda: AirGrid(
            west_m=0,
            south_m=0,
            bottom_m=0,
            cell_m=1,
            layer_m=1,
            columns=2000,
            rows=2000,
            layers=99,
        ),
        lambda: wind_around(GRID, np.ones(GRID.shape, bool), FLAT, WIND),
        lambda: wind_around(
            GRID,
            house(),
            FLAT,
            ProfileWind(
                layer=WIND.layer, wind=WindVector(towards_east_mps=0.0, towards_north_mps=0.0)
            ),
        ),
    ],
)
def test_bad_values_are_refused(make):
    """With one error type."""
    with pytest.raises(ValueError, match=r'must|raise its top'):
        make()
