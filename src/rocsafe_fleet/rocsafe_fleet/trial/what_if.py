# SPDX-License-Identifier: Apache-2.0
"""Trials of a planned mission in which vehicles, agents or the radio fail."""

import dataclasses
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from functools import partial
from itertools import combinations

import numpy as np

from rocsafe_fleet.agreement.fleet_plan import SharedPlans, Wanted, situation_of
from rocsafe_fleet.trial.radio import RadioOptions
from rocsafe_fleet.trial.trial import Trial, TrialOptions, planner_of
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.survey_options import Effort
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.replanning import remaining_request

SHARES = (0.25, 0.5, 0.75)
"""Parts of the makespan after which one vehicle is lost."""
CUT_S = 60.0
"""Time for which the two halves of the fleet do not hear each other."""

Event = tuple[float, Callable[[Trial], None]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Case:
    """Something that happens to a mission, and whether vehicles are lost by it."""

    name: str
    events: tuple[Event, ...] = ()
    is_loss: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """Result of one trial.

    Attributes
    ----------
    makespan_s
        When the last vehicle landed.
    central_s
        When it would have with one head that searches longer, all viewpoints free; None: nobody
        was lost, or nothing was planned again.
    missing, duplicates
        Viewpoints not photographed, and photographs of those that were photographed before.
    epochs
        Agreements that were flown.
    payload_bytes
        Handed to the radio by the vehicle that sent most.
    least_m
        Least distance of two vehicles in the air, on their legs.
    """

    name: str
    makespan_s: float
    central_s: float | None
    missing: int
    duplicates: int
    epochs: int
    payload_bytes: int
    least_m: float


def cases_of(survey: SurveyPlan) -> Iterator[Case]:
    """Yield the cases of a survey: each vehicle at three times, pairs, the head, a cut."""
    count, whole_s = len(survey.routes), survey.makespan_s
    names = [route.vehicle.name for route in survey.routes]
    yield Case(name='nothing fails', is_loss=False)
    for share in SHARES:
        for k in range(count if count > 1 else 0):
            yield Case(name=f'{names[k]} at {share:.0%}', events=(_loss(share * whole_s, k),))
    for pair in combinations(range(count if count > 2 else 0), 2):
        yield Case(
            name=f'{names[pair[0]]}, {names[pair[1]]} at 50%',
            events=tuple(_loss(0.5 * whole_s, k) for k in pair),
        )
    if count > 1:
        head = (0.5 * whole_s, lambda trial: trial.kill_agent(0))
        yield Case(name='agent of the head at 50%', events=(head,), is_loss=False)
        halves = [list(range(count // 2)), list(range(count // 2, count))]
        cut = (0.25 * whole_s, lambda trial: trial.radio.cut(halves))
        heal = (0.25 * whole_s + CUT_S, lambda trial: trial.radio.heal())
        yield Case(
            name=f'halves cut off for {CUT_S:.0f} s at 25%', events=(cut, heal), is_loss=False
        )


def _loss(time_s: float, number: int) -> Event:
    return time_s, partial(Trial.lose, number=number)


def what_if(survey: SurveyPlan, radio: RadioOptions, seed: int, budget_s: float) -> Iterator[Row]:
    """Yield what becomes of each case; the central search has `budget_s` seconds."""
    plans = SharedPlans(planner_of(survey))
    for case in cases_of(survey):
        trial = Trial(survey, TrialOptions(radio=radio), np.random.default_rng(seed), plans)
        for time_s, event in case.events:
            trial.at(time_s, event)
        outcome = trial.run()
        first = trial.first_wanted if case.is_loss else None
        yield Row(
            name=case.name,
            makespan_s=outcome.makespan_s,
            central_s=None if first is None else central_s(trial, first, budget_s),
            missing=outcome.missing,
            duplicates=outcome.duplicates,
            epochs=len(outcome.flying_s),
            payload_bytes=max(outcome.payload_bytes),
            least_m=outcome.least_m,
        )


def central_s(trial: Trial, wanted: Wanted, budget_s: float) -> float:
    """Return when a fleet with one head would have landed, from the same situation.

    All viewpoints are free, and the search has so many seconds of wall time.
    """
    proposal = dataclasses.replace(wanted.proposal, last=frozenset())
    free = dataclasses.replace(wanted, proposal=proposal)
    request = remaining_request(trial.survey, situation_of(trial.survey, free))
    effort = Effort(budget_s=budget_s, seed=request.effort.seed)
    best = plan_survey(dataclasses.replace(request, effort=effort))
    begun_s = min(trial.outcome.flying_s.values()) - trial.options.planning_s
    return begun_s + best.makespan_s
