# SPDX-License-Identifier: Apache-2.0
"""Writer of the evidence logs: that of the running mission, else that of the console."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from threading import Lock
from typing import Any

from rocsafe_console.evidence.chain import LOG_NAME, EvidenceLog, line_of, read_log

CONSOLE_LOG = 'console.jsonl'
MOST_WAITING = 100_000
# Nodes tell these again to whoever comes late.
_TOLD_AGAIN = frozenset({'decision', 'photograph', 'lease', 'phase', 'product'})
_OWN_KEYS = frozenset({'n', 'before', 'hash', 'time_s'})


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """Something that the evidence log keeps; time by the clock on the wall, seconds."""

    time_s: float
    kind: str
    by: str
    what: Mapping[str, Any]


class Desk:
    """Writes events to the log of their run, from any thread.

    The thread of ROS only adds: a slow disk never slows it, and `drain` writes. Orders are written
    at once, before they are sent.

    Parameters
    ----------
    runs
        Folder of the runs. Where there is no folder of the mission in it, the log of the console
        takes its events.
    """

    def __init__(self, runs: Path) -> None:
        self._runs = runs
        self._mission = ''
        self._waiting: list[tuple[str, Event]] = []
        self._adding, self._writing = Lock(), Lock()
        self._logs: dict[Path, EvidenceLog] = {}
        self._told: dict[Path, set[bytes]] = {}
        self.lost = 0

    def on_mission(self, mission: str) -> None:
        """Take events for this mission from now on."""
        with self._adding:
            self._mission = mission

    def add(self, event: Event) -> None:
        """Keep an event until it is written; if too many wait, it is counted as lost."""
        with self._adding:
            if len(self._waiting) < MOST_WAITING:
                self._waiting.append((self._mission, event))
            else:
                self.lost += 1

    def drain(self) -> None:
        """Write what waits. Events that cannot be written wait on.

        Raises
        ------
        OSError, EvidenceError
            If a log cannot be written.
        """
        with self._writing:
            while self._waiting:
                mission, event = self._waiting[0]
                self._write(mission, event)
                with self._adding:
                    self._waiting.pop(0)

    def write(self, event: Event) -> None:
        """Write an event: it is safely on disk on return.

        Raises
        ------
        OSError, EvidenceError
            If its log cannot be written.
        """
        with self._writing:
            self._write(self._mission, event)

    def close(self) -> None:
        """Write what waits, and close the logs."""
        self.drain()
        for log in self._logs.values():
            log.close()

    def _write(self, mission: str, event: Event) -> None:
        path = self._path(mission)
        if path not in self._logs:
            self._logs[path] = EvidenceLog(path)
            self._told[path] = _told(path)
        key = line_of({**event.what, 'kind': event.kind, 'by': event.by})
        if event.kind in _TOLD_AGAIN and key in self._told[path]:
            return
        self._logs[path].add(event.time_s, event.kind, event.by, **event.what)
        if event.kind in _TOLD_AGAIN:
            self._told[path].add(key)

    def _path(self, mission: str) -> Path:
        folder = self._runs / mission
        is_there = mission and '/' not in mission and folder.is_dir()
        return folder / LOG_NAME if is_there else self._runs / CONSOLE_LOG


def _told(path: Path) -> set[bytes]:
    entries = read_log(path)
    return {
        line_of({key: value for key, value in entry.items() if key not in _OWN_KEYS})
        for entry in entries
        if entry['kind'] in _TOLD_AGAIN
    }
