# SPDX-License-Identifier: Apache-2.0
"""What a run writes down so that `rocsafe run --resume` finds its processes again."""

import json
import os
import select
import signal
from collections.abc import Mapping
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path

from rocsafe_geo.storage.durable import finish_part, part_of
from rocsafe_orchestrator.errors import SetupError
from rocsafe_ros.domain.mission_identity import MissionIdentity

# Field of /proc/PID/stat behind the name of the process: when it was started, in clock ticks.
_START_FIELD = 19


@dataclass(frozen=True, slots=True, kw_only=True)
class Session:
    """Identity and processes of a run that is not over.

    Attributes
    ----------
    mission, token
        Identity of the mission, by which its processes know each other.
    config
        Parameter file for all nodes; empty: none.
    processes
        Process id and time of the start of each process, as `start_ticks` returns it.
    """

    mission: str
    token: str
    config: str = ''
    processes: Mapping[str, tuple[int, int]] = field(default_factory=dict)

    @property
    def identity(self) -> MissionIdentity:
        """The mission."""
        return MissionIdentity(mission=self.mission, token=self.token)

    def with_process(self, name: str, pid: int) -> 'Session':
        """Return the session with a process that was started now."""
        return replace(self, processes={**self.processes, name: (pid, start_ticks(pid))})

    def living(self) -> dict[str, 'Adopted']:
        """Return the processes that still run, by name."""
        found = {name: adopted(pid, ticks) for name, (pid, ticks) in self.processes.items()}
        return {name: process for name, process in found.items() if process is not None}


def write_session(path: Path, session: Session) -> None:
    """Write a session as a whole, for its owner only: the token lets others into the mission."""
    part = part_of(path)
    part.touch(mode=0o600)
    part.write_text(json.dumps(asdict(session)), encoding='utf-8')
    finish_part(path)


def read_session(path: Path) -> Session:
    """Return the session of a run.

    Raises
    ------
    SetupError
        If it cannot be read.
    """
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
        processes = {name: (int(p), int(t)) for name, (p, t) in content['processes'].items()}
        return Session(
            mission=str(content['mission']),
            token=str(content['token']),
            config=str(content['config']),
            processes=processes,
        )
    except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
        raise SetupError(f'{path}: cannot be read: {type(error).__name__}: {error}') from error


def start_ticks(pid: int) -> int:
    """Return when a process was started, clock ticks since the boot; 0: it is not there."""
    try:
        text = Path(f'/proc/{pid}/stat').read_text(encoding='utf-8', errors='replace')
    except OSError:
        return 0
    return int(text.rpartition(')')[2].split()[_START_FIELD])


class Adopted:
    """A process that another supervisor has started, and that is no child of this one.

    Parameters
    ----------
    descriptor
        Of the process (`os.pidfd_open`): it names this process also when its id is given away.
    """

    def __init__(self, pid: int, descriptor: int) -> None:
        self._pid, self._descriptor = pid, descriptor

    @property
    def pid(self) -> int:
        """Id of the process and of its session."""
        return self._pid

    @property
    def has_ended(self) -> bool:
        """Whether it has ended."""
        return bool(select.select([self._descriptor], [], [], 0.0)[0])

    def wait(self) -> None:
        """Wait for its end; how it ended is not known."""
        select.select([self._descriptor], [], [])

    def signal(self, number: signal.Signals) -> None:
        """Send a signal to it and to all that it has started."""
        if not self.has_ended:
            os.killpg(self._pid, number)


def adopted(pid: int, ticks: int) -> Adopted | None:
    """Return the process `pid` that was started at `ticks`; None: it is not there any more."""
    try:
        process = Adopted(pid, os.pidfd_open(pid))
    except OSError:
        return None
    # Looked at after the descriptor is open: from now on the id is of this process.
    return process if start_ticks(pid) == ticks and not process.has_ended else None
