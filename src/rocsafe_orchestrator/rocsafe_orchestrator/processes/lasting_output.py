# SPDX-License-Identifier: Apache-2.0
"""Output of a command that continues after its reader has gone."""

import os
import sys
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, TextIO

from rocsafe_ros.process.standard_streams import open_standard_streams


class LastingStream:
    """A text stream that ends in nothing once it cannot be written.

    A pipe without a reader (``| head``), a terminal that was closed and a full disk end what is
    shown, not what is done. Letters that its encoding does not have are shown as escapes.
    """

    def __init__(self, stream: TextIO) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write `text`, or nothing."""
        try:
            return self._stream.write(self._shown(text))
        except OSError:
            self._lose()
            return len(text)

    def flush(self) -> None:
        """Flush, or do nothing."""
        try:
            self._stream.flush()
        except OSError:
            self._lose()

    def _shown(self, text: str) -> str:
        encoding = self._stream.encoding or 'utf-8'
        return text.encode(encoding, 'backslashreplace').decode(encoding)

    def _lose(self) -> None:
        """Discard all further output, also what is in the buffer."""
        nowhere = os.open(os.devnull, os.O_WRONLY)
        with suppress(OSError, ValueError):
            os.dup2(nowhere, self._stream.fileno())
        os.close(nowhere)


@contextmanager
def lasting_output() -> Iterator[None]:
    """Let standard output and errors be lost without an exception inside of the block.

    They may be closed from the begin.
    """
    open_standard_streams()
    former = sys.stdout, sys.stderr
    sys.stdout, sys.stderr = (LastingStream(stream) for stream in former)
    try:
        yield
    finally:
        sys.stdout.flush()
        sys.stderr.flush()
        sys.stdout, sys.stderr = former
