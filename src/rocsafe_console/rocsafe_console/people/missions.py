# SPDX-License-Identifier: Apache-2.0
"""Who commands a mission, who may see it, and who may give its vehicles orders.

It is kept for each run beside the runs, not in its folder, which is sealed; every change is in the
evidence log of the run. A mission without an entry is commanded by whoever started it.
"""

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any

from rocsafe_console.errors import ConsoleError, RefusedError
from rocsafe_console.people.roles import VERBS, Action, Role
from rocsafe_geo.storage.durable import part_of, replace_whole

NAME = 'console-missions.json'
EVERYBODY, NAMED = 'everybody', 'named'
MOST_MEMBERS = 100
# They make nothing more dangerous: whoever may see a mission and is an operator may give them.
SAFE = frozenset({Action.HOLD, Action.RETURN, Action.LAND})
# Decisions about a mission as a whole.
OF_COMMANDER = frozenset({Action.REPLAN, Action.END, Action.SEAL, Action.RESUME_RUN})


@dataclass(frozen=True, slots=True, kw_only=True)
class Access:
    """Rights on one mission, besides those of the roles.

    Attributes
    ----------
    commander
        User; empty: every user of this role commands it.
    visibility
        ``everybody``: whoever is logged in sees it; ``named``: its commander, its members, and
        users of the role commander.
    members
        Who gives orders besides the commander; none: every operator.
    """

    commander: str = ''
    visibility: str = EVERYBODY
    members: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        if self.visibility not in (EVERYBODY, NAMED):
            raise ValueError(
                f'visibility = {self.visibility!r}: must be {EVERYBODY!r} or {NAMED!r}'
            )
        if len(self.members) > MOST_MEMBERS:
            raise ValueError(f'members: {len(self.members)}, must be {MOST_MEMBERS} at most')

    def is_seen_by(self, user: str, role: Role) -> bool:
        """Return whether a user may see the mission."""
        is_known = user == self.commander or user in self.members
        return self.visibility == EVERYBODY or role is Role.COMMANDER or is_known

    def require(self, user: str, role: Role, action: Action) -> None:
        """Refuse an action on the mission that its role alone would allow.

        Raises
        ------
        RefusedError
            Naming who commands the mission.
        """
        if not self.is_seen_by(user, role):
            raise RefusedError('you are not on the list of this mission')
        if action in OF_COMMANDER and self.commander not in ('', user):
            raise RefusedError(
                f'this mission is commanded by {self.commander}: take its command first'
            )
        is_listed = not self.members or user in self.members or user == self.commander
        if action in VERBS - SAFE and not is_listed:
            raise RefusedError(f'{user} is not on the list of those who command this mission')


class Missions:
    """The rights on the missions of a folder of runs.

    Raises
    ------
    ConsoleError
        If their file cannot be read: nobody may see by mistake what was restricted.
    """

    def __init__(self, runs: Path) -> None:
        self._runs = runs
        self._path = runs / NAME
        self._started_by: dict[str, str] = {}
        try:
            plain = json.loads(self._path.read_text(encoding='utf-8'))
            self._set = {name: access_of(one) for name, one in plain.items()}
        except FileNotFoundError:
            self._set = {}
        except (OSError, ValueError, KeyError, TypeError, AttributeError) as error:
            raise ConsoleError(f'{self._path}: cannot be read: {error}') from error

    def of(self, run: str) -> Access:
        """Return the rights on a mission by the name of its run."""
        return self._set.get(run) or Access(commander=self._starter(run))

    def put(self, run: str, access: Access) -> None:
        """Set the rights on a mission; raises `OSError` if they cannot be kept."""
        changed = {**self._set, run: access}
        part_of(self._path).touch(mode=0o600)
        content = {name: asdict(one) for name, one in changed.items()}
        replace_whole(self._path, json.dumps(content).encode())
        self._set = changed

    def _starter(self, run: str) -> str:
        """Return who started a run; it does not change."""
        if run not in self._started_by:
            try:
                info = json.loads((self._runs / run / 'run.json').read_text(encoding='utf-8'))
                name = str(info.get('commander') or '')
            except (OSError, ValueError, AttributeError):
                return ''
            self._started_by[run] = name
        return self._started_by[run]


def access_of(plain: Mapping[str, Any]) -> Access:
    """Return the rights in a JSON object; raises `ValueError`, `KeyError` or `TypeError`."""
    members = plain['members']
    if isinstance(members, str):
        raise TypeError('members: must be a list of names')
    return Access(
        commander=str(plain['commander']),
        visibility=str(plain['visibility']),
        members=tuple(dict.fromkeys(str(name) for name in members)),
    )
