# SPDX-License-Identifier: Apache-2.0
"""Two photographs tell how high what stands on the ground is, and the map states how it leans."""

import functools
import importlib.util
import pathlib

import cv2
import numpy as np
import pytest
import rasterio

from rocsafe_geo.pinhole import ground_homography, rotation_enu_from_optical
from rocsafe_mapping.drawing.renderer import Renderer
from rocsafe_mapping.drawing_options import DrawingOptions
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions
from rocsafe_mapping.products.error_map import ERROR_TIF, error_map, write_error_map

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)

ROOF_UP_M = 3.0
# East and north of its corners: it lies in what both photographs show, aside of both cameras.
ROOF_M = np.array([[4.0, -4.0], [12.0, -4.0], [12.0, 4.0], [4.0, 4.0]])
# The image's top points east: the photographs overlap by half, northwards.
NORTHS_M = (-9.0, 9.0)


@functools.cache
def textured(seed: int) -> np.ndarray:
    """Return a picture of ground; it takes a moment to make."""
    return texture.textured_ground(seed)


def on_roof(ground_m: np.ndarray, margin_m: float) -> np.ndarray:
    """Return which points (n, 2) lie on the roof, so far from its edge."""
    inside = (ground_m > ROOF_M.min(axis=0) + margin_m) & (
        ground_m < ROOF_M.max(axis=0) - margin_m
    )
    return inside.all(axis=-1)


def picture(centre: np.ndarray, roof_up_m: float) -> bytes:
    """Return the photograph of textured ground with a roof of another texture above it."""
    rotation = rotation_enu_from_optical(0.0)
    seen = texture.seen(textured(1), centre, rotation)
    if roof_up_m:
        corners = np.column_stack([ROOF_M, np.ones(4)])
        side = 8 * texture.GROUND_PX_PER_M
        square = np.array([[0, 0], [side, 0], [side, side], [0, side]], np.float32)
        lifted = corners @ ground_homography(texture.CAMERA, centre, rotation, roof_up_m).T
        to_image = cv2.getPerspectiveTransform(
            square, (lifted[:, :2] / lifted[:, 2:]).astype(np.float32)
        )
        size = seen.shape[1::-1]
        roof = textured(2)[: int(side), : int(side)]
        mask = cv2.warpPerspective(np.full(roof.shape[:2], 255, np.uint8), to_image, size)
        seen = np.where(mask[..., np.newaxis] > 0, cv2.warpPerspective(roof, to_image, size), seen)
    return bytes(cv2.imencode('.jpg', seen, [cv2.IMWRITE_JPEG_QUALITY, 95])[1])


def drawn(roof_up_m: float) -> tuple[Mapmaker, Renderer]:
    """Return the map of two photographs whose places are known."""
    maker = Mapmaker(MapOptions(ground_resolution_m=0.1))
    level = rotation_enu_from_optical(0.0)
    for number, north_m in enumerate(NORTHS_M):
        centre = np.array([0.0, north_m, texture.HEIGHT_M])
        jpeg = picture(centre, roof_up_m)
        record = texture.record_of(number, centre, level, 0.02, 1e-3, jpeg, 'rav1')
        maker.add(record, lambda jpeg=jpeg: jpeg)
    placed_photos = maker.placed_photos()
    return maker, Renderer(
        placed_photos, maker.pixels, maker.grid(placed_photos), DrawingOptions(), placed_photos
    )


def places_m(maker: Mapmaker, renderer: Renderer) -> np.ndarray:
    """Return (east, north) of the pixels of `labels` about the roof's origin, (h, w, 2)."""
    window = renderer.owner_window
    rows, columns = np.mgrid[: window.height, : window.width] + 0.5
    ground = renderer.coarse.ground_of(
        (columns + window.column).ravel(), (rows + window.row).ravel()
    )
    ground = ground + texture.FRAME.enu_of(maker.frame.frame.origin)[:2]
    return ground.reshape(window.height, window.width, 2)


def true_m(maker: Mapmaker, renderer: Renderer, shown_m: np.ndarray) -> np.ndarray:
    """Return where what the map shows would truly be if it were on the roof's level."""
    norths = np.where(renderer.owners == 0, *NORTHS_M)
    below = np.stack([np.zeros(norths.shape), norths], axis=-1)
    return shown_m + (below - shown_m) * ROOF_UP_M / texture.HEIGHT_M


@pytest.fixture(scope='module')
def roofed():
    """The map of ground with a roof."""
    return drawn(ROOF_UP_M)


@pytest.mark.slow
def test_a_roof_has_its_height(roofed):
    """Within a quarter of a metre on the roof, none on the ground, nothing where one sees."""
    maker, renderer = roofed
    shown = places_m(maker, renderer)
    roof = on_roof(true_m(maker, renderer, shown), 1.0) & (renderer.owners >= 0)
    heights = renderer.relief.heights_m
    assert roof.sum() > 400
    assert np.isfinite(heights[roof]).mean() > 0.9
    assert np.nanmedian(heights[roof]) == pytest.approx(ROOF_UP_M, abs=0.25)
    aside = (np.abs(shown[..., 1]) < 7.0) & (shown[..., 0] < 0.0) & (shown[..., 0] > -11.0)
    assert (heights[aside] == 0.0).mean() > 0.95
    assert np.isnan(heights[np.abs(shown[..., 1]) > 12.0]).all()


def test_the_stated_error_is_how_far_the_roof_leans(roofed):
    """Within a fifth on the roof; less than half as much where nothing stands."""
    maker, renderer = roofed
    found = error_map(maker.alignment(), renderer)
    shown = places_m(maker, renderer)
    truly = true_m(maker, renderer, shown)
    roof = on_roof(truly, 1.0) & (renderer.owners >= 0)
    leaning = np.linalg.norm(truly - shown, axis=-1)[roof]
    assert np.sqrt(np.mean(leaning**2)) > 0.6
    assert np.sqrt(np.mean(found.error_m[roof] ** 2)) == pytest.approx(
        np.sqrt(np.mean(leaning**2)), rel=0.2
    )
    facts = found.facts()
    assert 0.02 < facts['standing']['share'] < 0.2
    assert facts['ground']['rms'] < 0.5 * facts['standing']['rms']
    assert sum(facts[kind]['share'] for kind in ('ground', 'standing', 'untold')) == pytest.approx(
        1.0, abs=1e-3
    )


def test_level_ground_has_no_relief():
    """Nothing is reckoned with where nothing stands up."""
    _, renderer = drawn(0.0)
    assert np.sqrt(np.mean(renderer.relief.rise_m**2)) < 0.05


def test_without_relief_wanted_nothing_is_told(roofed):
    """The map of photographs that fixes alone place is not asked for heights."""
    maker, _ = roofed
    relief = maker.renderer().relief
    assert np.isnan(relief.heights_m).all()
    assert not relief.rise_m.any()


def test_the_map_of_errors_lies_on_the_map(roofed, tmp_path):
    """A GeoTIFF of three bands with the map's projection, no value where nothing is shown."""
    maker, renderer = roofed
    found = error_map(maker.alignment(), renderer)
    write_error_map(tmp_path, found, renderer)
    with rasterio.open(tmp_path / ERROR_TIF) as file:
        assert (file.count, file.crs.to_epsg()) == (3, renderer.grid.epsg)
        errors, heights, ages = file.read(masked=True)
        row, column = np.argwhere(renderer.relief.heights_m > 2.0)[0].tolist()
        east, north = file.xy(row, column)
    assert np.array_equal(errors.mask, ~found.is_shown)
    assert errors[row, column] == found.error_m[row, column]
    assert heights[row, column] == found.heights_m[row, column]
    np.testing.assert_array_equal(ages.filled(np.nan), found.ages_s)
    cell = renderer.cell_m
    window = renderer.owner_window
    assert (east, north) == pytest.approx(
        ((window.column + column + 0.5) * cell, -(window.row + row + 0.5) * cell)
    )
