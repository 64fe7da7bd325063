# SPDX-License-Identifier: Apache-2.0
"""Commands of `rocsafe` that people give on the page for a run, a draft, a campaign or a vehicle.

Each is the command of the same name in a process of its own, which goes on when the console ends.
"""

import re
import shutil
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rocsafe_console.errors import ConsoleError
from rocsafe_console.people.roles import Action
from rocsafe_console.runs.drafts import COMMANDER_VARIABLE, DRAFTS, NOT_PASSED_ON
from rocsafe_console.runs.launches import Launch, Launches
from rocsafe_console.runs.run_folder import run_in

JOBS = 'jobs'
CAMPAIGNS = 'campaigns'
CAMPAIGN_PAGE = 'campaign.html'
EARLY_END_S = 1.0
_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_-]{0,60}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Folders:
    """Where the page finds what its commands work on."""

    runs: Path
    scenarios: Path

    @property
    def campaigns(self) -> Path:
        """Folder of the files of campaigns, beside the scenarios."""
        return self.scenarios.parent / CAMPAIGNS

    def file_in(self, folder: Path, name: str) -> Path:
        """Return the file of a draft or campaign; raises `ConsoleError`."""
        path = folder / f'{name}.yaml'
        if not _NAME.fullmatch(name) or not path.is_file():
            raise ConsoleError(f'{name!r}: there is none')
        return path


@dataclass(frozen=True, slots=True, kw_only=True)
class Job:
    """A command.

    Attributes
    ----------
    action
        That its user must be allowed.
    words
        Returns the words of the command for a name.
    is_of_run
        Whether the name is that of a run.
    """

    action: Action
    words: Callable[[Folders, str], Sequence[str]]
    is_of_run: bool = False


def _of_run(*words: str) -> Callable[[Folders, str], Sequence[str]]:
    return lambda folders, name: (*words, str(run_in(folders.runs, name)))


def _whatif(folders: Folders, name: str) -> Sequence[str]:
    return 'whatif', str(folders.file_in(folders.runs / DRAFTS, name))


def _campaign(folders: Folders, name: str) -> Sequence[str]:
    file = folders.file_in(folders.campaigns, name)
    return 'campaign', str(file), '--out', str(folders.runs / CAMPAIGNS / name)


def _clear(folders: Folders, name: str) -> Sequence[str]:
    if not _NAME.fullmatch(name):
        raise ConsoleError(f'vehicle {name!r}: there is none')
    return 'clear', name, '--out', str(folders.runs)


KINDS: Mapping[str, Job] = {
    'resume': Job(action=Action.RESUME_RUN, words=_of_run('run', '--resume'), is_of_run=True),
    'report': Job(action=Action.REMAKE, words=_of_run('report'), is_of_run=True),
    'replay': Job(action=Action.REMAKE, words=_of_run('replay'), is_of_run=True),
    'whatif': Job(action=Action.DRAFT, words=_whatif),
    'campaign': Job(action=Action.LAUNCH, words=_campaign),
    'clear': Job(action=Action.CLEAR, words=_clear),
}
"""The commands by their names on the page."""


class Jobs:
    """The commands that were given on the page of this console.

    Parameters
    ----------
    environment
        Of the commands.
    """

    def __init__(self, folders: Folders, environment: Mapping[str, str]) -> None:
        self.folders = folders
        self._environment = {
            name: value for name, value in environment.items() if name not in NOT_PASSED_ON
        }
        self._launches = Launches()

    def campaigns(self) -> list[str]:
        """Return the names of the campaigns that can be flown."""
        found = self.folders.campaigns.glob('*.yaml')
        return sorted(p.stem for p in found if b'\nscenario:' in b'\n' + p.read_bytes())

    def campaign_page(self, name: str) -> Path:
        """Return the page of a campaign; raises `ConsoleError`."""
        path = self.folders.runs / CAMPAIGNS / name / CAMPAIGN_PAGE
        if not _NAME.fullmatch(name) or not path.is_file():
            raise ConsoleError(f'campaign {name!r}: has no page yet')
        return path

    def begin(self, kind: str, name: str, user: str) -> Launch:
        """Start a command, and tell how it stands after a moment.

        Raises
        ------
        ConsoleError, RefusedError
            If there is nothing of this name, or it is at work already.
        """
        words = KINDS[kind].words(self.folders, name)
        program = shutil.which('rocsafe', path=self._environment.get('PATH'))
        if program is None:
            raise ConsoleError('the command rocsafe is not on the PATH: source the workspace')
        log = self._log(kind, name)
        log.parent.mkdir(exist_ok=True)
        environment = {**self._environment, COMMANDER_VARIABLE: user}
        key = f'{kind} {name}'
        return self._launches.begin(key, [program, *words], log, environment, EARLY_END_S, user)

    def look(self, kind: str, name: str) -> Launch:
        """Tell how a command stands."""
        return self._launches.look(f'{kind} {name}', self._log(kind, name))

    def end(self, kind: str, name: str) -> None:
        """End a command, as Ctrl-C does; raises `RefusedError`."""
        self._launches.end(f'{kind} {name}')

    def _log(self, kind: str, name: str) -> Path:
        return self.folders.runs / JOBS / f'{kind}-{name}.log'
