# SPDX-License-Identifier: Apache-2.0
"""Plan random surveys of all kinds and print each fault in one line.

    python tools/planning_campaign.py [--first N] [--count N] [--files]

Each number is the seed of a survey (`drawn_surveys`), planned with a budget of 0.05 to 0.2 s or a
number of proposals; then up to two random situations are replanned. Every plan must be accepted by
the independent checker and be at least as good as a survey tool's split; every refusal must be one
line that the planner raises; no survey may take longer than a minute of processor time,
or ten minutes by the clock. The exit code is 1 after a fault. A fault names its seed:
`--first N --count 1` repeats it.
"""

import argparse
import dataclasses
import linecache
import math
import signal
import sys
import tempfile
import time
import traceback
from collections import Counter
from collections.abc import Iterator
from types import FrameType

from drawn_surveys import Dice, drawn_request, drawn_situation
from rocsafe_planner.checking.plan_checker import check_plan
from rocsafe_planner.errors import BeyondEnduranceError, PlannerError
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_planner.plan.plan_reading import read_plan
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.replanning import remaining_request

LIMIT_S = 60
# By the clock, for a search that waits without computing.
CLOCK_LIMIT_S = 600
PROGRESS = 20
COMPARED = 4
"""One of so many surveys is also planned by the survey tools' methods."""
SPLITS = ('boustrophedon_minmax', 'boustrophedon_equal', 'strips')


class OverdueError(Exception):
    """A plan takes longer than it may."""


@dataclasses.dataclass(slots=True)
class Tally:
    """Results of the surveys so far."""

    plans: int = 0
    refusals: Counter[str] = dataclasses.field(default_factory=Counter)
    faults: list[str] = dataclasses.field(default_factory=list)
    slowest: tuple[float, int] = (0.0, -1)


def look(number: int, tally: Tally, *, with_files: bool = False) -> None:
    """Plan the survey of a seed, replan its situations, and note faults."""
    plan: SurveyPlan | None = None
    for times in range(3):
        began = time.monotonic()
        try:
            if times == 0:
                request = _hurried(drawn_request(number), number)
            elif plan is not None:
                request = remaining_request(plan, drawn_situation(plan, number, times))
            plan = plan_survey(request)
        except Exception as error:  # noqa: BLE001 - every other exception is a fault
            _note_error(f'{number}.{times}', error, tally)
            if times == 0 or not isinstance(error, (PlannerError, ValueError)):
                return
            continue
        tally.plans += 1
        tally.slowest = max(tally.slowest, (time.monotonic() - began, number))
        found = [*_faults(plan, with_files)]
        found += [] if number % COMPARED else [*_worse_than_splits(plan)]
        tally.faults.extend(f'{number}.{times}: {fault}' for fault in found)


def _hurried(request: SurveyRequest, number: int) -> SurveyRequest:
    """Return a request with little time, or few proposals."""
    dice = Dice(3, number)
    budget_s, proposals = dice.one((0.05, 0), (0.2, 0), (0.0, 20_000), (0.0, 60_000))
    effort = dataclasses.replace(request.effort, budget_s=budget_s, proposals=proposals)
    return dataclasses.replace(request, effort=effort)


def _note_error(name: str, error: Exception, tally: Tally) -> None:
    """Note a refusal; it is a fault unless the planner raised it itself."""
    frame = traceback.extract_tb(error.__traceback__)[-1]
    line = linecache.getline(frame.filename, frame.lineno or 0).strip()
    text = str(error)
    is_meant = isinstance(error, (PlannerError, ValueError)) and line.startswith('raise')
    tally.refusals[type(error).__name__] += 1
    if not is_meant or '\n' in text or not 10 <= len(text) <= 250:
        where = f'{frame.filename}:{frame.lineno}'
        tally.faults.append(f'{name}: {type(error).__name__} at {where}: {text}')
    else:
        tally.refusals[text] += 1


def _faults(plan: SurveyPlan, with_files: bool) -> Iterator[str]:
    """Yield the faults of a plan."""
    yield from check_plan(plan)
    if with_files:
        yield from _file_faults(plan)


def _worse_than_splits(plan: SurveyPlan) -> Iterator[str]:
    """Yield the survey tools' splits that are better than the solver's plan."""
    request = plan.request
    effort = request.effort
    if effort.method != 'solver' or not effort.minimises_makespan or request.separation.distance_m:
        return
    for method in SPLITS:
        try:
            split = dataclasses.replace(effort, method=method)
            other = plan_survey(dataclasses.replace(request, effort=split))
        except BeyondEnduranceError:
            continue
        if plan.makespan_s > other.makespan_s * (1.0 + 1e-6):
            yield f'{plan.makespan_s:.3f} s is more than {other.makespan_s:.3f} s by {method}'


def _file_faults(plan: SurveyPlan) -> Iterator[str]:
    """Yield differences of the plan after its files were written and read."""
    if plan.request.terrain is not None:
        return  # the files of a plan do not hold the terrain
    with tempfile.TemporaryDirectory() as folder:
        paths = write_plan(plan, folder)
        again = read_plan(paths[-1])
    if not math.isclose(again.makespan_s, plan.makespan_s, rel_tol=1e-6):
        yield f'read back, it takes {again.makespan_s} s instead of {plan.makespan_s} s'


def _overdue(_number: int, _frame: FrameType | None) -> None:
    raise OverdueError(f'takes longer than {LIMIT_S} s of processor time or {CLOCK_LIMIT_S} s')


def main() -> int:
    """Plan, and print the faults."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--first', type=int, default=0, help='number of the first survey')
    parser.add_argument('--count', type=int, default=2000)
    parser.add_argument('--files', action='store_true', help='write and read each plan too')
    parser.add_argument('--refusals', action='store_true', help='print what was refused')
    options = parser.parse_args()
    for kind in (signal.SIGALRM, signal.SIGPROF):
        signal.signal(kind, _overdue)
    tally, began = Tally(), time.monotonic()
    for number in range(options.first, options.first + options.count):
        known = len(tally.faults)
        signal.alarm(CLOCK_LIMIT_S)
        signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
        look(number, tally, with_files=options.files)
        for fault in tally.faults[known:]:
            print(fault, flush=True)
        if number % PROGRESS == 0:
            print(f'{number}: {tally.plans} plans', file=sys.stderr, flush=True)
    if options.refusals:
        for text, times in sorted(tally.refusals.items()):
            print(f'{times:5d} {text}')
    refused = sum(tally.refusals[name] for name in tally.refusals if name.endswith('Error'))
    print(
        f'{options.count} surveys: {tally.plans} plans accepted or faulty, {refused} refused, '
        f'{len(tally.faults)} faults, {time.monotonic() - began:.0f} s; the slowest plan took '
        f'{tally.slowest[0]:.1f} s (number {tally.slowest[1]})'
    )
    return 1 if tally.faults else 0


if __name__ == '__main__':
    sys.exit(main())
