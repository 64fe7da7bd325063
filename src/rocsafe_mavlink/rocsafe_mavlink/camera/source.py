# SPDX-License-Identifier: Apache-2.0
"""A picture of a real camera, and what pictures are taken from."""

from dataclasses import dataclass
from typing import Protocol


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraImage:
    """An image file and when it was taken by the clock of whoever wrote it, seconds since 1970."""

    name: str
    unix_s: float
    jpeg: bytes


class ImageSource(Protocol):
    """What pictures are taken from.

    Attributes
    ----------
    is_stream: whether it has a picture at any time, and is asked for it; else they are taken.
    """

    is_stream: bool

    def take(self) -> list[CameraImage]:
        """Return the pictures that came since the last call, oldest first."""

    def at(self, unix_s: float) -> CameraImage | None:
        """Return the picture of a time; None if there is none."""

    def close(self) -> None:
        """Stop."""
