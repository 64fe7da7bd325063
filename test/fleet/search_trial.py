# SPDX-License-Identifier: Apache-2.0
"""A trial whose agents search after the survey: its vehicles read dose rates."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.agreement.fleet_plan import SharedPlans
from rocsafe_fleet.ledger.readings import DoseReading, ReadingSums, readings_of
from rocsafe_fleet.search.search_round import SearchRound
from rocsafe_fleet.trial.trial import KEY, Outcome, Trial, TrialOptions
from rocsafe_fleet.trial.vehicle import TrialVehicle
from rocsafe_geo.position import GeoPosition, level_offset_m
from rocsafe_planner.plan.plan import SurveyPlan

READING_S = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TrialSearch:
    """How the agents of a trial search.

    Attributes
    ----------
    rounds
        Most rounds.
    choose
        Returns the round of a number from the readings that an agent knows.
    rate_usvh
        Returns the dose rate at a place.
    """

    rounds: int
    choose: Callable[[int, Sequence[tuple[str, DoseReading]]], SearchRound]
    rate_usvh: Callable[[GeoPosition], float]


class SearchTrial(Trial):
    """A fleet of agents that fly a plan, then rounds of a search.

    Attributes
    ----------
    choices
        Agents that chose a round, its number, and when.
    """

    def __init__(
        self,
        survey: SurveyPlan,
        options: TrialOptions,
        random: np.random.Generator,
        plans: SharedPlans,
        search: TrialSearch,
    ) -> None:
        self._search = search
        self.choices: list[tuple[int, int, float]] = []
        self._choosing: dict[int, tuple[float, SearchRound]] = {}
        self._sums: dict[int, tuple[Agent, ReadingSums]] = {}
        self._read_s = [0.0] * len(survey.routes)
        self._names = [route.vehicle.name for route in survey.routes]
        self._origin = survey.request.regions[0].area.centroid()
        super().__init__(survey, options, random, plans)
        self._surveyed = frozenset(self.places)

    def _agent(self, number: int, incarnation: int, now_s: float) -> Agent:
        agreement, rounds = self.options.agreement, self._search.rounds
        return Agent(number, self._first, KEY, now_s, incarnation, agreement, rounds)

    def kill_agent(self, number: int) -> None:
        """End an agent, with what it computes."""
        super().kill_agent(number)
        self._choosing.pop(number, None)

    def lose(self, number: int) -> None:
        """Lose a vehicle with its agent."""
        super().lose(number)
        self._choosing.pop(number, None)

    def _is_over(self) -> bool:
        return super()._is_over() and all(agent.is_done for agent in self.live)

    def _concluded(self) -> Outcome:
        """Count as missing what somebody who lives knows of: a round may die with its chooser."""
        outcome = super()._concluded()
        extra = frozenset[int]().union(*(agent.knowledge.extra_points for agent in self.live))
        outcome.missing = len((self._surveyed | extra) - self._seen.keys())
        return outcome

    def _fly(self, number: int, vehicle: TrialVehicle) -> None:
        super()._fly(number, vehicle)
        agent = self.agents[number]
        if agent is None or self.now_s - self._read_s[number] < READING_S - 1e-9:
            return
        if number not in self._sums or self._sums[number][0] is not agent:
            self._sums[number] = agent, ReadingSums(agent.ledger)
        sums = self._sums[number][1]
        if not vehicle.is_aloft:
            sums.close()
            return
        self._read_s[number] = self.now_s
        here = vehicle.place(self.now_s).position
        position = replace(here, altitude_m=vehicle.height_m)
        rate = self._search.rate_usvh(position)
        sums.add(
            DoseReading(
                position=position, dose_rate_usvh=rate, std_usvh=0.1 * rate, time_s=self.now_s
            )
        )

    def _think(self, agent: Agent) -> None:
        if (wanted := agent.wanted) is not None:
            for point, place in wanted.extra:
                self.places[point] = level_offset_m(self._origin, place)
        known = self._choosing.get(agent.own)
        if not agent.seeks:
            self._choosing.pop(agent.own, None)
        elif known is None:
            readings = readings_of([agent.ledger], self._names)
            chosen = self._search.choose(agent.seeks, readings)
            self._choosing[agent.own] = self.now_s + self.options.planning_s, chosen
        elif self.now_s >= known[0]:
            del self._choosing[agent.own]
            self.choices.append((agent.own, agent.seeks, self.now_s))
            agent.decide(known[1])
        super()._think(agent)
