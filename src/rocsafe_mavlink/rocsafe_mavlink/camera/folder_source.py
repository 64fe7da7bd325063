# SPDX-License-Identifier: Apache-2.0
"""Images from a folder into which files of the camera are copied."""

from collections.abc import Collection
from pathlib import Path

from rocsafe_mavlink.camera.source import CameraImage

SUFFIXES = ('.jpg', '.jpeg')
END_OF_JPEG = b'\xff\xd9'
LARGEST_FILE = 64 * 1024 * 1024


class FolderSource:
    """JPEG files that appear in a folder, each once and only when it is complete.

    Parameters
    ----------
    folder
        Where the files appear.
    """

    is_stream = False

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self._known: set[str] = set()
        self._sizes: dict[str, int] = {}

    def take(self) -> list[CameraImage]:
        """Return the files that were completed since the last call, by their time."""
        found = []
        for path in self._folder.glob('*'):
            if path.suffix.lower() in SUFFIXES and path.name not in self._known:
                image = self._whole(path)
                if image is not None:
                    self._known.add(path.name)
                    found.append(image)
        return sorted(found, key=lambda image: (image.unix_s, image.name))

    def at(self, _unix_s: float) -> CameraImage | None:
        """Return None: a folder is not asked for an image of a time."""
        return None

    def skip(self, names: Collection[str]) -> None:
        """Never return the files of these names."""
        self._known.update(names)

    def close(self) -> None:
        """Do nothing: no file is held open."""

    def _whole(self, path: Path) -> CameraImage | None:
        """Return the image if its file has stopped growing and ends as a JPEG file does."""
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
        return CameraImage(name=path.name, unix_s=status.st_mtime, jpeg=jpeg)
