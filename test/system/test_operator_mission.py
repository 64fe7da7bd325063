# SPDX-License-Identifier: Apache-2.0
"""Ctrl-C and a closed terminal during a flight with a real vehicle, in a terminal of its own."""

import json
import os
import pty
import re
import subprocess
import time
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import Any

import pytest
from test.system.test_mixed_mission import Field

pytestmark = pytest.mark.system

DEADLINE_S = 150.0


class Terminal:
    """A person's terminal, in which a mission is flown."""

    def __init__(self, field: Any, rocsafe: Path) -> None:
        self._far, near = pty.openpty()
        self.text = ''
        self.runs = field.folder / 'runs'
        self.process = subprocess.Popen(
            [str(rocsafe), 'run', str(field.scenario), '--out', str(self.runs)],
            stdin=near, stdout=near, stderr=near, env={**field._environment, 'TERM': 'xterm'},
            start_new_session=True, preexec_fn=_take_terminal,
        )  # fmt: skip
        os.close(near)
        os.set_blocking(self._far, False)

    def wait_for(self, pattern: str) -> None:
        """Wait until it shows a text."""
        end_s = time.monotonic() + DEADLINE_S
        while not re.search(pattern, ' '.join(self.text.split())):
            assert time.monotonic() < end_s, self.text[-3000:]
            assert self.process.poll() is None, self.text[-3000:]
            self._read()

    def type(self, text: str) -> None:
        """Type."""
        os.write(self._far, text.encode())

    def close(self) -> None:
        """Close the window."""
        os.close(self._far)

    def end(self) -> int:
        """Wait for the end of the command and return its exit code."""
        end_s = time.monotonic() + DEADLINE_S
        while self.process.poll() is None:
            assert time.monotonic() < end_s, self.text[-3000:]
            with suppress(OSError):
                self._read()
            time.sleep(0.02)
        return self.process.returncode

    def outcome(self) -> dict[str, Any]:
        """Return what the run directory says of the run."""
        (run,) = self.runs.glob('mixed-*')
        return dict(json.loads((run / 'run.json').read_text(encoding='utf-8')))

    def _read(self) -> None:
        try:
            self.text += os.read(self._far, 65536).decode(errors='replace')
        except BlockingIOError:
            time.sleep(0.02)


def _take_terminal() -> None:
    """Make the terminal that of the new session: it gets its Ctrl-C, and its end."""
    import fcntl
    import termios

    fcntl.ioctl(0, termios.TIOCSCTTY, 0)


@pytest.fixture
def flying(rocsafe: Path, ros_domain_id: int, tmp_path: Path, request: Any) -> Iterator[Terminal]:
    """Give the terminal of a mission whose real vehicle is on its route."""
    field = Field(rocsafe, ros_domain_id, tmp_path)
    text = field.scenario.read_text(encoding='utf-8')
    field.scenario.write_text(f'{text}\non_operator_lost: {request.param}\n', encoding='utf-8')
    terminal = Terminal(field, rocsafe)
    try:
        terminal.wait_for('take off by plan [0-9a-f]{8}')
        terminal.type('y\n')
        # Colours of the table stand between the words.
        terminal.wait_for(r'rav1 (\x1b\[[0-9;]*m)*flying')
        yield terminal
    finally:
        terminal.process.kill()
        terminal.process.wait()
        field.close()


@pytest.mark.all
@pytest.mark.parametrize('flying', ['hold_then_return'], indirect=True)
def test_ctrl_c_asks_and_watches_until_the_landing(flying: Terminal) -> None:
    """Told to return, the run ends when all have landed; twice is not urgent."""
    flying.type('\x03')
    flying.wait_for('real vehicles are in the air')
    flying.type('\x03')
    flying.type('r\n')
    assert flying.end() == 130
    outcome = flying.outcome()
    assert outcome['outcome'] == 'cancelled'
    assert re.fullmatch('[0-9a-f]{8}', outcome['confirmed_plan'])
    assert 'return and land' in flying.text


@pytest.mark.all
@pytest.mark.parametrize('flying', ['return'], indirect=True)
def test_closed_terminal_leaves_nobody_alone(flying: Terminal) -> None:
    """The run goes on without its terminal, and calls the vehicles home."""
    flying.close()
    assert flying.end() == 129
    assert flying.outcome()['outcome'] == 'cancelled'
