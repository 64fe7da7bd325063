# SPDX-License-Identifier: Apache-2.0
"""One mission of agents and vehicles in simulated time, over a simulated radio."""

import math
from collections.abc import Callable, Iterable
from dataclasses import dataclass, field
from itertools import combinations

import numpy as np

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.fleet_plan import (
    FleetPlan,
    SharedPlans,
    Wanted,
    first_plan,
    plan_of,
)
from rocsafe_fleet.agreement.options import AgreementOptions
from rocsafe_fleet.ledger.records import Epoch
from rocsafe_fleet.trial.radio import RadioOptions, SimulatedRadio
from rocsafe_fleet.trial.vehicle import TrialVehicle
from rocsafe_geo.position import level_offset_m
from rocsafe_planner.plan.plan import SurveyPlan

KEY = b'trial'


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialOptions:
    """How a trial is run.

    Attributes
    ----------
    step_s
        Of simulated time.
    planning_s
        That an agent needs for a plan, simulated seconds.
    longest_s
        The trial ends then, whatever is left.
    """

    radio: RadioOptions = field(default_factory=RadioOptions)
    agreement: AgreementOptions = field(default_factory=AgreementOptions)
    step_s: float = 0.1
    planning_s: float = 0.7
    longest_s: float = 7200.0


@dataclass(slots=True, kw_only=True)
class Outcome:
    """Result of a trial.

    Attributes
    ----------
    makespan_s
        When the last vehicle landed.
    missing
        Viewpoints that nobody photographed.
    duplicates
        Photographs of viewpoints that were photographed before.
    least_m
        Least distance of two vehicles in the air, as if at the height of their legs: climbs and
        descents are kept apart by the ways of the planner, which are not flown here.
    flying_s
        When each epoch's routes were flown by all its live members.
    payload_bytes, packets
        Of each vehicle.
    """

    makespan_s: float = 0.0
    missing: int = 0
    duplicates: int = 0
    least_m: float = math.inf
    flying_s: dict[Epoch, float] = field(default_factory=dict)
    payload_bytes: list[int] = field(default_factory=list)
    packets: list[int] = field(default_factory=list)
    alarms: int = 0


class Trial:
    """A fleet of agents that fly a plan.

    Parameters
    ----------
    survey
        The plan.
    plans
        Computes plans of epochs; shared by trials of the same survey, it computes each once.

    Attributes
    ----------
    agents, vehicles
        By number; a lost one is None.
    now_s
        Simulated time.
    first_wanted
        Proposal of the first epoch that was flown.
    """

    def __init__(
        self,
        survey: SurveyPlan,
        options: TrialOptions,
        random: np.random.Generator,
        plans: SharedPlans | None = None,
    ) -> None:
        self.survey, self.options = survey, options
        self.now_s = 0.0
        self._plans = plans or SharedPlans(planner_of(survey))
        origin = survey.request.regions[0].area.centroid()
        views = [view for route in survey.routes for view in route.viewpoints]
        self.places = {v.id: level_offset_m(origin, v.position) for v in views}
        first, height_m = first_plan(survey), survey.request.coverage.height_agl_m
        layers = survey.request.layers_m or (0.0,) * len(survey.routes)
        count = len(survey.routes)
        self.radio = SimulatedRadio(count, options.radio, random)
        self.vehicles: list[TrialVehicle | None] = [
            TrialVehicle(route.vehicle, origin, self.places, height_m + layer)
            for route, layer in zip(survey.routes, layers, strict=True)
        ]
        self._first = first
        self.agents: list[Agent | None] = [self._agent(k, 1, 0.0) for k in range(count)]
        self._computing: dict[int, tuple[float, object, FleetPlan]] = {}
        self._seen: dict[int, int] = {}
        self._events: list[tuple[float, Callable[[Trial], None]]] = []
        self.outcome = Outcome()
        self.first_wanted: Wanted | None = None

    def at(self, time_s: float, event: Callable[['Trial'], None]) -> None:
        """Let something happen at a time."""
        self._events.append((time_s, event))
        self._events.sort(key=lambda one: one[0])

    def lose(self, number: int) -> None:
        """Lose a vehicle with its agent: nothing is heard of it any more."""
        self.agents[number] = self.vehicles[number] = None
        self._computing.pop(number, None)

    def kill_agent(self, number: int) -> None:
        """End an agent; its vehicle flies its route on."""
        self.agents[number] = None
        self._computing.pop(number, None)

    def start_agent(self, number: int, incarnation: int) -> None:
        """Start an agent that knows the first plan only."""
        self.agents[number] = self._agent(number, incarnation, self._clock_s(number))

    def _agent(self, number: int, incarnation: int, now_s: float) -> Agent:
        return Agent(number, self._first, KEY, now_s, incarnation, self.options.agreement)

    @property
    def live(self) -> list[Agent]:
        """Agents that run."""
        return [agent for agent in self.agents if agent is not None]

    def run(self, until: Callable[['Trial'], bool] | None = None) -> Outcome:
        """Fly until all have landed, or `until` returns True; return what came of it."""
        while self.now_s < self.options.longest_s:
            self._step()
            if until(self) if until else self._is_over():
                break
        return self._concluded()

    def _is_over(self) -> bool:
        has_flown = self.now_s > 1.0
        is_aloft = any(v.is_aloft for v in self.vehicles if v is not None)
        waits = bool(self._computing) or any(
            agent.route and self.vehicles[agent.own] is not None for agent in self.live
        )
        recent = any(abs(t - self.now_s) < 20.0 for t in self.outcome.flying_s.values())
        return has_flown and not (is_aloft or waits or recent or self._events)

    def _step(self) -> None:
        self.now_s = round(self.now_s + self.options.step_s, 6)
        while self._events and self._events[0][0] <= self.now_s:
            self._events.pop(0)[1](self)
        for receiver, data in self.radio.due(self.now_s):
            self._deliver(receiver, data)
        for number, vehicle in enumerate(self.vehicles):
            if vehicle is not None:
                self._fly(number, vehicle)
        for agent in self.live:
            self._think(agent)
        self._watch()

    def _clock_s(self, _number: int) -> float:
        """Return what the clock of an agent shows."""
        return self.now_s

    def _deliver(self, receiver: int, data: bytes) -> None:
        if (agent := self.agents[receiver]) is not None:
            agent.receive(data, self._clock_s(receiver))

    def _fly(self, number: int, vehicle: TrialVehicle) -> None:
        points = vehicle.advance(self.now_s)
        for point in points:
            self._seen[point] = self._seen.get(point, 0) + 1
        if vehicle.landed_s is not None:
            self.outcome.makespan_s = max(self.outcome.makespan_s, vehicle.landed_s)
        agent = self.agents[number]
        if agent is None:
            return
        if points:
            agent.visit(points)
        agent.move(vehicle.place(self.now_s))
        vehicle.fly(agent.route, self.now_s)

    def _think(self, agent: Agent) -> None:
        wanted, number = agent.wanted, agent.own
        if wanted is not None:
            known = self._computing.get(number)
            if known is None or known[1] != wanted.epoch:
                plan = self._plans.get(wanted)
                due_s = self.now_s + self.options.planning_s
                self._computing[number] = due_s, wanted.epoch, plan
            elif self.now_s >= known[0]:
                del self._computing[number]
                agent.planned(wanted, known[2])
                self._note_flying(agent, wanted)
        else:
            self._computing.pop(number, None)
        for data in agent.advance(self._clock_s(number)):
            self.radio.send(number, data, self.now_s)

    def _note_flying(self, agent: Agent, wanted: Wanted) -> None:
        members = [self.agents[k] for k in agent.proposal.names]
        if all(m is None or m.epoch >= agent.epoch for m in members):
            self.outcome.flying_s[agent.epoch] = self.now_s
            self.first_wanted = self.first_wanted or wanted

    def _watch(self) -> None:
        """Note the least distance of vehicles on their legs: these lead around no columns."""
        flying = [v for v in self.vehicles if v is not None and v.is_aloft]
        for a, b in combinations(flying, 2):
            (x, y), (u, w) = a.plane(self.now_s), b.plane(self.now_s)
            apart = math.dist((x, y, a.height_m), (u, w, b.height_m))
            self.outcome.least_m = min(self.outcome.least_m, apart)

    def _concluded(self) -> Outcome:
        outcome = self.outcome
        outcome.missing = len(self.places.keys() - self._seen.keys())
        outcome.duplicates = sum(count - 1 for count in self._seen.values())
        outcome.payload_bytes = self.radio.payload_bytes
        outcome.packets = self.radio.packets
        outcome.alarms = sum(len(agent.alarms) for agent in self.live)
        return outcome


def planner_of(survey: SurveyPlan) -> Callable[[Wanted], FleetPlan]:
    """Return how the plans of a survey's epochs are computed."""
    return lambda wanted: plan_of(survey, wanted)


def agreed(agents: Iterable[Agent]) -> bool:
    """Return whether all these agents keep to the same plan and know the same."""
    found = {(agent.epoch, agent.plan.digest, agent.ledger.digest) for agent in agents}
    return len(found) == 1
