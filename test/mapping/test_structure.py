# SPDX-License-Identifier: Apache-2.0
"""Photographs that look in any direction are tied by structure from motion."""

import dataclasses
import importlib.util
import itertools
import math
import pathlib
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from rocsafe_geo.pinhole import rotation_enu_from_optical
from rocsafe_mapping.alignment.matching.features import Features
from rocsafe_mapping.alignment.model.photo import Pose
from rocsafe_mapping.alignment.structure.bundle import Observations, Scene, bundled
from rocsafe_mapping.alignment.structure.epipolar import Link, Tracks
from rocsafe_mapping.alignment.structure.growth import Cameras, Growth, all_grown, best_grown
from rocsafe_mapping.alignment.structure.levelled import levelled
from rocsafe_mapping.alignment.structure.step import _candidates
from rocsafe_mapping.alignment_options import AlignmentOptions, StructureOptions
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Shot

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)


def scene_of(rng, count=8, points=120):
    """Return cameras that look at rough ground from all around, and its points."""
    turns = np.linspace(0.0, 2.0 * math.pi, count, endpoint=False)
    rotations = np.array([rotation_enu_from_optical(turn, -0.6, 0.1) for turn in turns])
    # Each looks at the origin's surroundings.
    centres = -35.0 * rotations[:, :, 2] + rng.normal(0.0, 2.0, (count, 3))
    places = rng.uniform(-12.0, 12.0, (points, 3)) * (1.0, 1.0, 0.05)
    return Scene(centres=centres, rotations=rotations, points=places, lens=np.zeros(3))


def seen_in(scene, rng, noise_px=0.3, focal_px=400.0):
    """Return what the cameras of `scene` see."""
    count, points = len(scene.centres), len(scene.points)
    photos, index = (a.ravel() for a in np.mgrid[:count, :points])
    turned = np.einsum(
        'nji,nj->ni', scene.rotations[photos], scene.points[index] - scene.centres[photos]
    )
    assert np.all(turned[:, 2] > 0.0)
    offsets = focal_px * turned[:, :2] / turned[:, 2:] + rng.normal(
        0.0, noise_px, (len(photos), 2)
    )
    return Observations(
        photos=photos, points=index, offsets_px=offsets, focal_px=np.full(len(photos), focal_px)
    )


def test_bundle_adjustment_finds_the_scene_again():
    """From disturbed poses and points, residuals fall to the noise of the sightings."""
    rng = np.random.default_rng(3)
    scene = scene_of(rng)
    seen = seen_in(scene, rng)
    steps = rng.normal(0.0, 1.0, (len(scene.centres), 6)) * ([0.4] * 3 + [0.01] * 3)
    steps[0] = 0.0
    disturbed = scene.moved(
        np.concatenate([steps.ravel(), np.zeros(3)]), rng.normal(0.0, 0.3, scene.points.shape)
    )
    options = dataclasses.replace(StructureOptions(), bundle_steps=40, least_gain=1e-9)
    found = bundled(disturbed, seen, options, np.zeros(3))
    assert np.sqrt(np.mean(seen.errors_px(disturbed) ** 2)) > 3.0
    assert np.sqrt(np.mean(seen.errors_px(found) ** 2)) < 0.45
    # The first camera is the frame; the others agree with the truth but for the scale.
    scale = np.linalg.norm(found.centres[4] - found.centres[0]) / np.linalg.norm(
        scene.centres[4] - scene.centres[0]
    )
    back = (found.centres - found.centres[0]) / scale + scene.centres[0]
    assert np.abs(back - scene.centres).max() < 0.2


def test_a_point_behind_a_camera_moves_no_lens():
    """Almost infinitely wrong, it outweighed all others: the focal length went to half."""
    rng = np.random.default_rng(3)
    scene = scene_of(rng)
    seen = seen_in(scene, rng)
    behind = scene.centres[3] - 5.0 * scene.rotations[3][:, 2]
    scene = dataclasses.replace(scene, points=np.vstack([scene.points, behind]))
    far = [(photo, 10.0 * photo) for photo in (2, 3)]
    seen = Observations(
        photos=np.append(seen.photos, [photo for photo, _ in far]),
        points=np.append(seen.points, [len(scene.points) - 1] * 2),
        offsets_px=np.vstack([seen.offsets_px, [[x, 5.0] for _, x in far]]),
        focal_px=np.append(seen.focal_px, [400.0, 400.0]),
    )
    found = bundled(scene, seen, StructureOptions(), np.array([0.03, 0.05, 0.05]))
    assert np.abs(found.lens).max() < 0.01


@pytest.mark.slow
def test_the_scene_of_most_sightings_counts(monkeypatch):
    """The best pair shows what no other photograph does: its scene is not the largest."""
    began, begin = [], Growth._begin
    monkeypatch.setattr(
        Growth, '_begin', lambda self, *seed: began.append(seed[0]) or begin(self, *seed)
    )
    rng = np.random.default_rng(5)
    scene = scene_of(rng, count=9, points=300)
    seen = seen_in(scene, rng)
    # The first two photographs show the first hundred points alone, the others all others.
    is_shown = (seen.photos < 2) == (seen.points < 100)
    seen = seen.subset(is_shown)
    links = {}
    for one, other in itertools.combinations(range(9), 2):
        if (one < 2) == (other < 2):
            shared = np.arange(100 if one < 2 else 60)
            way = scene.rotations[other].T @ (scene.centres[one] - scene.centres[other])
            links[one, other] = Link(
                matches=np.column_stack([shared, shared]),
                rotation=scene.rotations[other].T @ scene.rotations[one],
                direction=way / np.linalg.norm(way),
                angle_rad=0.3,
            )
    first = np.where(seen.photos < 2, 0, 100)
    tracks = Tracks(
        photos=seen.photos, features=seen.points - first, points=seen.points, count=300
    )
    offsets = [seen.offsets_px[seen.photos == photo] for photo in range(9)]
    cameras = Cameras(offsets, np.full(9, 400.0), np.zeros(3))
    found = best_grown(links, tracks, cameras, StructureOptions())
    assert sorted(found.names) == list(range(2, 9))
    assert np.median(found.seen.errors_px(found.scene)) < 1.0
    # Further pairs of the large scene would grow the same.
    assert (len(began), began[0]) == (2, (0, 1))
    # The two others are not lost: they are a scene of their own.
    first, second = all_grown(links, tracks, cameras, StructureOptions())
    assert sorted(first.names) == list(range(2, 9))
    assert sorted(second.names) == [0, 1]


def test_photographs_without_a_fix_are_matched_with_those_most_alike():
    """Sixty in a row, each showing half of what the next one does; two thirds tell no fix."""
    rng = np.random.default_rng(6)
    seen = rng.uniform(0.0, 1.0, (61 * 30, 128)).astype(np.float32)
    features = [
        Features(points_px=np.zeros((60, 2)), descriptors=seen[30 * number :][:60])
        for number in range(60)
    ]
    shots = [
        SimpleNamespace(
            is_located=number % 3 == 0,
            prior=Pose(centre=np.array([10.0 * number, 0.0, 30.0]), rotation=np.eye(3)),
        )
        for number in range(60)
    ]
    found = set(_candidates(shots, features, AlignmentOptions()))
    assert {(number, number + 1) for number in range(59)} <= found
    most = AlignmentOptions().structure.neighbours
    assert len(found) <= most * 60
    assert all(one < other for one, other in found)
    assert len(_candidates(shots[:40], features[:40], AlignmentOptions())) == 40 * 39 / 2


def test_ground_is_the_plane_of_most_points():
    """However the scene is turned, it is laid level with the cameras above it."""
    rng = np.random.default_rng(4)
    scene = scene_of(rng)
    turn = rotation_enu_from_optical(1.0, 0.7, -2.0)
    turned = Scene(
        centres=scene.centres @ turn.T + 5.0,
        rotations=turn @ scene.rotations,
        points=scene.points @ turn.T + 5.0,
        lens=scene.lens,
    )
    found = levelled(turned, StructureOptions())
    assert np.median(found.centres[:, 2]) == pytest.approx(100.0)
    assert np.quantile(np.abs(found.points[:, 2]), 0.9) < 3.0


def oblique_flight(seed=7, count=6, *, first=0, east_m=0.0):
    """Return photographs from a circle that look 40 degrees off nadir, and some from above.

    The records tell fixes only: neither attitude nor height.
    """
    rng = np.random.default_rng(seed)
    ground = texture.textured_ground(seed)
    shots = []
    for number in range(count):
        turn = 2.0 * math.pi * number / count
        tilt = 0.7 if number % 2 else 0.35
        rotation = rotation_enu_from_optical(turn, -tilt, 0.05 * math.sin(3.0 * turn))
        ahead = rotation[:2, 2] / -rotation[2, 2]
        place = np.array([8.0 * math.cos(2 * turn), 8.0 * math.sin(turn)])
        centre = np.array([*(place - ahead * texture.HEIGHT_M), texture.HEIGHT_M])
        picture = texture.seen(ground, centre, rotation)
        jpeg = bytes(cv2.imencode('.jpg', picture, [cv2.IMWRITE_JPEG_QUALITY, 92])[1])
        centre = centre + np.array([east_m, 0.0, 0.0])
        told = centre + np.array([*rng.normal(0.0, 0.5, 2), 0.0])
        record = texture.record_of(
            first + number,
            told,
            rotation_enu_from_optical(0.0),
            0.5,
            math.radians(6.0),
            jpeg,
            'kite',
        )
        spread = math.radians(6.0) ** 2
        record = dataclasses.replace(
            record, height_agl_m=math.nan,
            orientation_covariance_rad2=(spread, 0, 0, 0, spread, 0, 0, 0, math.pi**2),
        )  # fmt: skip
        shots.append((f'{first + number:02d}.jpg', record, jpeg, centre, rotation))
    return shots


@pytest.mark.slow
@pytest.mark.parametrize('islands', [1, 2])
def test_oblique_photographs_are_placed(islands):
    """All lie where they were taken, to the fixes' half metre, and look where they looked."""
    shots = oblique_flight()
    if islands == 2:
        # Nothing ties these to the others.
        shots += oblique_flight(8, 7, first=len(shots), east_m=300.0)
    maker = Mapmaker(MapOptions())
    maker.add_all(
        [Shot(name=name, record=record, read=lambda j=jpeg: j) for name, record, jpeg, *_ in shots]
    )
    alignment = maker.align()
    frame, placed = maker.frame.frame, alignment.placements
    assert [p.placed_by for p in placed.values()] == ['features'] * len(shots)
    off, turned = [], []
    for name, _, _, centre, rotation in shots:
        there = frame.to_geodetic(placed[name].pose.centre)[0]
        off.append(texture.FRAME.to_enu(there[0], there[1], [60.0])[0, :2] - centre[:2])
        cosine = (np.trace(rotation.T @ placed[name].pose.rotation) - 1.0) / 2.0
        turned.append(math.degrees(math.acos(min(cosine, 1.0))))
    assert np.linalg.norm(off, axis=1).max() < 1.0
    assert max(turned) < 2.0


@pytest.mark.slow
def test_without_fixes_the_largest_island_is_the_map():
    """What is not tied to it could lie anywhere, and is told."""
    shots = oblique_flight() + oblique_flight(8, 8, first=6)
    told = []
    maker = Mapmaker(MapOptions(), told.append)
    nowhere = {'latitude_deg': math.nan, 'longitude_deg': math.nan}
    maker.add_all([
        Shot(name=name, record=dataclasses.replace(record, **nowhere), read=lambda j=jpeg: j)
        for name, record, jpeg, *_ in shots
    ])  # fmt: skip
    placed = maker.align().placements
    assert sorted(placed) == [f'{number:02d}.jpg' for number in range(6, 14)]
    assert [one for one in told if 'nothing ties it' in one] == told
    assert len(told) == 6


@pytest.mark.slow
@pytest.mark.parametrize(('fix_off_m', 'placed_by'), [(0.0, 'features'), (90.0, 'gps')])
def test_a_photograph_that_shows_no_ground_nearby_lies_beside_the_others(fix_off_m, placed_by):
    """Its pose of structure from motion, in a frame of its own, is laid on the tied ones."""
    shots = texture.flight(3, rows=2, columns=3, spacing_m=(13.0, 13.0), fix_m=0.5)
    maker = Mapmaker(MapOptions())
    maker.add_all(
        [Shot(name=str(n), record=s.record, read=lambda j=s.jpeg: j) for n, s in enumerate(shots)]
    )
    maker.align()
    block = maker.block
    found = block.state.poses['4']
    turn = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    loose = {
        name: Pose(centre=3.0 * turn @ pose.centre, rotation=turn @ pose.rotation)
        for name, pose in block.state.poses.items()
    }
    poses = {name: pose for name, pose in block.state.poses.items() if name != '4'}
    block.state = dataclasses.replace(block.state, poses=poses)
    block._scenes = (loose,)
    photo = block._photos['4']
    block._photos['4'] = photo.at(
        photo.prior.centre[:2] + np.array([fix_off_m, 0.0]), photo.horizontal_std_m
    )
    placement = block.placements()['4']
    assert placement.placed_by == placed_by
    if placed_by == 'features':
        assert np.abs(placement.pose.centre - found.centre).max() < 1e-6


@pytest.mark.slow
def test_a_photograph_that_may_be_anywhere_is_left_out():
    """One is, with its name; where most are so, the map says it of itself."""
    shots = texture.flight(3, rows=2, columns=3, spacing_m=(13.0, 13.0), fix_m=0.5)
    told = []
    maker = Mapmaker(MapOptions(), told.append)
    maker.add_all(
        [Shot(name=str(n), record=s.record, read=lambda j=s.jpeg: j) for n, s in enumerate(shots)]
    )
    alignment = maker.align()
    assert len(maker) == len(shots)
    assert told == []
    unsure = dataclasses.replace(alignment, errors_m=dict.fromkeys(alignment.errors_m, 100.0))
    assert not maker._drop_uncertain(unsure)
    unsure = dataclasses.replace(alignment, errors_m={**alignment.errors_m, '5': 100.0})
    assert maker._drop_uncertain(unsure)
    assert sorted(maker.block.placements()) == ['0', '1', '2', '3', '4']
    assert len(told) == 1
    assert '5: it may be off by 100 m' in told[0]
    maker.block.place_all()
    assert not maker._drop_uncertain(maker.alignment())
