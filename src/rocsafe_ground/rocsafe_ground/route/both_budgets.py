# SPDX-License-Identifier: Apache-2.0
"""The fastest path within budgets of dose and of toxic load: the dual of both, then labels."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_ground.errors import BeyondBudgetError, NoWayError
from rocsafe_ground.route.constrained import (
    ROUNDING,
    BoundedPath,
    SearchEffort,
    path_of_labels,
)
from rocsafe_ground.route.edges import GridPath, Searcher, Tree, Weights
from rocsafe_ground.route.prices import best_prices
from rocsafe_ground.route.route_kernels import FOUND, NONE_FOUND, label_search_both

# Part of the time within which the bound of new prices is that of the paths known.
SAME_LEVEL = 1e-7


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class _Dual:
    """Paths and bounds by prices: the best path within both budgets, None if none was met."""

    best: GridPath | None
    bound_s: float
    prices: tuple[tuple[float, float], ...]
    trees: tuple[Tree, ...]


def fastest_within(
    searcher: Searcher,
    ends: tuple[int, int],
    budgets: tuple[float, float],
    effort: SearchEffort | None = None,
) -> BoundedPath:
    """Return the fastest path from a start to a goal, `ends`, within dose and toxic load.

    Parameters
    ----------
    searcher
        Of a grid with loads.
    budgets
        Of dose, uSv, and of toxic load, times that of a level.
    effort
        Labels and steps of the dual; without `is_exact` the dual is the whole search.

    Raises
    ------
    NoWayError
        If no free cells lead from one to the other.
    BeyondBudgetError
        If there is no path within the budgets, or none was found.
    """
    effort = effort or SearchEffort()
    start, goal = ends
    least = tuple(
        searcher.tree(goal, weights)
        for weights in ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
    )
    if math.isinf(least[0].costs[start]):
        raise NoWayError('no drivable ground leads from the start to the goal')
    pure = [searcher.edges.path_of(tree.path_to(start)[::-1].copy()) for tree in least]
    _require(pure, budgets)
    if _fits(pure[0], budgets):
        return _bounded(pure[0], pure[0].time_s, (0.0, 0.0), 0)
    dual = _dual(searcher, ends, pure, budgets, effort)
    if effort.is_exact and not _is_closed(dual):
        return _exact(searcher, ends, least, dual, (budgets, effort.most_labels))
    if dual.best is None:
        raise BeyondBudgetError(
            f'no path within {budgets[0]:.4g} uSv and a load of {budgets[1]:.4g} was found'
        )
    return _bounded(dual.best, dual.bound_s, dual.prices[-1], 0)


def _require(pure: list[GridPath], budgets: tuple[float, float]) -> None:
    if pure[1].dose_usv > budgets[0] * (1.0 + ROUNDING):
        raise BeyondBudgetError(
            f'the dose budget of {budgets[0]:.4g} uSv is too small: the cleanest way takes '
            f'{pure[1].dose_usv:.4g} uSv'
        )
    if pure[2].load > budgets[1] * (1.0 + ROUNDING):
        raise BeyondBudgetError(
            f'the load budget of {budgets[1]:.4g} is too small: the purest way takes '
            f'{pure[2].load:.4g}'
        )


def _fits(path: GridPath, budgets: tuple[float, float]) -> bool:
    dose, load = (budget * (1.0 + ROUNDING) for budget in budgets)
    return path.dose_usv <= dose and path.load <= load


def _is_closed(dual: _Dual) -> bool:
    return dual.best is not None and dual.best.time_s <= dual.bound_s * (1.0 + ROUNDING)


def _bounded(
    path: GridPath, bound_s: float, prices: tuple[float, float], labels: int
) -> BoundedPath:
    return BoundedPath(
        path=path, bound_s=min(bound_s, path.time_s), price_s_per_usv=prices[0],
        price_s_per_load=prices[1], label_count=labels,
    )  # fmt: skip


def _dual(
    searcher: Searcher,
    ends: tuple[int, int],
    pure: list[GridPath],
    budgets: tuple[float, float],
    effort: SearchEffort,
) -> _Dual:
    start, goal = ends
    known = [(one.time_s, one.dose_usv, one.load) for one in pure]
    fitting = [one for one in pure if _fits(one, budgets)]
    bound, prices, trees = pure[0].time_s, [], []
    for _ in range(effort.most_duals):
        price, level = best_prices(known, budgets)
        weights: Weights = (1.0, *price)
        tree = searcher.tree(goal, weights)
        path = searcher.edges.path_of(tree.path_to(start)[::-1].copy())
        lagrangian = float(tree.costs[start]) - price[0] * budgets[0] - price[1] * budgets[1]
        bound = max(bound, lagrangian)
        prices.append(price)
        trees.append(tree)
        if _fits(path, budgets):
            fitting.append(path)
        if lagrangian >= level - SAME_LEVEL * abs(level):
            break
        known.append((path.time_s, path.dose_usv, path.load))
    best = min(fitting, key=lambda one: one.time_s, default=None)
    return _Dual(best=best, bound_s=bound, prices=tuple(prices), trees=tuple(trees))


def _exact(
    searcher: Searcher,
    ends: tuple[int, int],
    least: tuple[Tree, ...],
    dual: _Dual,
    size: tuple[tuple[float, float], int],
) -> BoundedPath:
    """Return the optimum, or the best known if there are more labels than room."""
    budgets, room = size
    edges = searcher.edges
    assert edges.loads is not None  # noqa: S101 - see `fastest_within`
    most = math.inf if dual.best is None else dual.best.time_s
    slack = 1.0 + ROUNDING
    limits = (most * slack, budgets[0] * slack, budgets[1] * slack)
    labels = (
        np.empty(room, np.int64), np.empty(room, np.int64),
        np.empty(room), np.empty(room), np.empty(room),
    )  # fmt: skip
    status, last, count, reached = label_search_both(
        (edges.times_s, edges.doses_usv, edges.loads),
        edges.offsets,
        ends,
        limits,
        (least[0].costs, least[1].costs, least[2].costs),
        (np.array(dual.prices), _stacked(dual.trees)),
        labels,
        (np.full(edges.cells, -1, np.int64), np.empty(room, np.int64)),
        (np.empty(room), np.empty(room, np.int64)),
    )
    if status == FOUND:
        path = edges.path_of(path_of_labels(labels[0], labels[1], last))
        return _bounded(path, path.time_s, dual.prices[-1], int(count))
    if dual.best is None:
        raise BeyondBudgetError(
            f'no path within {budgets[0]:.4g} uSv and a load of {budgets[1]:.4g} '
            + ('exists' if status == NONE_FOUND else 'was found')
        )
    bound = dual.best.time_s if status == NONE_FOUND else max(dual.bound_s, float(reached))
    return _bounded(dual.best, bound, dual.prices[-1], int(count))


def _stacked(trees: tuple[Tree, ...]) -> FloatArray:
    return np.stack([tree.costs for tree in trees])
