# SPDX-License-Identifier: Apache-2.0
"""Images from a video stream: its frames with their times.

A stream that breaks, or sends nothing for longer than a deadline, is opened again without limit.
Frames are dated by the stream's own clock where it has one. That also dates frames correctly that
waited while the stream was opened, or in the network.
"""

import threading
from collections import deque
from collections.abc import Callable, Collection
from dataclasses import dataclass

import cv2

from rocsafe_mavlink.camera.source import CameraImage

# Environment of a process that opens streams, unless its user sets it: RTP over TCP, in
# the connection that we open. Over UDP the decoder would listen on ports of its own, everywhere.
DECODER_OPTIONS = ('OPENCV_FFMPEG_CAPTURE_OPTIONS', 'rtsp_transport;tcp')
DEVICE_PREFIX = '/dev/'


@dataclass(frozen=True, slots=True, kw_only=True)
class VideoOptions:
    """Options of reading a stream.

    Attributes
    ----------
    frames_kept
        Number of frames that are kept until their trigger is known.
    jpeg_quality
        Quality of the photographs, 0 to 100.
    open_deadline_s, read_deadline_s
        A camera that sends nothing for so long is opened again, seconds.
    retry_s
        Time between two attempts to open it, seconds.
    largest_distance_s
        If no frame is nearer to a trigger, the camera was away; seconds.
    """

    frames_kept: int = 60
    jpeg_quality: int = 92
    open_deadline_s: float = 4.0
    read_deadline_s: float = 4.0
    retry_s: float = 1.0
    largest_distance_s: float = 0.5


VIDEO = VideoOptions()


@dataclass(frozen=True, slots=True)
class VideoFrame:
    """One frame of a stream.

    Attributes
    ----------
    arrived_s
        Time of day at which it was read.
    told_s
        Time by the clock of the stream, from its start.
    pixels
        The image.
    """

    arrived_s: float
    told_s: float
    pixels: cv2.typing.MatLike


class VideoSource:
    """The frames of a stream; a thread reads them, since reading waits for the next one.

    Parameters
    ----------
    address
        What OpenCV opens: ``rtsp://...``, ``http://...``, ``/dev/video0``, a file.
    clock
        Returns the time of day.
    """

    is_stream = True

    def __init__(self, address: str, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._frames: deque[VideoFrame] = deque(maxlen=VIDEO.frames_kept)
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._read, args=(address,), daemon=True)
        self._thread.start()

    def take(self) -> list[CameraImage]:
        """Return nothing: a stream is asked for the frame of a time."""
        return []

    def at(self, unix_s: float) -> CameraImage | None:
        """Return the frame nearest to `unix_s`; None if none is near yet."""
        frames = list(self._frames)
        if not self._is_over.is_set() and is_catching_up(frames, self._clock()):
            return None
        dated = dates_of(frames)
        if not dated:
            return None
        taken_s, pixels = min(dated, key=lambda frame: abs(frame[0] - unix_s))
        if abs(taken_s - unix_s) > VIDEO.largest_distance_s:
            return None
        is_written, jpeg = cv2.imencode(
            '.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, VIDEO.jpeg_quality]
        )
        name = f'{taken_s:.3f}.jpg'
        return CameraImage(name=name, unix_s=taken_s, jpeg=jpeg.tobytes()) if is_written else None

    def skip(self, names: Collection[str]) -> None:
        """Do nothing: a stream returns no image of the past."""

    def close(self) -> None:
        """Stop reading."""
        self._is_over.set()
        self._thread.join(timeout=2.0)

    def _read(self, address: str) -> None:
        while not self._is_over.is_set():
            capture = _opened(address)
            while capture.isOpened() and not self._is_over.is_set():
                is_read, pixels = capture.read()
                if not is_read:
                    break
                self._keep(pixels, capture.get(cv2.CAP_PROP_POS_MSEC) / 1e3)
            capture.release()
            self._is_over.wait(VIDEO.retry_s)

    def _keep(self, pixels: cv2.typing.MatLike, told_s: float) -> None:
        arrived_s = self._clock()
        if self._frames and told_s < self._frames[-1].told_s:
            # The stream was opened again: its clock restarted.
            self._frames.clear()
        self._frames.append(VideoFrame(arrived_s, told_s, pixels))


def is_catching_up(frames: list[VideoFrame], now_s: float) -> bool:
    """Return whether frames that waited while the stream was opened are still arriving at `now_s`.

    They come faster than they were taken, each with less delay than all before it. Until the last
    of them has come, the offset of the stream's clock is not known.
    """
    if not frames or now_s - frames[-1].arrived_s > VIDEO.largest_distance_s:
        return False
    if len(frames) < 2:
        return True
    *before, newest_s = (frame.arrived_s - frame.told_s for frame in frames)
    return newest_s < min(before) - 0.5 * (frames[-1].told_s - frames[-2].told_s)


def dates_of(frames: list[VideoFrame]) -> list[tuple[float, cv2.typing.MatLike]]:
    """Return the time of day at which each of `frames` was taken, and its pixels.

    The frame with the least delay gives the offset of the stream's clock to the time of day.
    Frames of a stream without a clock are dated by arrival.
    """
    if not frames:
        return []
    if not frames[-1].told_s > frames[0].told_s:
        return [(frame.arrived_s, frame.pixels) for frame in frames]
    ahead_s = min(frame.arrived_s - frame.told_s for frame in frames)
    return [(frame.told_s + ahead_s, frame.pixels) for frame in frames]


def _opened(address: str) -> cv2.VideoCapture:
    if address.startswith(DEVICE_PREFIX):
        return cv2.VideoCapture(address)
    deadlines = [
        *(cv2.CAP_PROP_OPEN_TIMEOUT_MSEC, round(1e3 * VIDEO.open_deadline_s)),
        *(cv2.CAP_PROP_READ_TIMEOUT_MSEC, round(1e3 * VIDEO.read_deadline_s)),
    ]
    return cv2.VideoCapture(address, cv2.CAP_FFMPEG, deadlines)
