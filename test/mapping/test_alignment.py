# SPDX-License-Identifier: Apache-2.0
"""Photographs find their places from what they show."""

import dataclasses
import importlib.util
import math
import pathlib

import numpy as np
import pytest

from rocsafe_mapping.alignment.adjustment import ties
from rocsafe_mapping.alignment.block import BY_FEATURES, BY_GPS
from rocsafe_mapping.alignment.initial.initial_poses import initial_poses
from rocsafe_mapping.alignment.model.photo import footprint, ground_frame_of, photo_of_record
from rocsafe_mapping.alignment_options import InitialOptions, PriorOptions
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions
from rocsafe_mapping.products.quality import violations

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)

# Pixels are 9 cm wide: a tie is good to a tenth of one, a camera to a few.
INTERNAL_M = 0.08


def made(shots, **options):
    """Return a map maker that knows the photographs."""
    maker = Mapmaker(MapOptions(**options))
    for shot in shots:
        maker.add(shot.record, lambda shot=shot: shot.jpeg)
    return maker


def corners(maker, shots, poses):
    """Return estimated and true corners in the true frame, complex, (n, 4) each."""
    found, true = [], []
    for shot in shots:
        photo = maker.block.photo(shot.record.shot_id)
        exact = dataclasses.replace(photo.prior, centre=shot.centre, rotation=shot.rotation)
        found.append(footprint(photo, poses[photo.name]) @ [1, 1j])
        true.append(footprint(photo, exact) @ [1, 1j])
    return np.array(found), np.array(true)


def distortion_m(found, true):
    """Return the RMS distance of two point sets after the best similarity."""
    a, b = found - found.mean(), true - true.mean()
    factor = np.vdot(a, b) / np.vdot(a, a)
    return float(np.sqrt(np.mean(np.abs(factor * a - b) ** 2)))


def aligned(shots):
    """Return the maker, its alignment and the poses."""
    maker = made(shots)
    alignment = maker.align()
    poses = {name: placement.pose for name, placement in alignment.placements.items()}
    return maker, alignment, poses


@pytest.fixture(scope='module')
def usual():
    """A flight with noisy fixes and tilt."""
    shots = texture.flight(1)
    return shots, *aligned(shots)


@pytest.mark.slow
def test_all_photographs_are_tied(usual):
    """A third of overlap ties every photograph."""
    alignment = usual[2]
    assert {p.placed_by for p in alignment.placements.values()} == {BY_FEATURES}


def test_photographs_fit_each_other(usual):
    """The map is undistorted to a pixel though fixes are a metre off."""
    shots, maker, _, poses = usual
    assert distortion_m(*corners(maker, shots, poses)) < INTERNAL_M


def test_ties_that_never_entered_agree(usual):
    """Ties kept out of the adjustment agree to a fraction of a pixel."""
    off = np.linalg.norm(usual[2].held_out_px, axis=1)
    assert len(off) > 50
    assert np.median(off) < 0.3


@pytest.mark.slow
def test_stated_error_is_the_true_one(usual):
    """The stated standard error is that of several flights, at most 2.5 times as large.

    One flight proves little: where all of its map lies is a single draw. Six photographs do not
    show that their fixes do not drift; what is stated allows for that.
    """
    flights = [(usual[0], *usual[1:])]
    flights += [(shots, *aligned(shots)) for shots in map(texture.flight, (2, 3))]
    stated, errors = [], []
    for shots, maker, alignment, poses in flights:
        found, true = corners(maker, shots, poses)
        stated += [alignment.error_m(name) ** 2 for name in alignment.photos]
        errors += (np.abs(found + origin(maker) - true) ** 2).ravel().tolist()
    error_m = math.sqrt(np.mean(errors))
    assert error_m / 2.0 < math.sqrt(np.mean(stated)) < 2.5 * error_m


def origin(maker) -> complex:
    """Return the true place of the maker's origin."""
    place = maker.frame.frame.origin
    return complex(*texture.FRAME.enu_of(place)[:2])


def test_map_may_be_called_georeferenced(usual):
    """Nothing contradicts the measurements of an honest flight."""
    assert violations(usual[2], usual[1].block.state) == []


@pytest.mark.slow
def test_arrival_order_does_not_matter(usual):
    """The same photographs in another order come to the same places, to 0.05 pixels."""
    shots, _, alignment, _ = usual
    other = made([shots[0], *reversed(shots[1:])])
    for shot in reversed(shots):
        other.block.pair_table.match_new(shot.record.shot_id)
        other.block.place(shot.record.shot_id)
    again = other.align()
    pixel_m = alignment.photos['rav1-00000'].ground_resolution_m
    for name, placement in alignment.placements.items():
        photo = alignment.photos[name]
        first = footprint(photo, placement.pose)
        second = footprint(photo, again.placements[name].pose)
        assert np.abs(first - second).max() < 0.05 * pixel_m


@pytest.mark.slow
def test_reversed_yaws_are_survived():
    """A strip whose yaw is told half a turn wrong lies right."""
    shots = texture.flight(2, told_yaw=0.0)
    turned = texture.flight(2, told_yaw=math.pi)
    mixed = [*shots[:4], *turned[4:]]
    maker, _, poses = aligned(mixed)
    assert distortion_m(*corners(maker, mixed, poses)) < INTERNAL_M


@pytest.mark.slow
def test_wrong_fix_is_not_believed():
    """One fix 20 m off moves the map by less than a metre."""
    shots = texture.flight(3)
    wrong = shots[2].record
    place = texture.FRAME.position_of(shots[2].centre + np.array([20.0, 0.0, 0.0]))
    record = dataclasses.replace(
        wrong, latitude_deg=place.latitude_deg, longitude_deg=place.longitude_deg
    )
    shots[2] = dataclasses.replace(shots[2], record=record)
    maker, alignment, poses = aligned(shots)
    found, true = corners(maker, shots, poses)
    assert alignment.placements['rav1-00002'].placed_by == BY_FEATURES
    assert distortion_m(found, true) < INTERNAL_M
    assert abs(np.mean(found + origin(maker) - true)) < 1.5


@pytest.mark.slow
def test_featureless_photograph_stays_where_its_fix_says():
    """A photograph of nothing stays on the map, flagged."""
    shots = texture.flight(4)
    flat = texture.flight(4, gain=0.0)[5]
    shots[5] = flat
    _, alignment, _ = aligned(shots)
    assert alignment.placements['rav1-00005'].placed_by == BY_GPS
    assert len(alignment.placements) == len(shots)


def test_lonely_photograph_is_not_georeferenced():
    """A single photograph is shown, but the map is no better than its fix and says so."""
    shots = texture.flight(5)[:1]
    maker, alignment, _ = aligned(shots)
    assert 'tied to others' in violations(alignment, maker.block.state)[0]


def test_pair_of_look_alikes_is_left_out(usual):
    """A pair that puts a photograph elsewhere than its other pairs do is not believed."""
    _, maker, _, _ = usual
    true = list(maker.block.pair_table.found.values())
    first, second = 'rav1-00000', 'rav1-00005'
    others = [pair for pair in true if {pair.first, pair.second} != {first, second}]
    likeness = next(pair for pair in others if (pair.first, pair.second) == (first, 'rav1-00001'))
    false = dataclasses.replace(likeness, second=second)
    found = initial_poses(maker.block.photos, [*others, false], InitialOptions())
    assert false not in found.pairs
    assert set(map(id, found.pairs)) == set(map(id, others))


@pytest.mark.slow
@pytest.mark.parametrize(
    ('altitude_off_m', 'up_m', 'std_m'),
    [(1.5, 33.5, 0.3), (-20.0, 32.0, math.hypot(0.3, 20.0)), (math.nan, 32.0, 0.3)],
)
def test_a_camera_is_as_high_as_its_altitude_says(altitude_off_m, up_m, std_m):
    """The ground below differs; where it differs much, or the altitude is missing, it rules."""
    shot = texture.flight(1)[0]
    frame = ground_frame_of(shot.record)
    ground_m = frame.frame.origin.altitude_m
    record = dataclasses.replace(
        shot.record,
        height_agl_m=32.0,
        altitude_m=ground_m + 32.0 + altitude_off_m,
        position_covariance_m2=(1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 0.09),
    )
    photo = photo_of_record(record, frame, PriorOptions(), 'a')
    assert photo.prior.centre[2] == pytest.approx(up_m, abs=1e-6)
    assert photo.vertical_std_m == pytest.approx(std_m, rel=1e-6)


def test_many_ties_are_thinned_evenly(usual):
    """A limit bounds memory: each pair keeps its share of ties."""
    _, maker, alignment, _ = usual
    pairs = maker.block.used_pairs
    whole = ties.ties_of(pairs, alignment.photos, held_out=False, most=10**6)
    most = len(whole) // 3
    thinned = ties.ties_of(pairs, alignment.photos, held_out=False, most=most)
    assert 0.2 * len(whole) < len(thinned) <= len(whole) / 3 + len(pairs)
    assert set(zip(thinned.first, thinned.second, strict=True)) == set(
        zip(whole.first, whole.second, strict=True)
    )
