# SPDX-License-Identifier: Apache-2.0
"""Painting of the ground: marks have the areas and colours that they are given."""

import math

import numpy as np
import pytest

from rocsafe_scene.painting.canvas import Canvas
from rocsafe_scene.painting.marks import Layer, Paint, disc, normals_of, polygon, ribbon, stroke
from rocsafe_scene.painting.noise import Window
from rocsafe_scene.painting.outlines import blob, faded, generator, smooth_line

# 4 cm texels, 8 m wide.
WINDOW, OCTAVE = Window(-100, -100, 100, 100), 2
TEXEL_M = 0.04
WHITE = Paint((255, 255, 255), 0)


def painted(*marks: object) -> np.ndarray:
    """Return the brightness, 0 to 1, of white marks on black ground."""
    canvas = Canvas(WINDOW, OCTAVE, np.zeros((*WINDOW.shape, 4), np.uint8))
    canvas.paint(Layer(marks))  # type: ignore[arg-type]
    image = canvas.finished(np.zeros(WINDOW.shape, np.float32), 0)
    assert image.shape == (*WINDOW.shape, 3)
    return image[..., 1] / 255.0


def area_m2(image: np.ndarray) -> float:
    """Return the area that is painted."""
    return float(image.sum() * TEXEL_M**2)


def test_marks_cover_their_area():
    """A triangle, a disc and a stroke; OpenCV paints up to 0.7 texels more along outlines."""
    triangle = polygon([[-3.0, -2.0], [3.0, -2.0], [0.0, 3.0]], WHITE)
    assert area_m2(painted(triangle)) == pytest.approx(15.0, abs=0.7 * TEXEL_M * 17.7)
    assert area_m2(painted(disc((0.5, -0.3), 1.5, WHITE))) == pytest.approx(
        math.pi * 1.5**2, rel=0.04
    )
    line = stroke([[-3.0, 1.0], [3.0, 1.0]], 0.8, WHITE)
    assert area_m2(painted(line)) == pytest.approx(4.8, rel=0.09)


def test_row_0_lies_in_the_south_and_column_0_in_the_west():
    """A mark in the north-east is painted at high rows and columns."""
    rows, columns = np.nonzero(painted(disc((2.0, 3.0), 0.2, WHITE)))
    assert rows.mean() == pytest.approx((3.0 / TEXEL_M) + 99.5, abs=0.6)
    assert columns.mean() == pytest.approx((2.0 / TEXEL_M) + 99.5, abs=0.6)


def test_later_marks_hide_earlier_ones_and_translucent_ones_do_by_their_opacity():
    """Black over white is black; 40 % of black over white is 60 % grey."""
    square = [[-2.0, -2.0], [2.0, -2.0], [2.0, 2.0], [-2.0, 2.0]]
    black = Paint((0, 0, 0), 0)
    assert painted(polygon(square, WHITE), polygon(square, black))[100, 100] == 0.0
    grey = painted(polygon(square, WHITE), polygon(square, Paint((0, 0, 0), 0, 0.4)))
    assert grey[100, 100] == pytest.approx(0.6, abs=0.01)


def test_faded_patches_fall_from_the_middle_to_the_rim():
    """Their opacity never rises outwards."""
    outline = 2.0 * np.column_stack([np.cos(a := np.linspace(0, 6.2, 60)), np.sin(a)])
    patch = painted(faded(outline, Paint((255, 255, 255), 0, 0.8)))
    row = patch[100, 100:]
    assert row[0] == pytest.approx(0.8, abs=0.02)
    assert (np.diff(row) <= 0.02).all()
    assert row[round(2.0 * 1.5 / TEXEL_M) :].max() == 0.0


def test_grain_varies_brightness_by_its_strength():
    """Full grain swings by 52 %, none by nothing."""
    swing = np.ones(WINDOW.shape, np.float32)
    for grain, expected in ((0, 1.0), (255, 1.52)):
        turf = np.full((*WINDOW.shape, 4), (100, 100, 100, grain), np.uint8)
        image = Canvas(WINDOW, OCTAVE, turf).finished(swing, 0)
        assert image.mean() == pytest.approx(100.0 * expected, abs=1.0)


def test_layers_find_marks_by_place():
    """Only those whose bounds meet a window, in their order."""
    marks = [disc((x, 0.0), 0.5, WHITE) for x in (-10.0, 0.0, 1.0, 10.0)]
    found = [mark for mark, _ in Layer(marks).within(-0.6, -1.0, 0.6, 1.0)]
    assert found == marks[1:3]


def test_curves_pass_through_their_points_and_ribbons_keep_their_width():
    """A smooth line meets every corner; its ribbon is as wide everywhere."""
    corners = np.array([[0.0, 0.0], [10.0, 3.0], [20.0, -2.0], [40.0, 0.0]])
    line = smooth_line(corners, 0.5)
    gaps = np.linalg.norm(line[:, None] - corners[None], axis=2).min(axis=0)
    assert gaps == pytest.approx(0.0, abs=1e-9)
    edges = ribbon(line, 3.0)
    count = len(line)
    width = np.linalg.norm(edges[:count] - edges[count:][::-1], axis=1)
    assert width == pytest.approx(3.0)
    assert np.linalg.norm(normals_of(line), axis=1) == pytest.approx(1.0)


def test_blobs_lie_about_their_centre_and_come_from_their_generator():
    """Radii vary by less than two thirds; the same generator makes the same outline."""
    centre, radii = np.array([4.0, -3.0]), (2.0, 2.0)
    outline, again = (blob(generator(7, 1), centre, radii) for _ in range(2))
    assert np.array_equal(outline, again)
    reach = np.linalg.norm(outline - centre, axis=1)
    assert (reach > 2.0 / 3.0).all()
    assert (reach < 10.0 / 3.0).all()
