# SPDX-License-Identifier: Apache-2.0
"""How the agents of a process begin: from the plan's file, and the count of their starts."""

import hashlib
import json
import secrets
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.batteries import Batteries
from rocsafe_fleet.agreement.fleet_plan import FleetPlan, SharedPlans, Wanted, first_plan
from rocsafe_fleet.agreement.local_agents import LocalAgents
from rocsafe_fleet.errors import PacketError
from rocsafe_fleet.ledger.ledger import Kind
from rocsafe_fleet.ledger.packet import Packet, decode, encode
from rocsafe_fleet.ledger.readings import DoseReading, ReadingSums, readings_of, table_of
from rocsafe_fleet.membership.identity import START_BITS
from rocsafe_fleet.options import AgentOptions
from rocsafe_fleet.search.round_chooser import RoundChooser, SearchOptions
from rocsafe_fleet.search.search_round import SearchRound
from rocsafe_fleet.trial.trial import planner_of
from rocsafe_geo.storage.durable import replace_whole, write_whole
from rocsafe_geo.storage.value_file import read_values
from rocsafe_geo.terrain.terrain_file import read_terrain
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.plan_json import further_folder
from rocsafe_planner.plan.plan_reading import read_plan

_STARTS, _LEDGER, _ROUTES = 'starts.txt', 'ledger.bin', 'routes.json'
_READINGS = 'readings.csv'
_ALL_BYTES = 2**31


class FleetStart:
    """The agents of a process, and what they plan with.

    Parameters
    ----------
    search
        How they search after the survey; None: they do not.

    Attributes
    ----------
    local
        The agents.
    names
        Of all vehicles of the survey, by number.
    """

    def __init__(
        self,
        survey: SurveyPlan,
        local: LocalAgents,
        key: bytes,
        folder: str,
        batteries: Batteries,
        search: SearchOptions | None = None,
    ) -> None:
        self.local = local
        self._key, self._folder = key, Path(folder) if folder else None
        self._saved = 0
        self.names = [route.vehicle.name for route in survey.routes]
        self._survey, self._batteries = survey, batteries
        area = survey.request.regions[0].area
        self._chooser = None if search is None else RoundChooser(search, area)
        self._sums = {name: ReadingSums(self.agent(name).ledger) for name in self.own_names}
        self._plans = SharedPlans(planner_of(batteries.freed(survey)))

    def agent(self, name: str) -> Agent:
        """Return the agent of a vehicle."""
        return self.local.agents[self.names.index(name)]

    @property
    def own_names(self) -> list[str]:
        """Vehicles whose agents run here."""
        return [self.names[number] for number in self.local.agents]

    def add_reading(self, name: str, reading: DoseReading | None) -> None:
        """Take a reading of a vehicle's detector; None: no more will come from where it is."""
        if reading is None:
            self._sums[name].close()
        else:
            self._sums[name].add(reading)

    def endurance_s(self, name: str) -> float:
        """Return the flight time of a vehicle's full battery."""
        return self._batteries.endurance_s(self._survey.routes[self.names.index(name)].vehicle)

    def first_route(self, name: str) -> tuple[int, ...]:
        """Return the viewpoints of a vehicle by the survey's plan."""
        views = self._survey.routes[self.names.index(name)].viewpoints
        return tuple(view.id for view in views)

    def load(self) -> dict[str, dict[str, list[int]]]:
        """Take back what earlier agents knew; return their routes by vehicle and plan id.

        Entries that cannot be read are left out: the other agents know them, or the viewpoints are
        photographed again.
        """
        if self._folder is None:
            return {}
        ledger, routes = self._folder / _LEDGER, self._folder / _ROUTES
        with suppress(OSError, PacketError):
            for delta in decode(ledger.read_bytes(), self._key).deltas:
                for agent in self.local.agents.values():
                    agent.ledger.merge(delta)
        with suppress(OSError, ValueError):
            return dict(json.loads(routes.read_text()))
        return {}

    def save(self, routes: Mapping[str, Mapping[str, Sequence[int]]]) -> None:
        """Keep what the agents know, for those that are started after a failure."""
        # Those of one process mostly know the same.
        known = {agent.ledger.digest: agent.ledger for agent in self.local.agents.values()}
        ledgers = list(known.values())
        digest = hash(tuple(ledger.digest for ledger in ledgers))
        if self._folder is None or digest == self._saved:
            return
        deltas = tuple(delta for ledger in ledgers for delta in ledger.deltas({}, _ALL_BYTES))
        packet = Packet(sender=0, beats={}, digest=0, deltas=deltas)
        for name, data in (
            (_LEDGER, encode(packet, self._key)),
            (_ROUTES, json.dumps(routes).encode()),
        ):
            write_whole(self._folder / name, data)
        if any(True for _ in ledgers[0].values(Kind.READING)):
            table = table_of(readings_of(ledgers, self.names))
            replace_whole(self._folder / _READINGS, table.encode())
        self._saved = digest

    def plan(self, wanted: Wanted, _report: Callable[[None], bool]) -> FleetPlan:
        """Return the plan of a proposal; runs in a thread."""
        return self._plans.get(wanted)

    def choosing(self, seeker: Agent) -> Callable[[Callable[[None], bool]], SearchRound]:
        """Return what chooses the places of the round that an agent seeks; runs in a thread."""
        if self._chooser is None:
            raise ValueError('the agents have no search')
        number, readings = seeker.seeks, readings_of([seeker.ledger], self.names)
        choose = self._chooser.choose
        return lambda _report: choose(number, readings)

    @property
    def others_aloft(self) -> bool:
        """Whether a vehicle whose agent is heard, and runs elsewhere, is in the air."""
        own = self.local.agents
        return any(not agent.aloft.issubset(own) for agent in own.values())

    @property
    def plan_id(self) -> str:
        """Id of the plan with which the survey begins."""
        return self._survey.plan_id

    @property
    def is_done(self) -> bool:
        """Whether no agent here has anything left that somebody could fly."""
        return all(agent.is_done for agent in self.local.agents.values())


def fleet_start(options: AgentOptions, plan_id: str, token: str, now_s: float) -> FleetStart:
    """Return the agents of a process that fly a plan; no id: whichever is in the file.

    Raises
    ------
    ValueError
        If the file holds another plan, or a vehicle is not of it.
    """
    terrain = read_terrain(options.terrain_file) if options.terrain_file else None
    survey = read_plan(options.plan_file, terrain)
    if plan_id and survey.plan_id != plan_id:
        raise ValueError(f'{options.plan_file}: has plan {survey.plan_id}, not {plan_id}')
    names = [route.vehicle.name for route in survey.routes]
    strangers = sorted(set(options.vehicles) - set(names))
    if strangers:
        raise ValueError(f'vehicles has {strangers[0]!r}: must be of {", ".join(names)}')
    batteries, search = _batteries(options), _search(options)
    first, rounds = first_plan(survey), search.extra_rounds if search else 0
    key = hashlib.sha256(f'{options.mission}/{survey.plan_id}/{token}'.encode()).digest()
    start = _count_start(options.state_directory) << START_BITS | secrets.randbits(START_BITS)
    agents = [
        Agent(names.index(name), first, key, now_s, start, rounds=rounds)
        for name in options.vehicles
    ]
    local = LocalAgents(agents)
    return FleetStart(survey, local, key, options.state_directory, batteries, search)


def _batteries(options: AgentOptions) -> Batteries:
    path = options.batteries_file
    return read_values(Path(path), Batteries) if path else Batteries()


def _search(options: AgentOptions) -> SearchOptions | None:
    path = options.search_file
    return read_values(Path(path), SearchOptions) if path else None


def keep_plan(plan: SurveyPlan, folder: Path) -> None:
    """Write a plan of the agents where the planner writes its further plans.

    Raises
    ------
    ValueError
        If the folder cannot be written.
    """
    # Loaded here: pictures and archives, which an agent needs for nothing else.
    from rocsafe_planner.export.plan_files import write_plan

    write_plan(plan, further_folder(folder, plan.plan_id))


def has_started(folder: str) -> bool:
    """Return whether agents with this folder have begun a survey before."""
    return bool(folder) and (Path(folder) / _STARTS).is_file()


def _count_start(folder: str) -> int:
    """Return the number of this start, from 1; starts count in a file of the folder.

    One that cannot be read counts as none: the agent begins again when the others tell it.
    """
    if not folder:
        return 1
    path = Path(folder) / _STARTS
    path.parent.mkdir(parents=True, exist_ok=True)
    number = 1
    with suppress(OSError, ValueError):
        number += int(path.read_text())
    write_whole(path, str(number).encode())
    return number
