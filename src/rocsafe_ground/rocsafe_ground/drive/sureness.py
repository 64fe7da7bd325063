# SPDX-License-Identifier: Apache-2.0
"""The fastest drive that keeps its budgets surely, and the budgets that would admit one."""

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.drive.task import Drive, Task
from rocsafe_ground.errors import BeyondBudgetError
from rocsafe_ground.route.constrained import ROUNDING
from rocsafe_ground.tour.trip import Budgets, Tour

# Bisections of the dose that is planned for: to a hundredth of what is between.
MOST_TIGHTENINGS = 7
# Load that is planned for is lowered so often, each time to this part of what would just do.
MOST_LOWERINGS, LOWERED = 5, 0.999
# A budget is tested before it is proposed; it is raised by this factor, at most this often.
MOST_RAISES, RAISED = 10, 1.02
# More points that do not fit are not told one by one.
MOST_TOLD = 5
MOST_EXCESS = 1e12


def sure_drive(task: Task, tour: Tour) -> Drive | None:
    """Return the fastest drive to the points of a tour that is sure enough, None if none is.

    The tour keeps the budgets over cells. Braking and turns in place come on top, and the upper
    95 % of each cell is mostly, not always, more than enough for the sum. Where it is not, the
    dose, or the load, that is planned for is lowered.
    """
    planned = task.budgets
    for _ in range(MOST_LOWERINGS):
        drive = _sure_dose(task, tour, planned)
        if drive is None:
            return None
        if drive.load <= task.budgets.load:
            return drive if drive.time_s <= task.budgets.time_s * (1.0 + ROUNDING) else None
        excess = drive.load / task.budgets.load if task.budgets.load else math.inf
        planned = replace(planned, load=LOWERED * min(planned.load, drive.tour.load) / excess)
        try:
            tour = task.search.within(tour.chosen, planned)
        except BeyondBudgetError:
            return None
    return None


def _sure_dose(task: Task, tour: Tour, planned: Budgets) -> Drive | None:
    """Return the fastest drive whose dose is within the budget with the confidence asked for."""
    confidence = task.request.confidence
    drive = task.drive(tour)
    if drive.forecast.probability >= confidence:
        return drive
    cleanest = task.search.cleanest(tour.chosen, planned.load)
    best = None if cleanest is None else task.drive(cleanest)
    if best is None or best.forecast.probability < confidence:
        return None
    low, high = best.tour.dose_usv, tour.dose_usv
    for _ in range(MOST_TIGHTENINGS):
        middle = 0.5 * (low + high)
        try:
            drive = task.drive(task.search.within(tour.chosen, replace(planned, dose_usv=middle)))
        except BeyondBudgetError:
            low = middle
            continue
        if drive.forecast.probability >= confidence:
            low, best = middle, drive
        else:
            high = middle
    return best


def needed(task: Task, chosen: int) -> Budgets:
    """Return budgets that admit a set of points: each as it is where that would do.

    They were tried. Of the trips known the one counts that breaks the fewest budgets, by least.
    """
    limits = task.budgets.limits

    def excess(costs: FloatArray) -> FloatArray:
        shares = costs / np.maximum(np.array(limits), 1e-300)
        # A broken budget more is worse than any excess.
        worst = np.minimum(shares.max(axis=1), MOST_EXCESS)
        return np.asarray((shares > 1.0 + ROUNDING).sum(axis=1) * MOST_EXCESS + worst)

    drive = task.drive(task.search.known(chosen, excess))
    dose = max(drive.tour.dose_usv, drive.forecast.upper_usv)
    time, load = max(drive.tour.time_s, drive.time_s), max(drive.tour.load, drive.load)
    for k in range(MOST_RAISES):
        wanted = (RAISED**k * value for value in (time, dose, load))
        raised = (max(pair) for pair in zip(map(_up, wanted), limits, strict=True))
        found = Budgets(**dict(zip(('time_s', 'dose_usv', 'load'), raised, strict=True)))
        if _admits(task.within(found), chosen):
            break
    return found


def _admits(task: Task, chosen: int) -> bool:
    """Return whether the budgets of a task admit a set of points.

    The search starts anew: its result depends on the ways that it knows already.
    """
    if math.isfinite(task.budgets.load):
        task = replace(task, search=task.search.renewed())
    try:
        tour = task.search.within(chosen, task.budgets)
    except BeyondBudgetError:
        return False
    return sure_drive(task, tour) is not None


def needed_text(task: Task, chosen: int) -> str:
    """Return what a set of points takes in words, for what the budgets are too small."""
    known, found = task.budgets, needed(task, chosen)
    texts = []
    if found.dose_usv > known.dose_usv:
        texts.append(f'a dose budget of {found.dose_usv:.4g} uSv')
    if found.load > known.load:
        texts.append(f'a load budget of {found.load:.4g}')
    if found.time_s > known.time_s:
        texts.append(f'an endurance of {math.ceil(found.time_s)} s')
    return ' and '.join(texts) or 'more of each budget: they are nearly used up'


def beyond_text(task: Task) -> str:
    """Return that not one point can be visited, and what each, and all, would take."""
    count, known = len(task.stands), task.budgets
    limits = [f'{known.dose_usv:.4g} uSv']
    if math.isfinite(known.load):
        limits.append(f'a load of {known.load:.4g}')
    limits.append(f'{known.time_s:.4g} s')
    by_dose = sorted(range(count), key=lambda k: task.search.cleanest_usv(1 << k))
    told = by_dose[:MOST_TOLD]
    rows = [f'{task.stands[k].point.id} takes {needed_text(task, 1 << k)}' for k in told]
    if count > 1:
        rows.append(f'all {count} take {needed_text(task, (1 << count) - 1)}')
    return f'no point can be visited within {_listed(limits)}: {"; ".join(rows)}'


def _listed(words: Sequence[str]) -> str:
    return ', '.join(words[:-1]) + f' and {words[-1]}'


def _up(value: float) -> float:
    """Return a number with four digits, not below its value."""
    if not 0.0 < value < math.inf:
        return value
    step = 10.0 ** (math.floor(math.log10(value)) - 3)
    return float(f'{math.ceil(value / step - ROUNDING) * step:.4g}')
