# SPDX-License-Identifier: Apache-2.0
"""First plans of the search: sequences of all customers, split among the vehicles."""

from collections.abc import Iterator

import numpy as np

from rocsafe_planner.solver.model.compiled import Long, kernel
from rocsafe_planner.solver.model.problem import RoutingProblem
from rocsafe_planner.solver.model.tables import Floats, Ints, Tables, leg
from rocsafe_planner.solver.search.split import split
from rocsafe_planner.solver.search.state import path_cost

HILBERT_BITS = 16


def hilbert_order(points: Floats) -> Ints:
    """Return the indices of points, (n, 2 or more), in their order along a Hilbert curve."""
    low = points[:, :2].min(axis=0)
    extent = max(float((points[:, :2].max(axis=0) - low).max()), 1e-9)
    cells = ((points[:, :2] - low) / extent * (2**HILBERT_BITS - 1)).astype(np.int64)
    x, y = cells[:, 0].copy(), cells[:, 1].copy()
    key = np.zeros(len(points), np.int64)
    side = 1 << (HILBERT_BITS - 1)
    while side:
        right, upper = (x & side) > 0, (y & side) > 0
        key = key * 4 + ((3 * right) ^ upper)
        swap = ~upper
        mirror = swap & right
        x[mirror], y[mirror] = side - 1 - x[mirror], side - 1 - y[mirror]
        x[swap], y[swap] = y[swap], x[swap]
        side >>= 1
    return np.argsort(key, kind='stable').astype(np.int32)


def grid_angle(points: Floats, near: Ints) -> float:
    """Return the direction of the rows of a survey grid in radians, from nearest neighbours."""
    if not near.shape[1]:
        return 0.0
    step = points[near[:, 0], :2] - points[:, :2]
    turned = 4 * np.arctan2(step[:, 1], step[:, 0])
    return float(np.arctan2(np.sin(turned).sum(), np.cos(turned).sum()) / 4)


def serpentine_orders(points: Floats, near: Ints) -> Iterator[Ints]:
    """Yield orders that follow the rows of a grid, in alternating direction.

    There is one for each of the two directions of rows and each of the four corners.
    """
    spacing = _spacing(points, near)
    base = round(grid_angle(points, near), 9)
    for angle in (base, base + np.pi / 2):
        along = points[:, 0] * np.cos(angle) + points[:, 1] * np.sin(angle)
        across = points[:, 1] * np.cos(angle) - points[:, 0] * np.sin(angle)
        rank = np.argsort(across, kind='stable')
        gaps = np.diff(across[rank], prepend=across[rank[:1]]) > spacing / 2
        row = np.zeros(len(points), np.int64)
        row[rank] = np.cumsum(gaps)
        for first in (0, 1):
            forth = np.where(row % 2 == first, along, -along)
            order = np.lexsort((forth, row)).astype(np.int32)
            yield order
            yield order[::-1].copy()


def _spacing(points: Floats, near: Ints) -> float:
    """Return the median distance to the nearest other point."""
    if not near.shape[1]:
        return 1.0
    return float(np.median(np.linalg.norm(points[near[:, 0]] - points, axis=1)))


@kernel
def chain(tables: Tables, order: Ints) -> None:
    """Reorder customers from the first start by nearest neighbour."""
    here = Long(tables.first[0])
    for k in range(len(order)):
        best = k
        least = np.inf
        for j in range(k, len(order)):
            cost = leg(tables, Long(0), here, Long(order[j]))
            if cost < least:
                least = cost
                best = j
        order[k], order[best] = order[best], order[k]
        here = Long(order[k])


@kernel
def append_cheapest(tables: Tables, order: Ints, owner: Ints, paths: Floats, here: Ints) -> None:
    """Append each customer to the route of an allowed vehicle that is cheapest with it.

    Parameters
    ----------
    tables
        The problem.
    order : (n,)
        Customers in the order in which they are assigned.
    owner : (n,)
        Receives the vehicle of each customer.
    paths : (m,)
        Receives the cost of each route up to its last customer.
    here : (m,)
        Receives the last site of each route.
    """
    for r in range(len(here)):
        here[r] = Long(tables.first[r])
        paths[r] = 0.0
    for customer in order:
        best = np.inf
        chosen = 0
        for r in range(len(here)):
            if tables.needs[customer] & tables.ability[r] == 0:
                continue
            c = Long(tables.measure[r])
            path = paths[r] + leg(tables, c, Long(here[r]), Long(customer))
            path += leg(tables, c, Long(customer), Long(tables.last[r]))
            cost = path_cost(tables, r, Long(1), path)
            if cost < best:
                best = cost
                chosen = r
        owner[customer] = chosen
        c = Long(tables.measure[chosen])
        paths[chosen] += leg(tables, c, Long(here[chosen]), Long(customer))
        here[chosen] = customer


def orders(problem: RoutingProblem, tables: Tables) -> Iterator[Ints]:
    """Yield sequences of all customers that give good routes when they are split."""
    n = problem.customers
    if problem.points is not None:
        points = problem.points[:n]
        yield hilbert_order(points)
        yield from serpentine_orders(points, tables.near)
    if tables.dense:
        order = np.arange(n, dtype=np.int32)
        chain(tables, order)
        yield order


def turns(problem: RoutingProblem, order: Ints) -> Ints:
    """Return the vehicles in the order in which the sequence passes their starts."""
    m = len(problem.vehicles)
    starts = [v.start for v in problem.vehicles]
    if len(set(starts)) == 1 or problem.points is None:
        return np.arange(m, dtype=np.int32)
    points = problem.points[order]
    at = [int(np.argmin(((points - problem.points[s]) ** 2).sum(axis=1))) for s in starts]
    return np.argsort(at, kind='stable').astype(np.int32)


def first_plans(problem: RoutingProblem, tables: Tables) -> Iterator[tuple[Ints, Ints]]:
    """Yield plans for `State.load`: customers route after route, and the lengths of the routes."""
    n, m = problem.customers, len(problem.vehicles)
    served = False
    order: Ints = np.arange(n, dtype=np.int32)
    for order in orders(problem, tables):
        turn = turns(problem, order)
        lengths = np.zeros(m, np.int32)
        if np.isfinite(split(tables, order, turn, lengths)):
            served = True
            yield by_vehicle(order, turn, lengths), lengths
    if not served:
        yield assigned(tables, order)


def seen_from_home(problem: RoutingProblem) -> Floats | None:
    """Return the places of the customers, (n, 2), relative to the common home of all vehicles.

    None if starts and ends differ, or if places are not known.
    """
    homes = {site for vehicle in problem.vehicles for site in (vehicle.start, vehicle.end)}
    home = homes.pop()
    if problem.points is None or homes or home is None:
        return None
    away: Floats = problem.points[: problem.customers, :2] - problem.points[home, :2]
    return away


def sector_plan(away: Floats, vehicles: int) -> tuple[Ints, Ints]:
    """Return a plan in which each vehicle flies out along one side of a sector and back the other.

    Every sector around the home holds the same number of customers, so that each vehicle serves
    near and far ones. A search that begins with strips of rows finds such plans late or never.

    Parameters
    ----------
    away : (n, 2)
        Places of the customers relative to the home.
    vehicles
        Number of vehicles.
    """
    # Rounded, so that rounding errors do not decide the order of customers in one direction.
    angle = np.round(np.arctan2(away[:, 1], away[:, 0]), 9)
    order = np.argsort(angle, kind='stable')
    gaps = np.diff(angle[order], append=angle[order[0]] + 2 * np.pi)
    order = np.roll(order, -1 - int(gaps.argmax()))
    sectors = np.array_split(order, vehicles)
    routes = [
        np.concatenate([half if k == 0 else half[::-1] for k, half in enumerate(halves)])
        for halves in ([_in_rings(away, h) for h in np.array_split(s, 2)] for s in sectors)
    ]
    lengths = np.array([len(route) for route in routes], np.int32)
    return np.concatenate(routes).astype(np.int32), lengths


def _in_rings(away: Floats, members: Ints) -> Ints:
    """Return customers ring by ring outwards, each ring in the opposite direction of the last.

    Of several widths of the rings, the one with the shortest path is taken. `members` must be
    sorted by angle.
    """
    far = np.sqrt((away[members] ** 2).sum(axis=1))
    spacing = max(float(far.max(initial=0.0)) / max(len(members), 1), 1e-9)
    best, least = members, np.inf
    for width in spacing * 2.0 ** np.arange(0.0, 6.5, 0.5):
        ring = np.floor(np.round(far / width, 9)).astype(np.int64)
        across = np.arange(len(members))
        found = members[np.lexsort((np.where(ring % 2 == 0, across, -across), ring))]
        length = round(float(np.sqrt((np.diff(away[found], axis=0) ** 2).sum(axis=1)).sum()), 6)
        if length < least:
            best, least = found, length
    return best


def by_vehicle(order: Ints, turn: Ints, lengths: Ints) -> Ints:
    """Return routes that were split in the order of `turn` in the order of the vehicles."""
    ends = np.cumsum(lengths[turn])
    parts: dict[int, Ints] = {
        int(r): order[end - lengths[r] : end] for r, end in zip(turn, ends, strict=True)
    }
    return np.concatenate([parts[r] for r in range(len(turn))]).astype(np.int32)


def assigned(tables: Tables, order: Ints) -> tuple[Ints, Ints]:
    """Return a plan in which every vehicle serves only customers that it is allowed to."""
    m = len(tables.first)
    owner = np.zeros(len(order), np.int32)
    append_cheapest(tables, order, owner, np.zeros(m), np.zeros(m, np.int32))
    lengths = np.bincount(owner, minlength=m).astype(np.int32)
    return order[np.argsort(owner[order], kind='stable')], lengths
