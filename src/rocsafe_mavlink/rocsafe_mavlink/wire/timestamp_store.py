# SPDX-License-Identifier: Apache-2.0
"""Time stamps of signatures that outlive the process.

A file keeps a limit a little ahead of the last stamp. It is written, synchronously, only when a
stamp passes the limit. After a crash everything up to the limit counts as used, so that nothing
can be replayed; genuine messages are refused for at most that second.
"""

import json
from pathlib import Path

from rocsafe_geo.storage.kept_file import KeptFile

StreamKey = tuple[int, int, int]
# Distance of a limit ahead, in ticks of 10 microseconds: one write a second and stream.
RESERVE_TICKS = 100_000
LARGEST_STREAM_COUNT = 16
LARGEST_FILE = 16_384
_SENT = 'sent'


class TimestampStore:
    """Highest time stamps: sent, and received by stream (link id, system, component).

    Parameters
    ----------
    path
        File that keeps them; None keeps them in memory only.

    Raises
    ------
    ValueError
        If the file is damaged.
    """

    def __init__(self, path: Path | None = None) -> None:
        self._file = KeptFile(path)
        self._limits: dict[str, int] = _read(path)
        self._used = dict(self._limits)

    @property
    def fault(self) -> str:
        """Why the limits are not on disk; empty: they are."""
        return self._file.fault

    @property
    def is_full(self) -> bool:
        """Whether no further stream can be stored."""
        return len(self._used.keys() - {_SENT}) >= LARGEST_STREAM_COUNT

    @property
    def limits(self) -> dict[str, int]:
        """Time stamps up to which everything counts as used, by name of the stream."""
        return dict(self._limits)

    def take_back(self, now: int) -> list[str]:
        """Set those that are ahead of `now` to `now`, and return their names."""
        ahead = sorted(name for name, ticks in self._limits.items() if ticks > now)
        for name in ahead:
            self._limits[name] = self._used[name] = now
        self._file.require(self._content())
        return ahead

    def last_of(self, stream: StreamKey) -> int | None:
        """Return the highest accepted time stamp of `stream`, None if it is new."""
        return self._used.get(_name(stream))

    def newest(self, now: int) -> int:
        """Return our own time: `now` by the clock, or a later stamp that was sent or accepted."""
        return max(now, *self._used.values()) if self._used else now

    def accept(self, stream: StreamKey, ticks: int) -> None:
        """Store `ticks` as used by `stream`."""
        self._use(_name(stream), ticks)

    def next_sent(self, now: int) -> int:
        """Return the next time stamp to send: our own time, or just above the last stamp.

        If our clock is behind that of an accepted sender, stamps follow the sender: others would
        refuse ours otherwise.
        """
        ticks = max(self.newest(now), self._used.get(_SENT, 0) + 1)
        self._use(_SENT, ticks)
        return ticks

    def _use(self, name: str, ticks: int) -> None:
        self._used[name] = ticks
        if ticks > self._limits.get(name, -1):
            self._limits[name] = ticks + RESERVE_TICKS
            # A link in use goes on where the disk fails; it is tried again within a second.
            self._file.keep(self._content())

    def _content(self) -> bytes:
        return json.dumps(self._limits).encode()


def _name(stream: StreamKey) -> str:
    return '/'.join(str(part) for part in stream)


def _read(path: Path | None) -> dict[str, int]:
    if path is None or not path.exists():
        return {}
    try:
        with path.open('rb') as file:
            limits = json.loads(file.read(LARGEST_FILE))
        return {str(name): int(ticks) for name, ticks in limits.items()}
    except (AttributeError, TypeError, ValueError) as error:
        raise ValueError(f'time stamps in {path} are damaged: {error}') from error
