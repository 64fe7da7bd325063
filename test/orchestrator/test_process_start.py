# SPDX-License-Identifier: Apache-2.0
"""A script that begins as a copy of its supervisor cannot tell it from a start of its own."""

import json
import os
import signal
import subprocess
import sys
from pathlib import Path

import pytest

from rocsafe_orchestrator.processes import process_start

DEADLINE_S = 60.0
# The supervisor is a process of its own: one that runs tests has threads, and is not copied.
SUPERVISOR = """
import json, logging, os, sys, threading, time
from pathlib import Path
from rocsafe_orchestrator.processes.process_start import begin_as_fork
from rocsafe_orchestrator.process_table.values import NEVER, Launch
from rocsafe_orchestrator.processes.supervisor import Supervisor

package = logging.getLogger('rocsafe_orchestrator')
package.propagate = False
package.setLevel(logging.INFO)
package.addHandler(logging.NullHandler())
script, log, before, signal = sys.argv[1:]
launch = Launch(name='node', command=(script, 'a', 'b c'), log=Path(log), restart=NEVER)
environment = {'PATH': os.environ['PATH'], 'WORD': 'green'}
supervisor = Supervisor([launch], environment)
exec(before)
supervisor.start('node', begin_as_fork)
if int(signal):
    os.kill(supervisor.pid_of('node'), int(signal))
while not (events := supervisor.poll()):
    time.sleep(0.01)
print(json.dumps([os.getpid(), events[0].text]))
"""
TELL = """
import json, logging, os, sys
logging.getLogger('rocsafe_orchestrator').warning('noted')
print(json.dumps({
    'arguments': sys.argv[1:], 'environment': dict(os.environ), 'pid': os.getpid(),
    'session': os.getsid(0), 'parent': os.getppid(), 'input': sys.stdin.read(),
    'name': open('/proc/self/comm').read().strip(), 'file': __file__,
    'is_copy': 'rocsafe_orchestrator.processes.supervisor' in sys.modules,
}))
"""


def started(
    folder: Path, program: str, *, before: str = '', number: int = 0, shebang: str = sys.executable
) -> tuple[list[str], int, str]:
    """Run `program` under a supervisor; return the lines of its log, the supervisor and its end.

    Parameters
    ----------
    before: what the supervisor does before.
    number: of the signal that it sends at once.
    """
    script = folder / 'teller'
    script.write_text(f'#!{shebang}\n{program}')
    script.chmod(0o755)
    log = folder / 'log'
    command = [sys.executable, '-c', SUPERVISOR, str(script), str(log), before, str(number)]
    done = subprocess.run(command, capture_output=True, timeout=DEADLINE_S, check=True, text=True)
    supervisor, end = json.loads(done.stdout)
    return log.read_text().splitlines(), supervisor, end


def told(lines: list[str]) -> dict[str, object]:
    """Return what the program told of itself."""
    value: dict[str, object] = json.loads(lines[-1])
    return value


def test_copy_is_what_a_new_process_would_be(tmp_path: Path) -> None:
    """Arguments, variables, session, parent, input, output and name are those of the script."""
    lines, supervisor, end = started(tmp_path, TELL)
    tale = told(lines)
    assert tale['is_copy']
    assert tale['arguments'] == ['a', 'b c']
    assert tale['environment'] == {'PATH': os.environ['PATH'], 'WORD': 'green'}
    assert tale['session'] == tale['pid'] != supervisor
    assert tale['parent'] == supervisor
    assert tale['input'] == ''
    assert (tale['name'], tale['file']) == ('teller', str(tmp_path / 'teller'))
    assert lines[0] == 'noted'
    assert end == 'ended with exit code 0: ' + lines[-1][:300]


@pytest.mark.parametrize(
    ('before', 'shebang'),
    [
        ('threading.Thread(target=time.sleep, args=(60,), daemon=True).start()', sys.executable),
        ('', '/usr/bin/env python3'),
    ],
)
def test_what_cannot_be_copied_begins_anew(tmp_path: Path, before: str, shebang: str) -> None:
    """A process with threads is not copied, nor made into another interpreter."""
    lines, supervisor, _ = started(tmp_path, TELL, before=before, shebang=shebang)
    tale = told(lines)
    assert not tale['is_copy']
    assert tale['session'] == tale['pid']
    assert tale['parent'] == supervisor


@pytest.mark.parametrize(
    ('program', 'end'),
    [
        ('raise SystemExit(2)', 'ended with exit code 2'),
        ('raise RuntimeError("no luck")', 'ended with exit code 1: RuntimeError: no luck'),
        ('import os, signal; os.kill(os.getpid(), signal.SIGKILL)', 'was ended by SIGKILL'),
    ],
)
def test_end_of_a_copy_is_told(tmp_path: Path, program: str, end: str) -> None:
    """Exit code, last words and signals are those of the script."""
    assert started(tmp_path, program)[2] == end


def test_signal_right_after_the_start_is_heard(tmp_path: Path) -> None:
    """The handlers of the original do not swallow what the copy is asked at once."""
    before = 'import signal as s; [s.signal(n, lambda *_: None) for n in (s.SIGINT, s.SIGTERM)]'
    sleep = 'import time; time.sleep(60)'
    end = started(tmp_path, sleep, before=before, number=signal.SIGTERM)[2]
    assert end == 'was ended by SIGTERM'
    end = started(tmp_path, sleep, before=before, number=signal.SIGINT)[2]
    assert end == 'ended with exit code 1: KeyboardInterrupt'


TWO = """
import os, sys, time
from pathlib import Path
from rocsafe_orchestrator.processes.process_start import begin_as_fork
from rocsafe_orchestrator.process_table.values import NEVER, Launch
from rocsafe_orchestrator.processes.supervisor import Supervisor

script, folder = sys.argv[1], Path(sys.argv[2])
names = ('first', 'second')
supervisor = Supervisor(
    Launch(name=name, command=(script,), log=folder / name, restart=NEVER) for name in names
)
supervisor.start('first', begin_as_fork)
os.waitid(os.P_PID, supervisor.pid_of('first'), os.WEXITED | os.WNOWAIT)
supervisor.start('second', begin_as_fork)
told = []
while len(told) < 2:
    told += supervisor.poll()
print(*sorted(f'{event.name} {event.text}' for event in told), sep='|')
"""


def test_fork_that_ended_before_the_next_one_began_is_told(tmp_path: Path) -> None:
    """`multiprocessing` reaps it then, and its exit code is still known."""
    script = tmp_path / 'ender'
    script.write_text(f'#!{sys.executable}\nraise SystemExit(3)')
    script.chmod(0o755)
    command = [sys.executable, '-c', TWO, str(script), str(tmp_path)]
    done = subprocess.run(command, capture_output=True, timeout=DEADLINE_S, check=True, text=True)
    assert done.stdout == 'first ended with exit code 3|second ended with exit code 3\n'


def test_launchers_of_wheels_are_forked(tmp_path, monkeypatch):
    """They start the Python beside them; elsewhere that is another one than this."""
    script = tmp_path / 'lib/rocsafe_sim/rav'
    script.parent.mkdir(parents=True)
    script.write_text('#!/bin/sh\n\'\'\'exec\' "$(dirname -- "$0")/../../bin/python" "$0" "$@"\n')
    assert not process_start._is_of_this_interpreter(script)
    monkeypatch.setattr(process_start.sys, 'prefix', str(tmp_path))
    assert process_start._is_of_this_interpreter(script)
