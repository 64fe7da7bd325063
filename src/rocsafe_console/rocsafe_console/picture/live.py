# SPDX-License-Identifier: Apache-2.0
"""The picture between two threads: that of ROS writes it, that of the server reads it."""

from collections import OrderedDict
from dataclasses import dataclass, field
from pathlib import Path
from threading import Lock

from rocsafe_console.picture.picture import Picture
from rocsafe_console.picture.video import Video

MOST_PHOTOGRAPHS = 2000


@dataclass(slots=True)
class Live:
    """The picture, and pictures that are too large for it. Whoever uses it holds `lock`.

    Attributes
    ----------
    images
        PNG of ``dose_map``, ``plume`` and ``mosaic``, by name.
    photographs
        Files of stored photographs by shot.
    video
        Cameras that somebody looks at.
    """

    picture: Picture
    lock: Lock = field(default_factory=Lock)
    images: dict[str, bytes] = field(default_factory=dict)
    photographs: 'OrderedDict[str, Path]' = field(default_factory=OrderedDict)
    video: Video = field(default_factory=Video)

    def begin(self) -> None:
        """Forget the mission before."""
        self.picture = self.picture.next_one()
        self.images.clear()
        self.photographs.clear()

    def note_photograph(self, shot: str, path: Path) -> None:
        """Keep where a photograph lies; the oldest are forgotten."""
        self.photographs[shot] = path
        while len(self.photographs) > MOST_PHOTOGRAPHS:
            self.photographs.popitem(last=False)
