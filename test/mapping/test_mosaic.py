# SPDX-License-Identifier: Apache-2.0
"""The map shows the ground where it is: marks of known position, photographs by geometry."""

import dataclasses
import importlib.util
import math
import pathlib

import cv2
import numpy as np
import pyproj
import pytest
import rasterio

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.errors import MappingError, PlacementError
from rocsafe_mapping.live.preview import Preview
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions
from rocsafe_mapping.products.cog import write_cog

_spec = importlib.util.spec_from_file_location(
    'ground', pathlib.Path(__file__).with_name('ground.py')
)
ground_truth = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(ground_truth)

RESOLUTION_M = 0.1
ROOM = 25_000_000
MARKS = ((-9.0, 6.0), (0.0, -4.0), (11.0, 8.0), (20.0, -7.0), (31.0, 5.0))
# Far from the middle of their zones, where the grid is turned against north by 1.5 to 2.4 degrees.
ORIGINS = {
    'north-west': (53.28, -11.9),
    'north-east': (40.71, 74.0 + 3.9),
    'south-east': (-33.86, 150.1),
    'south-west': (-54.8, -68.3),
}
# Pixels of the map: positions of marks by centre of mass, photographs of 11 cm a pixel.
LARGEST_ERROR_PX = 0.5


def ground_at(latitude, longitude, marks=MARKS):
    """Return marked ground 57 m above the ellipsoid."""
    return ground_truth.Ground(LocalFrame(GeoPosition(latitude, longitude, 57.0)), marks)


GALWAY = ground_at(53.28, -9.06)


def mosaic_of(shots, notice=lambda _text: None, **options):
    """Return the maker of a map of photographs, each where its fix says."""
    maker = Mapmaker(
        MapOptions(**{'ground_resolution_m': RESOLUTION_M, 'max_pixels': ROOM, **options}), notice
    )
    for record, jpeg in shots:
        maker.add(record, lambda jpeg=jpeg: jpeg)
    return maker


def write_geotiff(maker, path):
    """Write the map as it lies now."""
    renderer = maker.renderer()
    write_cog(path, renderer.grid, renderer.window, renderer.tiles())
    return renderer


def pixels_of(maker):
    """Return the map's pixels over its window, (height, width, 4), and the renderer."""
    renderer = maker.renderer()
    window = renderer.window
    rgba = np.zeros((window.height, window.width, 4), np.uint8)
    for tile, part in renderer.tiles():
        shared = tile.cut(window)
        rgba[shared.within(window)] = part[shared.within(tile)]
    return rgba, renderer


def three_photographs(ground):
    """Return photographs with yaw and tilt that show all marks between them."""
    return [
        ground.photograph(0, -3.0, 1.0, yaw=0.3, pitch=0.04, roll=-0.05),
        ground.photograph(1, 12.0, -2.0, yaw=2.0, pitch=-0.03, roll=0.06),
        ground.photograph(2, 26.0, 1.0, yaw=-1.2, pitch=0.05, roll=0.02),
    ]


def column_and_row_of_mark(grey, expected, reach=15):
    """Return the centre of mass of the mark near pixel `expected` (column, row)."""
    column, row = (round(part) for part in expected)
    patch = grey[row - reach : row + reach + 1, column - reach : column + reach + 1].astype(float)
    weights = np.maximum(patch - ground_truth.GROUND_LEVEL - 20.0, 0.0)
    rows, columns = np.mgrid[row - reach : row + reach + 1, column - reach : column + reach + 1]
    return np.sum(weights * columns) / weights.sum(), np.sum(weights * rows) / weights.sum()


@pytest.mark.slow
@pytest.mark.parametrize('place', ORIGINS)
def test_marks_lie_where_they_are_in_the_geotiff(tmp_path, place):
    """Within half a pixel, by PROJ's own transformation, in all four quadrants."""
    ground = ground_at(*ORIGINS[place])
    path = tmp_path / 'mosaic.tif'
    write_geotiff(mosaic_of(three_photographs(ground)), path)
    with rasterio.open(path) as file:
        grey, to_pixel = file.read(1), ~file.transform
        utm = pyproj.Transformer.from_crs(4326, file.crs.to_epsg(), always_xy=True)
    for mark in MARKS:
        latitude, longitude = ground.geodetic(*mark)
        # Rasterio counts pixels from their corners, arrays from their centres.
        column, row = (part - 0.5 for part in to_pixel @ utm.transform(longitude, latitude))
        found = column_and_row_of_mark(grey, (column, row))
        assert found == pytest.approx((column, row), abs=LARGEST_ERROR_PX), mark


def test_a_turned_grid_would_be_seen(tmp_path):
    """The proof above is worth something: ignoring convergence would miss by many pixels."""
    latitude, longitude = ORIGINS['north-west']
    proj = pyproj.Proj(32629)
    convergence = math.radians(proj.get_factors(longitude, latitude).meridian_convergence)
    assert abs(20.0 * math.sin(convergence)) / RESOLUTION_M > 5.0 * LARGEST_ERROR_PX


def test_the_file_is_a_tiled_geotiff_with_alpha_and_overviews(tmp_path):
    """As geographic information systems want it."""
    path = tmp_path / 'new' / 'mosaic.tif'
    renderer = write_geotiff(mosaic_of(three_photographs(GALWAY)), path)
    with rasterio.open(path) as file:
        assert file.crs.to_epsg() == 32629
        assert file.block_shapes[0] == (512, 512)
        assert file.compression is rasterio.enums.Compression.deflate
        assert file.colorinterp[3] is rasterio.enums.ColorInterp.alpha
        assert file.overviews(1) == [2]
        assert file.res == pytest.approx((RESOLUTION_M, RESOLUTION_M))
        alpha = file.read(4)
    assert set(np.unique(alpha)) == {0, 255}
    assert alpha.shape == (renderer.window.height, renderer.window.width)
    assert [item.name for item in path.parent.iterdir()] == ['mosaic.tif']


def test_coverage_is_the_area_of_the_footprint():
    """One level photograph of 36.95 m x 27.71 m, to two percent."""
    rgba, _ = pixels_of(mosaic_of([ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0)]))
    width_m, height_m = ground_truth.CAMERA.footprint_m(ground_truth.HEIGHT_M)
    covered_m2 = np.count_nonzero(rgba[..., 3]) * RESOLUTION_M**2
    assert covered_m2 == pytest.approx(width_m * height_m, rel=0.02)


def test_the_most_nadir_photograph_wins_and_the_seam_is_narrow():
    """20 m apart: each keeps its own half; exposures are made alike on the way."""
    shots = [
        ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0, grey=90, yaw=math.pi / 2),
        ground_truth.plain_photograph(GALWAY, 1, 20.0, 0.0, grey=120, yaw=math.pi / 2),
    ]
    rgba, renderer = pixels_of(mosaic_of(shots))
    row = rgba[rgba.shape[0] // 2, :, 0].astype(int)
    assert np.abs(np.diff(row[row > 0])).max() < 10
    labels = renderer.owners[renderer.owners.shape[0] // 2]
    middle, left_edge = np.argmax(labels == 1), np.argmax(labels == 0)
    # The west edge of the first photograph is 18.5 m west; the seam is 10 m east of its centre,
    # free to move by the slack.
    assert (middle - left_edge) * renderer.cell_m == pytest.approx(28.5, abs=9.0)


def test_a_map_too_large_gets_coarser_and_shows_the_same():
    """With one notice; nothing is left out."""
    notices = []
    shots = [ground_truth.plain_photograph(GALWAY, n, 40.0 * n, 0.0, grey=90) for n in range(4)]
    rgba, renderer = pixels_of(mosaic_of(shots, max_pixels=300_000, notice=notices.append))
    assert renderer.grid.resolution_m == 2 * RESOLUTION_M
    assert renderer.window.width * renderer.window.height <= 300_000
    assert len(notices) == 1
    assert 'the map would exceed 300000 pixels' in notices[0]
    fresh, other = pixels_of(mosaic_of(shots, ground_resolution_m=2 * RESOLUTION_M))
    assert renderer.window == other.window
    np.testing.assert_array_equal(rgba, fresh)


def test_a_very_coarse_map_averages_what_a_pixel_covers():
    """A fine pattern becomes its mean, not a pick of its pixels."""
    pixels = np.tile(np.array([[0, 255], [255, 0]], np.uint8), (120, 160))
    _, jpeg = cv2.imencode('.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, 98])
    record, _ = ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0)
    rgba, _ = pixels_of(mosaic_of([(record, bytes(jpeg))], ground_resolution_m=1.0))
    shown = rgba[rgba[..., 3] > 0][:, 0]
    assert np.all(np.abs(shown.astype(int) - 127) < 12)


def test_the_preview_shows_the_whole_map():
    """North up, transparent where no photograph lies, its corners where the photographs end."""
    shots = [
        ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0, grey=50),
        ground_truth.plain_photograph(GALWAY, 1, 0.0, 120.0, grey=200),
    ]
    maker = mosaic_of(shots)
    preview = Preview(maker)
    for placed in maker.placed_photos().values():
        preview.show(placed)
    picture = cv2.imdecode(np.frombuffer(preview.png(), np.uint8), cv2.IMREAD_UNCHANGED)
    assert max(picture.shape) <= 1024
    covered = picture[..., 3] > 0
    top, bottom = (half[half[..., 3] > 0] for half in np.array_split(picture, 2))
    assert np.median(top[:, 0]) == pytest.approx(200, abs=2)
    assert np.median(bottom[:, 0]) == pytest.approx(50, abs=2)
    assert picture[~covered].max() == 0
    south_west, north_east = preview.corners()
    for east, north in ((-13.0, -18.0), (13.0, 138.0)):
        latitude, longitude = GALWAY.geodetic(east, north)
        assert south_west.latitude_deg < latitude < north_east.latitude_deg
        assert south_west.longitude_deg < longitude < north_east.longitude_deg


def test_lens_distortion_is_taken_out():
    """A mark near the edge of a distorted photograph lies where it does without distortion."""
    ground = ground_at(53.28, -9.06, marks=((12.0, 8.0),))
    record, _ = ground.photograph(0, 0.0, 0.0)
    lens = (0.12, 0.0, 0.0, 0.0, 0.0)
    distorted_record = ground_truth.lens_changed(
        record, distortion_model='plumb_bob', distortion=lens
    )
    distorted = ground.distorted_photograph(lens)
    placed, _ = pixels_of(mosaic_of([(distorted_record, distorted)]))
    plain, _ = pixels_of(mosaic_of([ground.photograph(0, 0.0, 0.0)]))
    centre = np.unravel_index(np.argmax(plain[..., 0]), plain.shape[:2])
    expected = column_and_row_of_mark(plain[..., 0], centre[::-1])
    found = column_and_row_of_mark(placed[..., 0], centre[::-1])
    assert found == pytest.approx(expected, abs=LARGEST_ERROR_PX)


def changed(**changes):
    """Return a photograph whose record is changed."""
    record, jpeg = ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0)
    return dataclasses.replace(record, **changes), jpeg


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'latitude_deg': math.nan}, 'taken without a fix'),
        ({'latitude_deg': 84.5}, 'latitude 84.5 is outside UTM'),
        ({'height_agl_m': math.nan}, 'height_agl_m = nan'),
        ({'height_agl_m': 0.0}, 'height_agl_m = 0.0'),
        ({'orientation_xyzw': (0.0, 0.0, 0.0, 0.0)}, 'no orientation'),
        ({'orientation_xyzw': (0.0, 0.0, 0.0, 1.0)}, 'at or above the horizon'),
    ],
)
def test_what_cannot_be_placed_is_refused_with_its_reason(change, message):
    """And the map goes on without it."""
    mosaic = mosaic_of([ground_truth.plain_photograph(GALWAY, 1, 0.0, 0.0)])
    if 'latitude_deg' in change:
        mosaic = mosaic_of([])
    count = len(mosaic)
    record, jpeg = changed(**change)
    with pytest.raises(PlacementError, match=message):
        mosaic.add(record, lambda: jpeg)
    assert len(mosaic) == count


def test_a_photograph_towards_the_horizon_is_refused():
    """Its far end would smear over the whole map."""
    record, jpeg = ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0, yaw=0.0, pitch=-1.05)
    with pytest.raises(PlacementError, match='farther than 5 heights'):
        mosaic_of([(record, jpeg)])


def left_out(record, jpeg):
    """Return what is said of a photograph whose pixels are no use."""
    notices = []
    maker = mosaic_of([(record, jpeg)], notice=notices.append)
    maker.drop_unreadable()
    assert len(maker) == 0
    return notices[0]


@pytest.mark.parametrize('jpeg', [b'', b'no image'])
def test_an_image_that_cannot_be_decoded_is_left_out(jpeg):
    """The store never gives one, a damaged disk might."""
    record, _ = ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0)
    assert 'cannot be decoded' in left_out(record, jpeg)


def test_an_image_of_another_size_than_its_record_says_is_left_out():
    """Its intrinsics would not hold."""
    record, jpeg = ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0)
    wide = ground_truth.lens_changed(record, width_px=640)
    assert 'image is 320 x 240 pixels, its record says 640' in left_out(wide, jpeg)


def test_an_unknown_distortion_is_left_out():
    """A fish-eye's coefficients mean something else."""
    record, jpeg = ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0)
    fisheye = ground_truth.lens_changed(
        record, distortion_model='equidistant', distortion=(0.1, 0.0, 0.0, 0.0)
    )
    assert 'distortion equidistant is unknown' in left_out(fisheye, jpeg)


def test_an_empty_map_has_no_file(tmp_path):
    """And says so."""
    with pytest.raises(PlacementError, match='no photograph is placed yet'):
        write_geotiff(mosaic_of([]), tmp_path / 'mosaic.tif')


def test_a_map_that_cannot_be_written_leaves_the_old_file(tmp_path, monkeypatch):
    """The file is whole at any moment."""
    mosaic = mosaic_of([ground_truth.plain_photograph(GALWAY, 0, 0.0, 0.0)])
    path = tmp_path / 'mosaic.tif'
    path.write_bytes(b'old map')

    def refuse(*_arguments):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr('rocsafe_mapping.products.cog._write_raw', refuse)
    with pytest.raises(MappingError, match=r'cannot write map .* No space left'):
        write_geotiff(mosaic, path)
    assert path.read_bytes() == b'old map'
    assert [item.name for item in tmp_path.iterdir()] == ['mosaic.tif']
