# SPDX-License-Identifier: Apache-2.0
"""Missions that were launched from the page: what they print, and their end."""

import re
import signal
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from threading import Lock

from rocsafe_console.errors import RefusedError

MOST_LOG_BYTES = 20_000
_ANSI = re.compile(r'\x1b\[[0-9;]*m')
# The first thing that `rocsafe run` prints.
_RUN = re.compile(r'^run directory: (.+)$', re.M)
_HEAD_BYTES = 2000
_WANTED = re.compile(r'run again with --confirm ([0-9a-f]{4,64})\b')


@dataclass(frozen=True, slots=True, kw_only=True)
class Launch:
    """A mission as the page shows it.

    Attributes
    ----------
    state
        ``'running'``, ``'done'``, ``'failed'`` or ``'unknown'``, if another console launched it.
    text
        The end of what it has printed.
    confirm
        Hash of the plan by which real vehicles would have taken off, if it was not confirmed.
    """

    state: str
    text: str
    confirm: str = ''


class Launches:
    """The missions of this console by the names of their drafts."""

    def __init__(self) -> None:
        self._processes: dict[str, subprocess.Popen[bytes]] = {}
        self._users: dict[str, str] = {}
        self._lock = Lock()

    def begin(
        self,
        name: str,
        command: Sequence[str],
        log: Path,
        environment: Mapping[str, str],
        early_end_s: float,
        user: str,
    ) -> Launch:
        """Start a mission, and tell how it stands after some seconds.

        Raises
        ------
        RefusedError
            If the one that was launched before is still running.
        """
        with self._lock:
            before = self._processes.get(name)
            if before is not None and before.poll() is None:
                raise RefusedError(f'{name} is flying: end it first')
            with log.open('wb') as output:
                process = subprocess.Popen(
                    command,
                    stdin=subprocess.DEVNULL,
                    stdout=output,
                    stderr=output,
                    env=environment,
                    start_new_session=True,
                )
            self._processes[name] = process
            self._users[name] = user
        try:
            process.wait(early_end_s)
        except subprocess.TimeoutExpired:
            pass
        return self.look(name, log)

    def look(self, name: str, log: Path) -> Launch:
        """Tell how a mission stands."""
        process = self._processes.get(name)
        code = process.poll() if process is not None else None
        state = 'unknown'
        if process is not None:
            state = {None: 'running', 0: 'done'}.get(code, 'failed')
        try:
            text = plain(log.read_bytes()[-MOST_LOG_BYTES:])
        except OSError:
            text = ''
        wanted = _WANTED.search(' '.join(text.split())) if state == 'failed' else None
        return Launch(state=state, text=text, confirm=wanted[1] if wanted else '')

    def run_of(self, name: str, log: Path) -> str:
        """Return the name of the run that a mission flies, empty if it is not known (yet)."""
        if name not in self._processes:
            return ''
        try:
            with log.open('rb') as file:
                head = file.read(_HEAD_BYTES)
        except OSError:
            return ''
        found = _RUN.search(plain(head))
        return Path(found[1].strip()).name if found else ''

    def user_of(self, name: str) -> str:
        """Return who has launched a mission, empty if this console has not."""
        return self._users.get(name, '')

    def end(self, name: str) -> None:
        """Ask a mission to end, as Ctrl-C does: it lands nobody that it may not.

        Raises
        ------
        RefusedError
            If it was not launched by this console, or has ended.
        """
        process = self._processes.get(name)
        if process is None or process.poll() is not None:
            raise RefusedError(f'{name}: this console has no such mission running')
        process.send_signal(signal.SIGINT)


def plain(output: bytes) -> str:
    """Return the end of an output without its colours."""
    return _ANSI.sub('', output.decode(errors='replace')).strip()[-MOST_LOG_BYTES:]
