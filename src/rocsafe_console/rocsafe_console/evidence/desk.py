# SPDX-License-Identifier: Apache-2.0
"""Writer of what people do: to the log of the running mission, else to that of the console.

What the mission itself does is written by its recorder, to the same log.
"""

from contextlib import suppress
from pathlib import Path
from threading import Lock, Thread

from rocsafe_geo.evidence.evidence_log import LOG_NAME, Event, EvidenceLog

CONSOLE_LOG = 'console.jsonl'


class Desk:
    """Writes events to the log of their run, from any thread.

    Parameters
    ----------
    runs
        Folder of the runs. Where there is no folder of the mission in it, the log of the console
        takes its events.
    """

    def __init__(self, runs: Path) -> None:
        self._runs = runs
        self._mission = ''
        self._writing = Lock()
        self._logs: dict[Path, EvidenceLog] = {}
        self._told: set[Path] = set()

    def on_mission(self, mission: str) -> None:
        """Take events for this mission from now on.

        Its log is read meanwhile: after a restart of the console in a long mission, the first
        order does not wait for it.
        """
        self._mission = mission
        Thread(target=self._open, args=(self._path(mission),), daemon=True).start()

    def _open(self, path: Path) -> None:
        # Whoever writes is told why not.
        with self._writing, suppress(OSError):
            self._log(path)

    def write(self, event: Event, run: str = '') -> str:
        """Write an event: it is safely on disk on return.

        Parameters
        ----------
        run
            That it is about; empty: the running mission.

        Returns
        -------
        str
            Why the log has gone on in a new segment, once; empty: it has not.

        Raises
        ------
        OSError
            If its log cannot be written.
        """
        path = self._path(run or self._mission)
        with self._writing:
            log = self._log(path)
            log.add([event])
            if not log.damage or path in self._told:
                return ''
            self._told.add(path)
            return log.damage

    def close(self) -> None:
        """Close the logs."""
        with self._writing:
            for log in self._logs.values():
                log.close()
            self._logs.clear()

    def _log(self, path: Path) -> EvidenceLog:
        if path not in self._logs:
            self._logs[path] = EvidenceLog(path)
        return self._logs[path]

    def _path(self, mission: str) -> Path:
        folder = self._runs / mission
        is_there = mission and '/' not in mission and folder.is_dir()
        return folder / LOG_NAME if is_there else self._runs / CONSOLE_LOG
