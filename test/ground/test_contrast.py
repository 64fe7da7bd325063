# SPDX-License-Identifier: Apache-2.0
"""Things of the colours of ground are obstacles where they stand out from what is around them."""

import numpy as np
import pytest
from test.ground.villages import (
    DARK,
    GRASS,
    HALF_M,
    ROAD,
    SOIL,
    write_bands,
    write_village,
)  # fmt: skip

from rocsafe_ground.drivable.contrast import STRIP, ContrastRules, is_unlike
from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.ground_map import MapFiles, read_ground_map

PIXEL_M = 0.1
# Texture of ground is light and dark more than it is coloured.
LIGHT_STD, COLOUR_STD = 8.0, 2.0
# Small things stand in such places, east and north.
PLACES = ((-20.0, -20.0), (-7.3, -11.6), (4.05, 3.95), (19.8, -25.2))
BESIDE = (255, 210, 40)


def reasons(tmp_path, paint):
    """Return a map of a meadow, seen in pixels of 0.1 m, on which something is painted."""
    folder = write_village(tmp_path)
    middle = np.arange(-HALF_M + PIXEL_M / 2, HALF_M, PIXEL_M)
    east, north = np.meshgrid(middle, middle[::-1])
    image = np.empty((3, *east.shape))
    image[:] = np.array(GRASS)[:, None, None]
    paint(image, east, north)
    noise = np.random.default_rng(5)
    image += noise.normal(0.0, LIGHT_STD, east.shape)
    image += noise.normal(0.0, COLOUR_STD, image.shape)
    bands = np.full((4, *east.shape), 255, np.uint8)
    bands[:3] = np.clip(image, 0, 255)
    write_bands(folder / 'mosaic.tif', bands, PIXEL_M)
    return read_ground_map(MapFiles(folder=folder), GroundVehicle(), 0.5, 1e5)


def at(ground, east, north):
    """Return why a place is not free."""
    return Reason(int(ground.ground.reasons.ravel()[ground.grid.cell_of(east, north)]))


@pytest.mark.slow
@pytest.mark.parametrize('colour', [SOIL, ROAD, (200, 180, 120), DARK, BESIDE])
def test_small_thing_is_an_obstacle_whatever_its_colour(tmp_path, colour):
    """A person of 0.5 m in a coat of the colour of soil or of a road, on a meadow."""

    def paint(image, east, north):
        for place in PLACES:
            shown = np.hypot(east - place[0], north - place[1]) < 0.28
            image[:, shown] = np.array(colour)[:, None]

    ground = reasons(tmp_path, paint)
    kinds = [at(ground, *place) for place in PLACES]
    assert kinds == [Reason.OBSTACLE] * len(PLACES)


@pytest.mark.slow
def test_way_through_a_meadow_is_free(tmp_path):
    """Neither its middle nor its edges are things, nor are lines of 0.1 m on it, nor noise."""

    def paint(image, east, north):
        image[:, np.abs(north + 0.3 * east) < 1.5] = np.array(ROAD)[:, None]
        image[:, np.abs(north + 0.3 * east) < 0.05] = 230.0
        image[:, north > 20.0] = np.array(SOIL)[:, None]

    ground = reasons(tmp_path, paint)
    inner = ground.ground.reasons[4:-4, 4:-4]
    assert (inner == Reason.OBSTACLE).mean() < 1e-4


def test_strips_change_nothing():
    """Rows at the seam of two strips have whole surroundings, as in an image that begins there."""
    colours = np.random.default_rng(3).normal(120.0, 20.0, (3, STRIP + 120, 60))
    colours[:, STRIP - 2 : STRIP + 3, 20:25] = 250.0
    is_seen = np.ones(colours.shape[1:], np.bool_)
    whole = is_unlike(colours, is_seen, PIXEL_M, ContrastRules())
    cut = STRIP // 2
    part = is_unlike(colours[:, cut:], is_seen[cut:], PIXEL_M, ContrastRules())
    assert (whole[cut + 30 :] == part[30:]).all()
    assert whole[STRIP - 2 : STRIP + 3, 20:25].all()


def test_what_was_not_seen_is_not_unlike():
    """And does not count as a colour around what was."""
    colours = np.full((3, 60, 60), 120.0)
    is_seen = np.zeros((60, 60), np.bool_)
    is_seen[:, :30] = True
    colours[:, ~is_seen] = 0.0
    assert not is_unlike(colours, is_seen, PIXEL_M, ContrastRules()).any()
