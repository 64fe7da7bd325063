# SPDX-License-Identifier: Apache-2.0
"""Photographs of any camera: unknown heights, wrong fixes, files that are none."""

import dataclasses
import importlib.util
import math
import os
import pathlib
import struct
import zlib

import cv2
import numpy as np
import pytest

from rocsafe_mapping.alignment.adjustment.fix_noise import fix_errors_m
from rocsafe_mapping.errors import PlacementError
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Shot
from rocsafe_mapping.mosaic.one_place import distances_from_most_m
from rocsafe_mapping.photographs.exif import with_exif
from rocsafe_mapping.products.quality import violations
from rocsafe_mapping.store.photograph_files import photographs_of

pytestmark = pytest.mark.slow

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)


def untold(shot, **changes):
    """Return a photograph whose record holds no height above the ground."""
    record = dataclasses.replace(shot.record, height_agl_m=math.nan, **changes)
    name = f'IMG_{record.sequence}.JPG'
    return Shot(name=name, record=record, read=lambda: changes.get('jpeg', shot.jpeg))


@pytest.mark.parametrize('ground_m', [-20.0, 60.0, 1800.0])
def test_scale_comes_from_the_fixes_whatever_the_altitude(ground_m):
    """A camera that tells only its altitude has the pixels of its flying height."""
    shots = [
        untold(shot, altitude_m=shot.record.altitude_m - 60.0 + ground_m)
        for shot in texture.flight(3, rows=2, columns=4, fix_m=0.3)
    ]
    maker = Mapmaker(MapOptions())
    maker.add_all(shots)
    maker.align()
    true_m = texture.HEIGHT_M / texture.CAMERA.matrix[0, 0]
    assert maker.finest_resolution_m == pytest.approx(true_m, rel=0.03)


@pytest.mark.parametrize('take_off', [-0.3, 0.3])
def test_heights_above_another_ground_do_not_change_the_scale(take_off):
    """A vehicle that takes off on a hill, or in a valley, tells all its heights wrong alike."""
    shots = [
        Shot(
            name=shot.record.shot_id,
            record=dataclasses.replace(
                shot.record, height_agl_m=shot.record.height_agl_m - take_off * texture.HEIGHT_M
            ),
            read=lambda shot=shot: shot.jpeg,
        )
        for shot in texture.flight(3, rows=2, columns=4, fix_m=0.3)
    ]
    maker = Mapmaker(MapOptions())
    maker.add_all(shots)
    alignment = maker.align()
    true_m = texture.HEIGHT_M / texture.CAMERA.matrix[0, 0]
    assert maker.finest_resolution_m == pytest.approx(true_m, rel=0.03)
    (lift_m,) = maker.block.state.lifts_m.values()
    assert lift_m == pytest.approx(take_off * texture.HEIGHT_M, abs=0.03 * texture.HEIGHT_M)
    assert violations(alignment, maker.block.state) == []


def test_photograph_without_ties_is_as_large_as_its_neighbours():
    """One of water, say, whose altitude is wrong by a hundred metres."""
    flown = texture.flight(4, rows=3, columns=4, fix_m=0.3)
    blank = texture.textured_ground(1)[:300, :400] // 255 + np.uint8(100)
    shots = [untold(shot) for shot in flown]
    jpeg = bytes(cv2.imencode('.jpg', blank)[1])
    wrong = dataclasses.replace(shots[5].record, altitude_m=shots[5].record.altitude_m + 100.0)
    shots[5] = Shot(name=shots[5].name, record=wrong, read=lambda: jpeg)
    maker = Mapmaker(MapOptions())
    maker.add_all(shots)
    alignment = maker.align()
    placement = alignment.placements[shots[5].name]
    assert placement.placed_by == 'gps'
    assert placement.pose.centre[2] == pytest.approx(texture.HEIGHT_M, rel=0.1)


def test_photograph_without_ties_and_heading_is_left_out_by_name():
    """Drawn with north up, it would lie wrong over its neighbours and spoil the stated error."""
    unknown = (0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, math.pi**2)
    shots = [
        untold(shot, orientation_covariance_rad2=unknown)
        for shot in texture.flight(4, rows=3, columns=4, fix_m=0.3)
    ]
    blank = bytes(cv2.imencode('.jpg', np.full((300, 400, 3), 100, np.uint8))[1])
    shots[5] = Shot(name=shots[5].name, record=shots[5].record, read=lambda: blank)
    said = []
    maker = Mapmaker(MapOptions(), said.append)
    maker.add_all(shots)
    alignment = maker.align()
    assert alignment.placements.keys() == {shot.name for shot in shots} - {shots[5].name}
    (line,) = said
    assert line.startswith(f'not on the map: {shots[5].name}: nothing tells its heading')


def test_heights_that_nothing_shows_are_not_guessed():
    """A single photograph that tells no height has no scale."""
    maker = Mapmaker(MapOptions())
    maker.add_all([untold(texture.flight(1)[0])])
    with pytest.raises(PlacementError, match='no photograph tells its height above the ground'):
        maker.align()


def test_photographs_far_from_the_others_are_left_out_by_name():
    """Neither one at 0/0 nor one on another continent grows the map.

    One without a fix is kept until it is known whether the others tie it.
    """
    shots = [untold(shot) for shot in texture.flight(5, rows=2, columns=3, fix_m=0.3)]
    strange = [
        untold(texture.flight(5)[0], latitude_deg=0.0, longitude_deg=0.0),
        untold(texture.flight(5)[0], latitude_deg=math.nan),
        untold(texture.flight(5)[0], latitude_deg=-33.0, longitude_deg=151.0),
    ]
    strange = [
        Shot(name=f'odd{n}.jpg', record=shot.record, read=shot.read)
        for n, shot in enumerate(strange)
    ]
    said = []
    maker = Mapmaker(MapOptions(), said.append)
    maker.add_all([strange[0], *shots, *strange[1:]])
    assert len(maker) == len(shots) + 1
    assert sorted(text.split(':')[1].strip() for text in said) == ['odd0.jpg', 'odd2.jpg']
    assert 'km from most other photographs' in said[1]


def test_fixes_that_are_all_alike_do_not_shrink_the_map():
    """A receiver that hangs tells one place: the told heights keep the scale."""
    flown = texture.flight(5, rows=2, columns=3)
    place = {
        name: getattr(flown[0].record, name)
        for name in ('latitude_deg', 'longitude_deg', 'altitude_m')
    }
    maker = Mapmaker(MapOptions())
    maker.add_all(
        [
            Shot(
                name=shot.record.shot_id,
                record=dataclasses.replace(shot.record, **place),
                read=lambda shot=shot: shot.jpeg,
            )
            for shot in flown
        ]
    )
    alignment = maker.align()
    true_m = texture.HEIGHT_M / texture.CAMERA.matrix[0, 0]
    assert maker.finest_resolution_m == pytest.approx(true_m, rel=0.1)
    assert violations(alignment, maker.block.state)


def test_two_cameras_of_unlike_pixels_are_tied():
    """The second shows the ground twice as large: what its focal length says."""
    shots = []
    for number, shot in enumerate(texture.flight(5, rows=3, columns=3, spacing_m=(9.0, 8.0))):
        record, jpeg = shot.record, shot.jpeg
        if number % 2:
            half = cv2.imdecode(np.frombuffer(jpeg, np.uint8), 1)[75:225, 100:300]
            jpeg = bytes(cv2.imencode('.jpg', cv2.resize(half, (400, 300)))[1])
            camera = record.camera
            camera = dataclasses.replace(
                camera, fx_px=2.0 * camera.fx_px, fy_px=2.0 * camera.fy_px
            )
            record = dataclasses.replace(record, camera=camera, lens='zoomed')
        shots.append(Shot(name=record.shot_id, record=record, read=lambda jpeg=jpeg: jpeg))
    maker = Mapmaker(MapOptions())
    maker.add_all(shots)
    alignment = maker.align()
    assert {placement.placed_by for placement in alignment.placements.values()} == {'features'}
    assert alignment.groups == (9,)


def test_places_are_told_apart_by_gaps():
    """A long survey is one place; the date line and the poles are no gap."""
    line = [(10.0, -180.0 + 0.01 * (step - 50) % 360.0 - 0.0) for step in range(100)]
    line = [(lat, (lon + 180.0) % 360.0 - 180.0) for lat, lon in line]
    assert not np.any(distances_from_most_m(line))
    away = distances_from_most_m([*line, (11.0, 180.0)])
    assert np.count_nonzero(away) == 1
    assert 100_000.0 < away[-1] < 140_000.0
    assert len(distances_from_most_m([])) == 0


def test_files_that_are_no_photographs_are_named_and_the_others_read(tmp_path):
    """A pipe does not block, a header of a huge picture is not believed."""
    shot = texture.flight(1)[0]
    (tmp_path / 'good.jpg').write_bytes(with_exif(shot.jpeg, shot.record))
    (tmp_path / 'empty.jpg').write_bytes(b'')
    (tmp_path / 'text.jpg').write_bytes(b'no picture at all')
    (tmp_path / 'folder.jpg').mkdir()
    os.mkfifo(tmp_path / 'pipe.jpg')
    head = struct.pack('>IIBBBBB', 60_000, 60_000, 8, 2, 0, 0, 0)
    chunk = b'IHDR' + head
    (tmp_path / 'bomb.jpg').write_bytes(
        b'\x89PNG\r\n\x1a\n' + struct.pack('>I', len(head)) + chunk
        + struct.pack('>I', zlib.crc32(chunk)) + b'\0\0\0\0IEND\xaeB`\x82'
    )  # fmt: skip
    said = []
    found = photographs_of(tmp_path, said.append)
    assert [shot.path.name for shot in found] == ['good.jpg']
    assert sorted(text.split('/')[-1].split(':')[0] for text in said) == [
        'bomb.jpg', 'empty.jpg', 'folder.jpg', 'pipe.jpg', 'text.jpg'
    ]  # fmt: skip
    assert all('\n' not in text for text in said)


def drifting(count, alike, rng):
    """Return errors of fixes (count, 2) that are like the one before by `alike`."""
    off = rng.normal(0.0, 3.0, (count, 2))
    for number in range(1, count):
        off[number] = alike * off[number - 1] + math.sqrt(1.0 - alike**2) * off[number]
    return off


@pytest.mark.parametrize('alike', [0.0, 0.6, 0.9])
@pytest.mark.parametrize('count', [9, 30])
def test_drifting_fixes_leave_the_place_of_the_whole_in_doubt(alike, count):
    """The drawn errors of the mean are as large as the true ones, over many flights."""
    true, drawn = [], []
    for seed in range(60):
        rng = np.random.default_rng(seed)
        places = np.array([(x, y) for x in range(count // 3) for y in range(3)]) * 20.0
        off = drifting(len(places), alike, rng)
        # What an adjustment does: the block takes shift, turn and scale of the fixes.
        plane, fixes = places @ [1, 1j], (places + off) @ [1, 1j]
        middle = plane - plane.mean()
        factor = np.vdot(middle, fixes - fixes.mean()) / np.vdot(middle, middle)
        found = fixes.mean() + factor * middle
        found_m = np.column_stack([found.real, found.imag])
        errors = fix_errors_m(places + off, found_m, 2.5, 48, rng)
        true.append(np.sum(off.mean(axis=0) ** 2))
        drawn.append(np.mean(np.sum(errors.mean(axis=0) ** 2, axis=0)))
    assert 0.6 < math.sqrt(np.mean(drawn) / np.mean(true)) < 1.7


@pytest.mark.parametrize('count', [1, 2])
def test_two_fixes_say_nothing_of_their_own_errors(count):
    """Their errors are drawn from the prior: the logarithm of their size is standard normal."""
    few = np.arange(2.0 * count).reshape(count, 2)
    errors = fix_errors_m(few, few, 3.0, 20_000, np.random.default_rng(0))
    # A product of two independent factors: the means of the logarithms of their squares add up.
    normal = np.log(np.random.default_rng(1).standard_normal(100_000) ** 2).mean()
    assert np.log(errors**2).mean() - normal == pytest.approx(2.0 * math.log(3.0), abs=0.05)


def test_a_wrong_claim_is_overruled_by_many_fixes():
    """Fixes that claim two centimetres but scatter by metres have errors of metres."""
    rng = np.random.default_rng(3)
    places = np.array([(x, y) for x in range(6) for y in range(5)]) * 20.0
    off = rng.normal(0.0, 4.0, places.shape)
    errors = fix_errors_m(places + off, places, 0.02, 200, rng)
    assert np.sqrt(np.mean(errors**2)) == pytest.approx(4.0, rel=0.25)
