# SPDX-License-Identifier: Apache-2.0
"""Lens, shutter and sensor against the formulas and the libraries that define them."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_scene.cameras.camera import Truth
from rocsafe_scene.optics.distortion import Distortion, pixel_rays
from rocsafe_scene.optics.effects import Effects
from rocsafe_scene.optics.motion import (
    CameraMotion,
    motion_between,
    pixel_rates,
    plane_depth_m,
)
from rocsafe_scene.optics.optics import Optics
from rocsafe_scene.optics.sensor_response import image_of_light, light_of

LENS = PinholeCamera(math.radians(60.0), 160, 120)
BARREL = (-0.22, 0.06, 0.004, -0.003, -0.01)
PINCUSHION = (0.12, 0.02, -0.002, 0.001, 0.0)
PLACE = (0.0, 0.0, 30.0)
small = st.floats(-1.0, 1.0)


def rng(seed=1):
    """Return a generator of noise."""
    return np.random.default_rng(seed)


def pattern(x, y):
    """Return a smooth picture of rays, (..., 3), with detail some 12 px across."""
    waves = [
        np.sin(9.0 * x + 5.0 * y),
        np.cos(11.0 * y - 3.0 * x),
        np.sin(7.0 * x) * np.cos(8 * y),
    ]
    return np.rint(127.5 + 90.0 * np.stack(waves, axis=-1)).astype(np.uint8)


def off(image, other, margin=4):
    """Return the largest and the mean difference of two pictures away from their borders."""
    gap = np.abs(image.astype(int) - other.astype(int))[margin:-margin, margin:-margin]
    return gap.max(), gap.mean()


@pytest.mark.parametrize('terms', [BARREL, PINCUSHION])
def test_the_distortion_is_that_of_opencv(terms):
    """Points go where cv2.projectPoints sends them, and come back."""
    x, y = pixel_rays(LENS)
    x, y = x[::4, ::4], y[::4, ::4]
    points = np.stack([x, y, np.ones_like(x)], axis=-1).reshape(-1, 3)
    expected, _ = cv2.projectPoints(points, np.zeros(3), np.zeros(3), np.eye(3), np.array(terms))
    found = np.stack(Distortion(*terms).distorted(x, y), axis=-1).reshape(-1, 2)
    assert found == pytest.approx(expected.reshape(-1, 2), abs=1e-12)
    back = Distortion(*terms).undistorted(*Distortion(*terms).distorted(x, y))
    assert back[0] == pytest.approx(x, abs=1e-10)
    assert back[1] == pytest.approx(y, abs=1e-10)


def test_a_distortion_that_folds_is_refused():
    """Beyond the turning point of the radius there is nothing to draw."""
    with pytest.raises(ValueError, match='folds the picture over itself'):
        Optics(LENS, Effects(distortion=(-0.9,)))


@pytest.mark.parametrize('terms', [BARREL, PINCUSHION])
def test_undistorting_gives_the_pinhole_picture_back(terms):
    """cv2.undistort with the same coefficients finds what a pinhole sees, wherever it sees."""
    optics = Optics(LENS, Effects(distortion=terms))
    photo = optics.develop(pattern(*pixel_rays(optics.source)), None, rng())
    pinhole = pattern(*pixel_rays(LENS))
    assert photo.shape == pinhole.shape
    assert off(photo, pinhole)[0] > 20
    straight, reached = (
        cv2.undistort(each, LENS.matrix, np.array(terms)) for each in (photo, photo * 0 + 255)
    )
    is_seen = cv2.erode(reached, np.ones((9, 9), np.uint8))[..., 0] == 255
    assert is_seen.mean() > 0.6
    gap = np.abs(straight.astype(int) - pinhole.astype(int))[is_seen]
    assert gap.max() <= 6
    assert gap.mean() < 1.0


def test_labels_and_depth_are_distorted_alike():
    """Each pixel has the label and the depth of one place: that which its ray meets."""
    optics = Optics(LENS, Effects(distortion=BARREL))

    def label(x, y):
        return (np.floor(8.0 * x) + 40.0 + 100.0 * (np.floor(8.0 * y) + 40.0)).astype(np.uint32)

    drawn = label(*pixel_rays(optics.source))
    truth = Truth(depth_m=drawn.astype(np.float32) * 2.0, numbers=drawn)
    seen = optics.truth(truth, None)
    assert np.array_equal(seen.depth_m, seen.numbers * np.float32(2.0))
    x, y = Distortion(*BARREL).undistorted(*pixel_rays(LENS))
    # off the edges of the labels by more than half a pixel
    gap = 0.51 / LENS.focal_px
    is_sure = (label(x - gap, y - gap) == label(x + gap, y + gap)) & (
        label(x - gap, y + gap) == label(x + gap, y - gap)
    )
    assert is_sure.mean() > 0.7
    assert np.array_equal(seen.numbers[is_sure], label(x, y)[is_sure])


def test_light_and_back_is_the_same_picture():
    """Every value of a pixel survives."""
    every = np.arange(256, dtype=np.uint8).reshape(16, 16)
    assert np.array_equal(image_of_light(light_of(every)), every)


def test_vignetting_is_the_fourth_power_of_the_cosine():
    """Of the angle of each pixel's ray; half the effect is half the loss."""
    grey = np.full((120, 160, 3), 180, np.uint8)
    x, y = pixel_rays(LENS)
    natural = np.cos(np.arctan(np.hypot(x, y))) ** 4
    for share in (1.0, 0.5):
        photo = Optics(LENS, Effects(vignetting=share)).develop(grey, None, rng())
        ratio = light_of(photo)[..., 0] / light_of(grey)[..., 0]
        assert ratio == pytest.approx(1.0 - share * (1.0 - natural), abs=0.01)


@pytest.mark.parametrize('ev', [-2.0, 0.5, 1.0])
def test_exposure_multiplies_the_light(ev):
    """By 2 to its power; what is too bright is white."""
    steps = np.repeat(np.arange(256, dtype=np.uint8)[None], 16, axis=0)[..., None].repeat(3, 2)
    lens = PinholeCamera(1.0, 256, 16)
    photo = Optics(lens, Effects(exposure_ev=ev)).develop(steps, None, rng())
    expected = np.minimum(light_of(steps) * 2.0**ev, 1.0)
    assert np.abs(photo.astype(int) - image_of_light(expected)).max() <= 1


@pytest.mark.parametrize(('well', 'read'), [(2000.0, 0.0), (800.0, 12.0)])
def test_noise_follows_the_photon_transfer_curve(well, read):
    """Variance of electrons is their mean plus that of reading; the mean stays."""
    lens = PinholeCamera(1.0, 200, 200)
    optics = Optics(lens, Effects(full_well_e=well, read_noise_e=read))
    for value in (120, 170):
        grey = np.full((200, 200, 3), value, np.uint8)
        electrons = light_of(optics.develop(grey, None, rng(value))).astype(float) * well
        mean = float(light_of(grey)[0, 0, 0]) * well
        # rounding to a picture's steps adds its own twelfth of a step squared
        step = well * float(np.diff(light_of(np.array([value, value + 1], np.uint8)))[0])
        expected = mean + read**2 + step**2 / 12.0
        assert electrons.mean() == pytest.approx(mean, rel=0.01)
        assert electrons.var() == pytest.approx(expected, rel=0.03)


def test_noise_is_that_of_its_generator():
    """The same seed gives the same bytes, another one others."""
    optics = Optics(LENS, Effects(full_well_e=900.0))
    picture = pattern(*pixel_rays(LENS))
    first, again, other = (optics.develop(picture, None, rng(seed)) for seed in (5, 5, 6))
    assert np.array_equal(first, again)
    assert not np.array_equal(first, other)


@settings(max_examples=20)
@given(st.tuples(small, small, small), st.tuples(small, small, small), st.floats(3.0, 80.0))
def test_pixels_move_as_points_are_projected(velocity, turning, depth):
    """The rates are the derivative of projecting points that rest while the camera moves."""
    lens = PinholeCamera(1.2, 24, 16)
    motion = CameraMotion(np.array(velocity), np.array(turning))
    rates = pixel_rates(lens, np.full((16, 24), depth, np.float32), motion)
    x, y = pixel_rays(lens)
    points = np.stack([x, y, np.ones_like(x)], axis=-1) * depth
    step_s = 1e-5
    places = []
    for side in (-0.5, 0.5):
        turn = cv2.Rodrigues(np.array(turning) * side * step_s)[0]
        seen = (points - np.array(velocity) * side * step_s) @ turn
        places.append(seen[..., :2] / seen[..., 2:] * lens.focal_px)
    assert rates == pytest.approx((places[1] - places[0]) / step_s, abs=2e-3)


def test_motion_is_found_from_two_poses():
    """Velocity and turning in the camera's own axes, at the middle of the time."""
    before = rotation_enu_from_optical(0.3, 0.02, -0.01)
    turning = np.array([0.2, -0.1, 0.4])
    after = before @ cv2.Rodrigues(turning * 0.1)[0]
    motion = motion_between(((0.0, 0.0, 30.0), (0.4, 0.3, 30.0)), (before, after), 0.1)
    assert motion.turning_radps == pytest.approx(turning)
    middle = before @ cv2.Rodrigues(turning * 0.05)[0]
    assert middle @ motion.velocity_mps == pytest.approx([4.0, 3.0, 0.0])
    assert motion_between((PLACE, PLACE), (before, before), 0.1).is_none


def test_level_ground_is_as_deep_as_its_rays_are_long():
    """Each ray ends on the plane; above the horizon there is none."""
    rotation = rotation_enu_from_optical(0.3, 0.2, -0.1)
    depth = plane_depth_m(LENS, 30.0, rotation)
    x, y = pixel_rays(LENS)
    points = np.stack([x, y, np.ones_like(x)], axis=-1) * depth[..., None] @ rotation.T
    assert points[..., 2] == pytest.approx(-30.0, abs=1e-4)
    assert np.isinf(plane_depth_m(LENS, 30.0, np.eye(3))).all()


def test_a_blurred_edge_is_a_ramp_as_long_as_its_way():
    """In light: an even motion by 12 px turns a step into a line 12 px long."""
    optics = Optics(LENS, Effects(shutter_s=0.05))
    height, width = optics.source.image_height_px, optics.source.image_width_px
    step = np.full((height, width, 3), 40, np.uint8)
    step[:, width // 2 :] = 220
    rates = np.zeros((height, width, 2), np.float32)
    rates[..., 0] = 240.0
    light = light_of(optics.develop(step, rates, rng()))[60, :, 0]
    dark, bright = light_of(np.array([40, 220], np.uint8))
    share = np.clip((np.arange(160) - 79.5) / 12.0 + 0.5, 0.0, 1.0)
    assert light == pytest.approx(dark + share * (bright - dark), abs=0.02)


@pytest.mark.parametrize(
    'motion',
    [
        CameraMotion(np.array([25.0, 0.0, 0.0]), np.zeros(3)),
        CameraMotion(np.array([0.0, -25.0, 0.0]), np.zeros(3)),
        CameraMotion(np.zeros(3), np.array([0.0, 0.0, 2.0])),
    ],
    ids=['sideways', 'ahead', 'turning'],
)
@pytest.mark.parametrize('terms', [(), BARREL], ids=['pinhole', 'barrel'])
def test_a_rolling_shutter_shows_each_row_at_its_moment(motion, terms):
    """Row by row the picture is that which a camera sees from where it then is."""
    depth, readout_s = 12.0, 0.06
    optics = Optics(LENS, Effects(readout_s=readout_s, distortion=terms))
    source = optics.source
    flat = np.full((source.image_height_px, source.image_width_px), depth, np.float32)
    photo = optics.develop(pattern(*pixel_rays(source)), pixel_rates(source, flat, motion), rng())
    x, y = pixel_rays(LENS)
    if terms:
        x, y = Distortion(*terms).undistorted(x, y)
    late = ((np.arange(120) - 59.5) / 120.0 * readout_s)[:, None]
    turned = motion.turning_radps[2] * late
    seen_x = np.cos(turned) * x - np.sin(turned) * y + motion.velocity_mps[0] * late / depth
    seen_y = np.sin(turned) * x + np.cos(turned) * y + motion.velocity_mps[1] * late / depth
    expected = pattern(seen_x, seen_y)
    assert off(pattern(x, y), expected)[0] > 30
    most, mean = off(photo, expected)
    assert most <= 8
    assert mean < 1.0


def test_a_rolling_shutter_takes_labels_along():
    """Labels and depth are those of the places that the rows show."""
    optics = Optics(LENS, Effects(readout_s=0.1))
    height, width = optics.source.image_height_px, optics.source.image_width_px
    left = (width - 160) // 2
    numbers = np.tile(((np.arange(width) - left + 16) // 8).astype(np.uint32), (height, 1))
    truth = Truth(depth_m=numbers.astype(np.float32) + 1.0, numbers=numbers)
    rates = np.zeros((height, width, 2), np.float32)
    rates[..., 0] = 120.0
    seen = optics.truth(truth, rates)
    late = (np.arange(120) - 59.5) / 120.0 * 0.1
    columns = np.rint(np.arange(160) - 120.0 * late[:, None]).astype(int)
    assert np.mean(seen.numbers == (columns + 16) // 8) > 0.995
    assert np.array_equal(seen.depth_m, seen.numbers + np.float32(1.0))


def test_without_motion_the_shutter_changes_nothing():
    """Standing still, the photograph is the picture, to the byte."""
    optics = Optics(LENS, Effects(shutter_s=0.02, readout_s=0.03))
    drawn, pinhole = pattern(*pixel_rays(optics.source)), pattern(*pixel_rays(LENS))
    assert np.array_equal(optics.develop(drawn, None, rng()), pinhole)
    still = np.zeros((*drawn.shape[:2], 2), np.float32)
    assert np.array_equal(optics.develop(drawn, still, rng()), pinhole)
    assert Optics(LENS, Effects(vignetting=0.5)).source == LENS
