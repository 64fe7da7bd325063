# SPDX-License-Identifier: Apache-2.0
"""What draws: the software pipe exactly, other threads and processes the same, a GPU as well."""

import os

import numpy as np
import pytest
from test.scene.drawn_frames import FIELDS, LENS, drawn, poses, scene
from test.scene.ray_scene import RayScene

from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.scene.environment import GROUND_NUMBER

pytestmark = pytest.mark.slow

pytest.importorskip('panda3d', reason='panda3d is not installed')
GPU = 'ROCSAFE_TEST_EGL_DEVICE'
# Every third pixel in both directions is checked.
STEP = 3


@pytest.fixture(scope='module')
def plain(tmp_path_factory):
    """Return the frames of the software pipe, found where no vendor's EGL is, and its log."""
    return drawn(tmp_path_factory.mktemp('plain'), __EGL_VENDOR_LIBRARY_FILENAMES='/nowhere')


def truth(pose):
    """Return instances and depth by casting a ray through every third pixel each way."""
    position, rotation = pose
    v, u = np.mgrid[0 : LENS.image_height_px : STEP, 0 : LENS.image_width_px : STEP]
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
    optical = np.linalg.solve(LENS.matrix, pixels).T
    length = np.linalg.norm(optical, axis=1)
    directions = optical @ rotation.T / length[:, None]
    hits = RayScene(scene()).first_hits(np.broadcast_to(position, directions.shape), directions)
    return hits.numbers.reshape(u.shape), (hits.distances_m / length).reshape(u.shape)


def off_edges(values):
    """Return whether a pixel's eight neighbours have its value."""
    same = np.ones(values.shape, bool)
    for shift in np.ndindex(3, 3):
        same &= np.roll(values, (shift[0] - 1, shift[1] - 1), (0, 1)) == values
    same[[0, -1]] = same[:, [0, -1]] = False
    return same


def test_the_lack_of_egl_is_said_once_with_what_to_install(plain):
    """In one line of the log, and in the renderer's name, which photographs carry."""
    frames, log = plain
    lines = [line for line in log.splitlines() if 'software pipe' in line]
    assert len(lines) == 1
    assert lines[0].endswith(
        'sudo apt install --no-install-recommends libegl1 libgl1 libgl1-mesa-dri'
    )
    assert frames['degraded'] is True
    assert frames['renderer'].startswith('Panda3D software pipe')


@pytest.mark.parametrize('name', ['nadir', 'oblique'])
def test_labels_and_depth_are_exact_without_egl(plain, name):
    """Off silhouettes the ids are those of ray casting; depth within a centimetre."""
    frames, _ = plain
    expected, depth = truth(poses()[name])
    moving = scene().objects[-1].number
    numbers = frames[f'{name}-0-numbers']
    clear = off_edges(numbers)[::STEP, ::STEP] & (expected != moving)
    numbers = numbers[::STEP, ::STEP]
    clear &= numbers != moving
    assert clear.mean() > 0.7
    same = numbers == expected
    assert same[clear].mean() >= 0.9999
    clear &= same & (numbers > 0) & (depth < 40.0)
    found = frames[f'{name}-0-depth_m'][::STEP, ::STEP]
    error = np.abs(found[clear] - depth[clear])
    assert np.quantile(error[numbers[clear] == GROUND_NUMBER], 0.99) <= 0.01
    # Along edges within a thing of many small faces the pipe may take the neighbour's.
    assert np.quantile(error, 0.9) <= 0.01


def test_the_plain_picture_shows_the_scene(plain):
    """Sky is far and has no number; things are lit, not black."""
    frames, _ = plain
    is_sky = frames['up-0-numbers'] == 0
    assert is_sky.mean() > 0.4
    assert np.isinf(frames['up-0-depth_m'][is_sky]).all()
    assert (frames['up-0-classes'][is_sky] == class_number('sky')).all()
    assert frames['nadir-0-image'].mean() > 40.0
    assert frames['nadir-0-image'].std() > 10.0
    kinds = set(np.unique(frames['nadir-0-classes']).tolist())
    assert {class_number(label) for label in ('grass', 'tank_car', 'house')} <= kinds


def test_what_moves_moves_without_egl(plain):
    """Labels go along; back at the start all is as it was, to the last byte."""
    frames, _ = plain
    number = scene().objects[-1].number
    columns = [
        np.nonzero(frames[f'nadir-{time_s}-numbers'] == number)[1].mean() for time_s in (0, 5)
    ]
    assert abs(columns[0] - columns[1]) > 20.0
    for name in poses():
        for field in FIELDS:
            key = f'{name}-0-{field}'
            assert np.array_equal(frames[key], frames[f'{key}-again']), key


def test_other_processes_and_threads_draw_the_same_bytes(tmp_path):
    """One thread or two, this process or that: nothing differs."""
    first, _ = drawn(tmp_path, LP_NUM_THREADS='1')
    if first['degraded']:
        pytest.skip('no EGL here')
    second, _ = drawn(tmp_path, LP_NUM_THREADS='2')
    for key, value in first.items():
        assert np.array_equal(value, second[key]), key


@pytest.mark.skipif(GPU not in os.environ, reason=f'{GPU} names no graphics device')
def test_a_gpu_draws_what_the_processor_draws(tmp_path):
    """The same labels off silhouettes, depth within 1 cm, pictures alike: PSNR above 30 dB."""
    frames, _ = drawn(tmp_path, ROCSAFE_EGL_DEVICE=os.environ[GPU])
    software = {'EGL_PLATFORM': 'surfaceless', 'LIBGL_ALWAYS_SOFTWARE': '1'}
    plain, _ = drawn(tmp_path, **software)
    assert 'llvmpipe' in plain['renderer']
    for name in ('nadir', 'oblique'):
        numbers = plain[f'{name}-0-numbers']
        clear = off_edges(numbers)
        assert (frames[f'{name}-0-numbers'] == numbers)[clear].mean() >= 0.9999
        near = clear & (plain[f'{name}-0-depth_m'] < 40.0)
        error = np.abs(frames[f'{name}-0-depth_m'] - plain[f'{name}-0-depth_m'])[near]
        assert np.quantile(error, 0.999) <= 0.01
        off = frames[f'{name}-0-image'].astype(float) - plain[f'{name}-0-image']
        assert 10.0 * np.log10(255.0**2 / np.mean(off**2)) > 30.0
