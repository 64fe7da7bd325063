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
        self._lock = Lock()

    def begin(
        self,
        name: str,
        command: Sequence[str],
        log: Path,
        environment: Mapping[str, str],
        early_end_s: float,
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
