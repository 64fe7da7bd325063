# SPDX-License-Identifier: Apache-2.0
"""Where the pictures of a real camera come from: a folder that is watched, or a video stream."""

import threading
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

import cv2

SUFFIXES = ('.jpg', '.jpeg')
END_OF_JPEG = b'\xff\xd9'
LARGEST_FILE = 64 * 1024 * 1024
# Frames of a stream that are kept until their shot is known.
FRAMES_KEPT = 60
JPEG_QUALITY = 92
STREAM_PREFIXES = ('rtsp://', 'http://', 'https://', '/dev/video')


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """An image file and when it was taken by the clock of whoever wrote it, seconds since 1970."""

    name: str
    unix_s: float
    jpeg: bytes


class PictureSource(Protocol):
    """What pictures are taken from."""

    def take(self) -> list[Picture]:
        """Return the pictures that came since the last call, oldest first."""

    def at(self, unix_s: float) -> Picture | None:
        """Return the picture nearest to a time, if the source has one at any time."""

    def close(self) -> None:
        """Stop."""


class WatchedFolder:
    """JPEG files as they appear in a folder, each once and only when it is whole."""

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: set[str] = set()
        self._sizes: dict[str, int] = {}

    def take(self) -> list[Picture]:
        """Return the files that have become whole since the last call, by their time."""
        found = []
        for path in self._folder.glob('*'):
            if path.suffix.lower() in SUFFIXES and path.name not in self._known:
                picture = self._whole(path)
                if picture is not None:
                    self._known.add(path.name)
                    found.append(picture)
        return sorted(found, key=lambda picture: (picture.unix_s, picture.name))

    def at(self, _unix_s: float) -> Picture | None:
        """Return nothing: files come when they come."""
        return None

    def close(self) -> None:
        """Do nothing: no file is held."""

    def _whole(self, path: Path) -> Picture | None:
        """Return the picture if its file has stopped growing and ends as a JPEG file does."""
        try:
            status = path.stat()
            is_stable = self._sizes.get(path.name) == status.st_size
            self._sizes[path.name] = status.st_size
            if not is_stable or not 0 < status.st_size <= LARGEST_FILE:
                return None
            jpeg = path.read_bytes()
        except OSError:
            return None
        if END_OF_JPEG not in jpeg[-64:]:
            return None
        del self._sizes[path.name]
        return Picture(name=path.name, unix_s=status.st_mtime, jpeg=jpeg)


class VideoStream:
    """The frames of a stream; a thread reads them, since reading waits for the next.

    Parameters
    ----------
    address: what OpenCV opens: ``rtsp://...``, ``/dev/video0``, a file.
    clock: returns the time of day.
    """

    def __init__(self, address: str, clock: Callable[[], float]) -> None:
        self._clock = clock
        self._frames: deque[tuple[float, cv2.typing.MatLike]] = deque(maxlen=FRAMES_KEPT)
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._read, args=(address,), daemon=True)
        self._thread.start()

    def take(self) -> list[Picture]:
        """Return nothing: a stream is asked for the frame of a time."""
        return []

    def at(self, unix_s: float) -> Picture | None:
        """Return the frame nearest to `unix_s`; None while there is none."""
        frames = list(self._frames)
        if not frames:
            return None
        taken_s, pixels = min(frames, key=lambda frame: abs(frame[0] - unix_s))
        is_written, jpeg = cv2.imencode('.jpg', pixels, [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])
        name = f'{taken_s:.3f}.jpg'
        return Picture(name=name, unix_s=taken_s, jpeg=jpeg.tobytes()) if is_written else None

    def close(self) -> None:
        """Stop reading."""
        self._is_over.set()
        self._thread.join(timeout=2.0)

    def _read(self, address: str) -> None:
        while not self._is_over.is_set():
            capture = cv2.VideoCapture(address)
            while capture.isOpened() and not self._is_over.is_set():
                is_read, pixels = capture.read()
                if not is_read:
                    break
                self._frames.append((self._clock(), pixels))
            capture.release()
            # A stream that broke is opened again.
            self._is_over.wait(1.0)


def open_source(text: str, clock: Callable[[], float]) -> PictureSource | None:
    """Return where pictures come from; None if `text` is empty.

    Raises
    ------
    ValueError: if it is neither a folder nor a stream.
    """
    if not text:
        return None
    if text.startswith(STREAM_PREFIXES):
        return VideoStream(text, clock)
    folder = Path(text)
    if not folder.is_dir():
        raise ValueError(f'image folder {text!r} is no folder, nor rtsp://..., nor /dev/video...')
    return WatchedFolder(folder)
