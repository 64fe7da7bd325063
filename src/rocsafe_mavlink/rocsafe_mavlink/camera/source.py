# SPDX-License-Identifier: Apache-2.0
"""An image of a real camera, and the protocol of its sources."""

from collections.abc import Collection
from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraImage:
    """A JPEG file and its time by the clock that dated it, seconds since 1970."""

    name: str
    unix_s: float
    jpeg: bytes


class ImageSource(Protocol):
    """Source of the images of one camera.

    Attributes
    ----------
    is_stream
        Whether it has an image for any time and is asked by `at`; otherwise `take` returns them.
    """

    is_stream: bool

    def take(self) -> list[CameraImage]:
        """Return the images that came since the last call, oldest first."""

    def at(self, unix_s: float) -> CameraImage | None:
        """Return the image of a time; None if there is none."""

    def skip(self, names: Collection[str]) -> None:
        """Never return the images of these names: they were used before."""

    def close(self) -> None:
        """Stop."""
