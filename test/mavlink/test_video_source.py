# SPDX-License-Identifier: Apache-2.0
"""Streams of cameras on the loopback interface: dated, and opened again when they break."""

import time

import cv2
import numpy as np
import pytest
from test.fakes.camera import GREYS, RATE_HZ, Camera, HttpCamera, RtspCamera, number_of
from test.mavlink.telemetry import ready
from test.mavlink.test_camera import context, feedback

from rocsafe_mavlink.assembly import open_source
from rocsafe_mavlink.camera import video_source
from rocsafe_mavlink.camera.geotagging import Geotagger
from rocsafe_mavlink.camera.numbering import ShotNumbering
from rocsafe_mavlink.camera.video_source import (
    VideoFrame,
    VideoOptions,
    VideoSource,
    dates_of,
    is_catching_up,
)

# Of a viewer that looks at a stream for some seconds before it shows it, on a busy machine.
DEADLINE_S = 60.0
# By how much a frame may be dated wrongly: the machine is busy, greys come round after 3 s.
LARGEST_ERROR_S = 1.0


def until(condition):
    """Wait until `condition` holds; return what it returned."""
    end = time.monotonic() + DEADLINE_S
    while not (found := condition()):
        assert time.monotonic() < end, 'nothing came'
        time.sleep(0.02)
    return found


def error_s(picture):
    """Return by how much a picture of a camera is dated wrongly, seconds."""
    return seconds_apart(number_of(picture.jpeg), Camera.number_at(picture.unix_s))


def seconds_apart(number, other):
    """Return the time between frames of two numbers, up to half of that of all greys."""
    away = (number - other) % GREYS
    return min(away, GREYS - away) / RATE_HZ


@pytest.mark.slow
@pytest.mark.flaky(reruns=1)  # the camera's clock goes on while the machine stands still
@pytest.mark.parametrize('kind', [RtspCamera, HttpCamera], ids=['rtsp', 'http'])
def test_camera_is_opened_again(kind, monkeypatch):
    """It stands still with its line open, is switched off and on: its frames come as before."""
    monkeypatch.setattr(video_source, 'VIDEO', VideoOptions(read_deadline_s=2.0, retry_s=0.1))
    camera = kind()
    camera.is_frozen = True
    stream = open_source(camera.address, time.time)
    assert stream.at(time.time()) is None
    camera.is_frozen = False
    first = until(lambda: stream.at(time.time()))
    assert error_s(first) < LARGEST_ERROR_S
    shots_get_their_frames(stream)
    camera.is_frozen, callers = True, camera.callers
    until(lambda: camera.callers > callers)
    camera.is_frozen = False
    assert error_s(until(lambda: stream.at(time.time()))) < LARGEST_ERROR_S
    camera.close()
    until(lambda: stream.at(time.time()) is None)
    camera = kind(camera.port)
    again = until(lambda: stream.at(time.time()))
    assert error_s(again) < LARGEST_ERROR_S
    stream.close()
    camera.close()


def shots_get_their_frames(stream):
    """Check photographs: of shots now, of one of long ago, and by a clock that was never set."""
    made, told, moments_s = Geotagger(ShotNumbering(), stream, None), [], []
    for index, behind_s in enumerate((0.0, 0.0, 60.0, 0.0)):
        # The machine may stand still, and so the camera: then there is none of that moment.
        now_s = until(lambda: (moment_s := time.time()) and stream.at(moment_s) and moment_s)
        taken_s = 1.1e9 + index if index == 3 else now_s - behind_s
        made.on_message(feedback(index, taken_s), ready(), now_s - behind_s)
        moments_s += [] if behind_s else [now_s]
        time.sleep(0.3)
    shots = made.tagged(context(), told.append)
    assert told == ['rav1: shot 2 has no picture: the camera sent none then']
    assert [shot.sequence for shot in shots] == [0, 1, 2]
    numbers = [number_of(shot.jpeg) for shot in shots]
    assert len(set(numbers)) == 3
    for number, moment_s in zip(numbers, moments_s, strict=True):
        assert seconds_apart(number, Camera.number_at(moment_s)) < LARGEST_ERROR_S
    assert (shots[0].width_px, shots[0].height_px) == (160, 120)


def test_frames_that_waited_are_dated_by_the_clock_of_the_stream():
    """Read all at once after opening; one without a clock is dated by arrival."""
    waited = [VideoFrame(100.5 + 0.001 * n, 0.1 * n, n) for n in range(20)]
    later = [VideoFrame(98.2 + 0.1 * n, 0.1 * n, n) for n in range(20, 30)]
    dates = [taken_s for taken_s, _ in dates_of([*waited, *later])]
    assert dates == pytest.approx([98.2 + 0.1 * n for n in range(30)])
    silent = [VideoFrame(100.0 + n, -1e17, n) for n in range(3)]
    assert [taken_s for taken_s, _ in dates_of(silent)] == [100.0, 101.0, 102.0]
    assert dates_of([]) == []


def test_video_gives_the_frame_of_the_moment(tmp_path):
    """Frames are dated by the file's own times; a shot takes the nearest, if one is near."""
    path = str(tmp_path / 'clip.avi')
    writer = cv2.VideoWriter(path, cv2.VideoWriter_fourcc(*'MJPG'), 10.0, (64, 48))
    for value in (0, 120, 240):
        writer.write(np.full((48, 64, 3), value, np.uint8))
    writer.release()
    now_s = time.time()
    stream = VideoSource(path, lambda: now_s)
    until(lambda: len(stream._frames) >= 3)
    stream.close()
    frames = list(stream._frames)[:3]
    stream._frames.clear()
    stream._frames.extend(frames)
    taken = stream.at(now_s - 0.08)
    assert taken.unix_s == pytest.approx(now_s - 0.1)
    pixels = cv2.imdecode(np.frombuffer(taken.jpeg, np.uint8), cv2.IMREAD_COLOR)
    assert abs(int(pixels.mean()) - 120) < 4
    assert stream.at(now_s + 5.0) is None


def test_frames_that_waited_do_not_tell_the_clock():
    """Until one came when it was due: the newest of them is less under way than all before."""
    waited = [VideoFrame(100.5 + 0.001 * n, 0.1 * n, n) for n in range(20)]
    assert all(is_catching_up(waited[:count], 100.52) for count in range(1, 21))
    later = [*waited, VideoFrame(100.52, 2.0, 20), VideoFrame(100.62, 2.1, 21)]
    assert not is_catching_up(later, 100.62)
    silent = [VideoFrame(100.0 + n, -1e17, n) for n in range(2)]
    assert not is_catching_up(silent, 101.0)


def test_frames_that_came_at_once_are_dated_when_no_more_come():
    """A file is read faster than it was filmed."""
    waited = [VideoFrame(100.5 + 0.001 * n, 0.1 * n, n) for n in range(20)]
    assert not is_catching_up(waited, 101.1)
    assert not is_catching_up([], 0.0)
