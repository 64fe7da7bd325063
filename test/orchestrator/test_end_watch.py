# SPDX-License-Identifier: Apache-2.0
"""A run ends, with its own exit code, although a library waits for ever when it is closed."""

import subprocess
import sys
from pathlib import Path

SCRIPT = """
import ctypes, sys, threading
from pathlib import Path
from rocsafe_orchestrator.processes.end_watch import EndWatch

def finish():
    print('done', flush=True)
    return 7

watch = EndWatch(finish, Path(sys.argv[1]), closed_s=0.2, stuck_s=0.3)
WAIT
"""


def ended(folder: Path, wait: str) -> tuple[int, str, str | None]:
    """Return exit code, output, and the file of stacks if there is one, of a process."""
    stacks = folder / 'end.log'
    done = subprocess.run(
        [sys.executable, '-c', SCRIPT.replace('WAIT', wait), str(stacks)],
        capture_output=True, text=True, timeout=60.0, check=False,
    )  # fmt: skip
    return done.returncode, done.stdout, stacks.read_text() if stacks.exists() else None


def test_what_ends_in_time_is_left_alone(tmp_path: Path) -> None:
    """Nothing is called, and no file stays."""
    assert ended(tmp_path, 'watch.cancel(); sys.exit(3)') == (3, '', None)


def test_what_waits_for_ever_ends_with_its_own_code(tmp_path: Path) -> None:
    """After what was left to do; the file tells where it waits."""
    code, said, stacks = ended(tmp_path, 'threading.Event().wait()')
    assert (code, said) == (7, 'done\n')
    assert stacks is not None
    assert 'in wait' in stacks


def test_what_keeps_the_interpreter_ends_all_the_same(tmp_path: Path) -> None:
    """A library that waits while it holds the lock of Python."""
    code, said, stacks = ended(tmp_path, 'ctypes.PyDLL(None).sleep(50)')
    assert (code, said) == (1, '')
    assert stacks is not None
    assert '<module>' in stacks


def test_without_room_for_its_file_it_ends_as_well(tmp_path: Path) -> None:
    """The file is for people who look for the cause."""
    code, said, stacks = ended(tmp_path / 'missing', 'threading.Event().wait()')
    assert (code, said, stacks) == (7, 'done\n', None)
