# SPDX-License-Identifier: Apache-2.0
"""New missions: a scenario that is drawn, checked, planned, approved and launched.

Each step is the command of the same name, so that the page can do what the command line can, and
nothing else. What is launched is exactly what was approved: its digest is compared.
"""

import hashlib
import json
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import yaml

from rocsafe_console.errors import ConsoleError, RefusedError
from rocsafe_console.runs.faults import Fault, faults_of
from rocsafe_console.people.missions import Access, Missions
from rocsafe_console.runs.launches import Launch, Launches, plain
from rocsafe_console.runs.outline import CAMERA, outline_of, with_whole_paths
from rocsafe_geo.storage.durable import replace_whole
from rocsafe_geo.storage.yaml_source import YamlError, parse_yaml

MOST_CORNERS = 1000
# Checks and plans end in seconds; a search that was given more time is for the command line.
STEP_S = 120.0
EARLY_END_S = 4.0
# Tells `rocsafe run` who commands the mission; else it is the user of the machine.
COMMANDER_VARIABLE = 'ROCSAFE_COMMANDER'
DRAFTS = 'drafts'
LAUNCHED = 'launched'
NOT_APPROVED = 'this is not the plan that was approved: plan and approve it again'
# A mission that is launched here belongs to nobody else's.
MISSION_VARIABLE = 'ROCSAFE_MISSION_TOKEN'
NOT_PASSED_ON = ('ROCSAFE_SUPERVISOR_PID', MISSION_VARIABLE)
_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9_-]{0,60}')
_HASH = re.compile(r'[0-9a-f]{4,64}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Step:
    """What a command has answered."""

    is_done: bool
    text: str
    faults: tuple[Fault, ...] = ()


class Drafts:
    """The drafts in the folder of the runs.

    Parameters
    ----------
    runs
        Folder of the runs.
    scenarios
        Folder of scenarios to begin with.
    environment
        Of the commands.
    """

    def __init__(self, runs: Path, scenarios: Path, environment: Mapping[str, str]) -> None:
        self._runs = runs
        self._scenarios = scenarios
        self._environment = {
            name: value for name, value in environment.items() if name not in NOT_PASSED_ON
        }
        self._launches = Launches()

    def names(self) -> dict[str, list[str]]:
        """Return the names of the scenarios to begin with, and of the drafts."""
        return {
            'scenarios': sorted(path.stem for path in self._scenarios.glob('*.yaml')),
            'drafts': sorted(path.stem for path in (self._runs / DRAFTS).glob('*.yaml')),
        }

    def text_of(self, kind: str, name: str) -> str:
        """Return the text of a scenario (`kind` ``'scenarios'``) or draft; `ConsoleError`: none."""
        if not _NAME.fullmatch(name) or name not in self.names().get(kind, ()):
            raise ConsoleError(f'{name!r}: there is none')
        folder = self._scenarios if kind == 'scenarios' else self._runs / DRAFTS
        text = (folder / f'{name}.yaml').read_text(encoding='utf-8')
        return with_whole_paths(text, folder) if kind == 'scenarios' else text

    def outline(self, text: str) -> dict[str, Any]:
        """Return what the page shows of a scenario before it is planned."""
        return outline_of(text, self._runs / DRAFTS)

    def save(self, name: str, text: str, drawn: Mapping[str, Any]) -> str:
        """Write a draft, with what was drawn in it, and return its text.

        Raises
        ------
        ValueError
            If the name or what was drawn is wrong, or the text is no YAML mapping.
        """
        path = self._path(name)
        merged = with_drawn(text, name, drawn)
        path.parent.mkdir(exist_ok=True)
        replace_whole(path, merged.encode())
        return merged

    def check(self, name: str) -> Step:
        """Run `rocsafe check`; its answer names the mistakes of the scenario."""
        path = self._path(name)
        step = self._step('check', str(path))
        return replace(step, faults=faults_of(step.text, path.read_text(encoding='utf-8')))

    def plan(self, name: str) -> tuple[Step, Any, str]:
        """Run `rocsafe plan`; return its answer, the plan as GeoJSON, and what is approved."""
        out = self._plan_folder(name)
        shutil.rmtree(out, ignore_errors=True)
        text = self._path(name).read_text(encoding='utf-8')
        step = self._step('plan', str(self._path(name)), '--out', str(out))
        if not step.is_done:
            return step, None, ''
        plan = next(iter(sorted(out.rglob('plan.geojson'))), None)
        return step, plan and json.loads(plan.read_text()), self.digest(name, text)

    def preflight(self, name: str) -> Step:
        """Run `rocsafe preflight`."""
        return self._step('preflight', str(self._path(name)), '--wait', '10')

    def digest(self, name: str, text: str) -> str:
        """Return the hash of the text of a draft and of its plan; empty: it is not planned."""
        plan = next(iter(sorted(self._plan_folder(name).rglob('plan.json'))), None)
        if plan is None:
            return ''
        return hashlib.sha256(text.encode() + plan.read_bytes()).hexdigest()

    def launch(
        self, name: str, approved: str, user: str, confirmed: Sequence[str] = ()
    ) -> Launch:
        """Run `rocsafe run`, which goes on by itself; an early end is told with its reason.

        Parameters
        ----------
        approved
            Hash that the plan was approved by.
        user
            Who launches it: the commander of the mission.
        confirmed
            Hashes by which real vehicles may take off.

        Raises
        ------
        RefusedError
            If the draft or its plan is not the one that was approved, or it is flying.
        """
        if not all(_HASH.fullmatch(one) for one in confirmed):
            raise ValueError('confirm: must be hashes as the log of the mission tells them')
        words = [part for one in confirmed for part in ('--confirm', one)]
        scenario = self._frozen(name, approved)
        command = [self._command(), 'run', str(scenario), '--out', str(self._runs), *words]
        log = self._path(name).with_suffix('.log')
        environment = {**self._environment, COMMANDER_VARIABLE: user}
        return self._launches.begin(name, command, log, environment, EARLY_END_S, user)

    def _frozen(self, name: str, approved: str) -> Path:
        """Return a copy of a draft that was approved: nobody changes what is launched."""
        path = self._path(name)
        text = path.read_text(encoding='utf-8')
        if not approved or approved != self.digest(name, text):
            raise RefusedError(NOT_APPROVED)
        copy = path.parent / LAUNCHED / path.name
        copy.parent.mkdir(exist_ok=True)
        replace_whole(copy, with_whole_paths(text, path.parent).encode())
        return copy

    def mission(self, name: str) -> Launch:
        """Tell how the mission of a draft stands."""
        return self._launches.look(name, self._path(name).with_suffix('.log'))

    def rights_on(self, name: str, missions: Missions) -> Access:
        """Return the rights on the mission of a draft, also before its run has a folder."""
        run = self._launches.run_of(name, self._path(name).with_suffix('.log'))
        access = missions.of(run) if run else Access()
        return access if access != Access() else Access(commander=self._launches.user_of(name))

    def end(self, name: str) -> None:
        """End the mission of a draft, as Ctrl-C does; raises `RefusedError`."""
        self._launches.end(name)

    def _step(self, *words: str) -> Step:
        try:
            done = subprocess.run(
                [self._command(), *words],
                stdin=subprocess.DEVNULL,
                stdout=subprocess.PIPE,
                stderr=subprocess.STDOUT,
                env={**self._environment, 'COLUMNS': '78', 'NO_COLOR': '1'},
                timeout=STEP_S,
                check=False,
            )
        except subprocess.TimeoutExpired:
            return Step(is_done=False, text=f'{words[0]}: not done within {STEP_S:g} s')
        return Step(is_done=done.returncode == 0, text=plain(done.stdout))

    def _command(self) -> str:
        found = shutil.which('rocsafe', path=self._environment.get('PATH'))
        if found is None:
            raise ConsoleError('the command rocsafe is not on the PATH: source the workspace')
        return found

    def _path(self, name: str) -> Path:
        if not _NAME.fullmatch(name):
            raise ValueError(f'name {name!r}: must be up to 61 letters, digits, "_" and "-"')
        return self._runs / DRAFTS / f'{name}.yaml'

    def _plan_folder(self, name: str) -> Path:
        return self._path(name).with_suffix('.plan')


def with_drawn(text: str, name: str, drawn: Mapping[str, Any]) -> str:
    """Return a scenario with region, exclusions and homes as drawn; what was not drawn stays.

    Parameters
    ----------
    drawn
        ``region``, a ring of latitude and longitude; ``exclusions``, a list of rings; ``homes``,
        places by vehicle; ``vehicles``, the names of those that fly, new ones like the last one
        before; ``camera``, numbers by their keys.

    Raises
    ------
    ValueError
        If the text is no YAML mapping, or something drawn is no ring or place.
    """
    try:
        scenario = parse_yaml(text, name)
    except YamlError as error:
        raise ValueError(str(error)) from error
    if not isinstance(scenario, dict):
        raise ValueError(f'{name}: must be a mapping')  # noqa: TRY004 - one kind for the page
    scenario['name'] = name
    if drawn.get('region'):
        scenario['region'] = {'polygon': ring_of(drawn['region'])}
        # It was the place of the old region.
        for key in ('latitude_deg', 'longitude_deg'):
            (scenario.get('origin') or {}).pop(key, None)
    if drawn.get('exclusions'):
        scenario['exclusions'] = [{'polygon': ring_of(ring)} for ring in drawn['exclusions']]
    if 'vehicles' in drawn:
        scenario['vehicles'] = fleet_of(scenario.get('vehicles') or [], drawn['vehicles'])
    if camera := {key: drawn['camera'][key] for key in CAMERA if drawn.get('camera', {}).get(key)}:
        scenario['camera'] = {**(scenario.get('camera') or {}), **camera}
    homes = drawn.get('homes') or {}
    for vehicle in scenario.get('vehicles') or []:
        if vehicle.get('name') in homes:
            vehicle['home'] = _place_of(homes[vehicle['name']])
    return yaml.safe_dump(scenario, sort_keys=False, allow_unicode=True)


def fleet_of(vehicles: list[Any], names: Any) -> list[Any]:
    """Return the vehicles of these names; one that is new is like the last one before it.

    Raises
    ------
    ValueError
        If there is none, or a new one has nothing to be like.
    """
    known = {one.get('name'): one for one in vehicles if isinstance(one, dict)}
    if not isinstance(names, list) or not names:
        raise ValueError('vehicles: must be one or more')
    found: list[Any] = []
    for name in dict.fromkeys(map(str, names)):
        like = next(iter(found[::-1] or vehicles), None)
        if name not in known and not isinstance(like, dict):
            raise ValueError(f'vehicle {name[:40]!r}: there is none that it could be like')
        # A link is that of one real vehicle.
        found.append(known.get(name) or {**_simulated(like), 'name': name})
    return found


def _simulated(vehicle: Any) -> dict[str, Any]:
    return {key: value for key, value in vehicle.items() if key not in ('link', 'drone')}


def ring_of(ring: Any) -> list[list[float]]:
    """Return a ring of at least three places; raises `ValueError`."""
    if not isinstance(ring, list) or not 3 <= len(ring) <= MOST_CORNERS:
        raise ValueError(f'a ring must have 3 to {MOST_CORNERS} corners')
    return [_place_of(place) for place in ring]


def _place_of(place: Any) -> list[float]:
    latitude, longitude = (float(part) for part in place)
    if not (-90.0 <= latitude <= 90.0 and -180.0 <= longitude <= 180.0):
        raise ValueError(f'place {latitude}, {longitude}: must be on the earth')
    return [round(latitude, 8), round(longitude, 8)]
