# SPDX-License-Identifier: Apache-2.0
"""Commands that set-up runs: logged, ended with it, and ended later if it was killed."""

import contextlib
import os
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from types import FrameType

from workspace.errors import CommandError, Interrupted

# Every process below a set-up carries this, with the checkout as value, so that what a killed
# set-up left running can be told from everything else on the machine.
MARK = 'ROCSAFE_SETUP'
TAIL_LINES = 15
GRACE_S = 5.0
# An hour: a slow network may take minutes, nothing takes longer.
COMMAND_LIMIT_S = 3600.0


class _Gate:
    """Delays signals while a process is being started and cannot be ended yet."""

    def __init__(self) -> None:
        self.is_closed = False
        self.waiting: int | None = None

    def interrupt(self, number: int, _frame: FrameType | None) -> None:
        """Raise `Interrupted`, now or when the gate opens."""
        if not self.is_closed:
            raise Interrupted(number)
        self.waiting = number

    def __enter__(self) -> None:
        self.is_closed = True

    def __exit__(self, *_error: object) -> None:
        self.is_closed = False
        number, self.waiting = self.waiting, None
        if number is not None:
            raise Interrupted(number)


_gate = _Gate()


@contextlib.contextmanager
def signals_as_exceptions() -> Iterator[None]:
    """Turn SIGINT, SIGTERM and SIGHUP into `Interrupted` within the block."""
    # A signal that is ignored, as SIGHUP is under nohup, stays so.
    heeded = [
        number
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)
        if signal.getsignal(number) is not signal.SIG_IGN
    ]
    before = {number: signal.signal(number, _gate.interrupt) for number in heeded}
    try:
        yield
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)


def run_logged(
    command: Sequence[str],
    log: Path,
    environment: Mapping[str, str],
    folder: Path | None = None,
) -> None:
    """Run `command` in `folder` with its output in `log`; errors as those of `running`."""
    with running(command, log, environment, folder):
        pass


@contextlib.contextmanager
def running(
    command: Sequence[str],
    log: Path,
    environment: Mapping[str, str],
    folder: Path | None = None,
) -> Iterator[None]:
    """Run `command` in `folder` beside the block, and wait for it after the block.

    Parameters
    ----------
    log
        File that gets the output.

    Raises
    ------
    CommandError
        With the end of the log, if the command fails or cannot start.
    """
    log.parent.mkdir(parents=True, exist_ok=True)
    process = None
    try:
        with log.open('wb') as sink, _gate:
            process = subprocess.Popen(
                command,
                stdin=subprocess.DEVNULL,
                stdout=sink,
                stderr=subprocess.STDOUT,
                env=environment,
                cwd=folder,
                start_new_session=True,
            )
        yield
        code = process.wait(timeout=COMMAND_LIMIT_S)
    except BaseException:
        if process is not None:
            with _gate:
                _end_group(process)
        raise
    if code != 0:
        text = log.read_text(errors='replace')
        raise CommandError(f'{command[0]} failed with code {code}; all of it in {log}', text)


def in_idle_time(python: Path, work: str) -> list[str]:
    """Return a command that does `work`, Python code, with what time others leave."""
    return [str(python), '-c', f'import os; os.nice(19); {work}']


def tail(text: str) -> str:
    """Return the last lines of `text`, indented."""
    return '\n'.join(f'    {line}' for line in text.rstrip().splitlines()[-TAIL_LINES:])


def end_strays(root: Path) -> int:
    """Kill what a set-up of the checkout `root` left running when it was killed; count them."""
    wanted = f'{MARK}={root}'.encode()
    count = 0
    for folder in Path('/proc').glob('[0-9]*'):
        number = int(folder.name)
        if number == os.getpid():
            continue
        with contextlib.suppress(OSError):
            if wanted in (folder / 'environ').read_bytes().split(b'\0'):
                os.kill(number, signal.SIGKILL)
                count += 1
    return count


def _end_group(process: 'subprocess.Popen[bytes]') -> None:
    for number in (signal.SIGTERM, signal.SIGKILL):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(process.pid, number)
        end = time.monotonic() + GRACE_S
        while time.monotonic() < end and _group_lives(process):
            time.sleep(0.05)


def _group_lives(process: 'subprocess.Popen[bytes]') -> bool:
    process.poll()
    try:
        os.killpg(process.pid, 0)
    except ProcessLookupError:
        return False
    return True
