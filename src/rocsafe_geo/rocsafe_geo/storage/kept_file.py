# SPDX-License-Identifier: Apache-2.0
"""A small file that outlives its process, on a disk that may be full or fail."""

from collections.abc import Callable
from pathlib import Path

from rocsafe_geo.storage.durable import write_whole


class KeptFile:
    """Writes the newest content of a file; a process in flight goes on where that fails.

    Parameters
    ----------
    path
        The file; its folder is made. None: nothing is written.
    write
        Writes it: `write_whole`, or the faster `replace_whole`.

    Attributes
    ----------
    fault
        Why the newest content is not on disk; empty: it is.
    """

    def __init__(
        self, path: Path | None, write: Callable[[Path, bytes], None] = write_whole
    ) -> None:
        self.fault = ''
        self._path = path
        self._write = write

    def require(self, content: bytes) -> None:
        """Write `content`; once this returns, it is on disk.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        if self._path is None:
            return
        try:
            self._path.parent.mkdir(parents=True, exist_ok=True)
            self._write(self._path, content)
        except OSError as error:
            self.fault = f'{self._path.name} cannot be written: {error.strerror or error}'
            raise
        self.fault = ''

    def keep(self, content: bytes) -> None:
        """Write `content`; an error is only noted in `fault`."""
        try:
            self.require(content)
        except OSError:
            return
