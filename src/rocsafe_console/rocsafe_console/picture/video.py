# SPDX-License-Identifier: Apache-2.0
"""Newest picture of each camera that somebody looks at; of the others, none is heard."""

import struct
from collections import Counter
from dataclasses import dataclass, field

MOST_WATCHERS = 20
MOST_BYTES = 4_000_000
JPEG_HEAD = b'\xff\xd8'
# Time of the wall at which the picture was taken, seconds; the JPEG follows.
# Name of the live view of the scene among the cameras.
SCENE = 'scene'
HEAD = struct.Struct('<d')


@dataclass(frozen=True, slots=True, kw_only=True)
class VideoPicture:
    """A picture of a camera.

    Attributes
    ----------
    number
        Rises with each picture of all cameras.
    taken_s
        When it was taken, seconds of the wall.
    jpeg
        The picture.
    """

    number: int
    taken_s: float
    jpeg: bytes

    def pack(self) -> bytes:
        """Return what the page gets."""
        return HEAD.pack(self.taken_s) + self.jpeg


@dataclass(slots=True)
class Video:
    """Cameras that are looked at. Whoever uses it holds the lock of the picture."""

    _watchers: Counter[str] = field(default_factory=Counter)
    _newest: dict[str, VideoPicture] = field(default_factory=dict)
    _count: int = 0

    @property
    def wanted(self) -> frozenset[str]:
        """Vehicles whose camera somebody looks at."""
        return frozenset(self._watchers)

    def join(self, vehicle: str) -> bool:
        """Begin to look at the camera of a vehicle; return whether there was room."""
        if self._watchers.total() >= MOST_WATCHERS:
            return False
        self._watchers[vehicle] += 1
        return True

    def leave(self, vehicle: str) -> None:
        """End it; what nobody looks at is forgotten."""
        self._watchers[vehicle] -= 1
        if self._watchers[vehicle] <= 0:
            del self._watchers[vehicle]
            self._newest.pop(vehicle, None)

    def put(self, vehicle: str, jpeg: bytes, taken_s: float) -> None:
        """Take a picture over, unless nobody wants it, it is older, or it is no JPEG."""
        before = self._newest.get(vehicle)
        is_old = before is not None and taken_s < before.taken_s
        if vehicle not in self._watchers or is_old or len(jpeg) > MOST_BYTES:
            return
        if jpeg.startswith(JPEG_HEAD):
            self._count += 1
            picture = VideoPicture(number=self._count, taken_s=taken_s, jpeg=jpeg)
            self._newest[vehicle] = picture

    def newest(self, vehicle: str) -> VideoPicture | None:
        """Return the newest picture, None if there is none."""
        return self._newest.get(vehicle)
