# SPDX-License-Identifier: Apache-2.0
"""Routes of a ground vehicle: how good, how fast, against peers.

    python benchmarks/ground.py                     everything that needs no run: minutes
    python benchmarks/ground.py --part derailment --run runs/derailment-...

Parts: `exact` (brute force on small grids), `routes` (300 x 300), `large` (1000 x 1000), `tours`,
`replan`; on the map of a run `drive_replan` (the rest of a drive after a blocked place, all of it)
and `derailment` (draws of starts and goals, doses in the true field).

Peers on the same grids: scikit-image's MCP_Geometric (where it is installed), a weighted sum of
time and dose with 8 weights, of which the fastest path within the budget counts, and the radiation
cost-map layer of Wright et al. (Front. Robot. AI 9:862067, 2022), as its paper states: cost is
proportional to dose rate between two levels, the path has the least sum of length and cost, and no
budget is known to it.
"""

import argparse
import heapq
import json
import math
import statistics
import sys
import time
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveRequest
from rocsafe_ground.drive.ground_map import GroundMap, MapFiles, MapReader, read_ground_map
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.errors import GroundError
from rocsafe_ground.evidence.evidence_point import EvidencePoint
from rocsafe_ground.route.constrained import RouteSearch, SearchEffort
from rocsafe_ground.route.edges import Edges, Searcher, edges_of
from rocsafe_ground.tour.tour import TourSearch
from rocsafe_ground.tour.trip import Budgets, TourPoint

Figures = dict[str, Any]
AMPLE = 1e12
# Proven gap that is wanted of routes on 1000 x 1000 cells.
LARGE_GAP = 0.005


def smooth(generator: np.random.Generator, side: int, length: int) -> FloatArray:
    """Return a random field of 0 to 1 that varies over `length` cells."""
    from scipy.ndimage import gaussian_filter

    field = gaussian_filter(generator.normal(size=(side, side)), length, mode='wrap')
    return np.asarray((field - field.min()) / np.ptp(field))


def terrain(side: int, seed: int) -> tuple[BoolArray, FloatArray, FloatArray]:
    """Return free cells, slowness and dose rates: speeds of 0.45 to 1.5 m/s, two sources."""
    generator = np.random.default_rng([seed, side])
    speed = 0.45 + 1.05 * smooth(generator, side, 8)
    is_free = smooth(generator, side, 4) > 0.22
    east, north = np.meshgrid(np.arange(side), np.arange(side))
    rates = np.full((side, side), 0.1)
    for _ in range(2):
        x, y = generator.uniform(0.3, 0.7, 2) * side
        rates += 10.0 ** generator.uniform(4, 5.5) / ((east - x) ** 2 + (north - y) ** 2 + 1.0)
    return is_free, 1.0 / speed, rates


def ends(edges: Edges, generator: np.random.Generator) -> tuple[int, int] | None:
    """Return a start in the west and a goal in the east that are connected."""
    rows, columns = edges.shape
    searcher = Searcher(edges)
    for _ in range(20):
        row = generator.integers(0, rows, 2)
        start = int(row[0] * columns + generator.integers(0, columns // 8))
        goal = int(row[1] * columns + columns - 1 - generator.integers(0, columns // 8))
        if math.isfinite(searcher.tree(start, (1.0, 0.0, 0.0), {goal}).costs[goal]):
            return start, goal
    return None


def brute_force(edges: Edges, start: int, goal: int, budget: float) -> float:
    """Return the time of the best path within a budget: all labels, none pruned by bounds."""
    kept: dict[int, float] = {}
    heap = [(0.0, 0.0, start)]
    while heap:
        seconds, dose, cell = heapq.heappop(heap)
        if dose >= kept.get(cell, math.inf):
            continue
        kept[cell] = dose
        if cell == goal:
            return seconds
        for m, offset in enumerate(edges.offsets.tolist()):
            total = dose + edges.doses_usv[cell, m]
            if total <= budget:
                heapq.heappush(heap, (seconds + edges.times_s[cell, m], total, cell + offset))
    return math.inf


def budget_of(search: RouteSearch, generator: np.random.Generator) -> float:
    """Return a budget between the doses of the cleanest and the fastest path."""
    low, high = search.cleanest.dose_usv, search.fastest.dose_usv
    return float(low * (high / low) ** generator.uniform(0.02, 0.98)) * (1.0 + 1e-9)


def part_exact(count: int) -> Figures:
    """Compare with brute force on small grids."""
    equal, largest = 0, 0.0
    for seed in range(count):
        generator = np.random.default_rng([seed, 1])
        edges = edges_of(*terrain(12, seed), 1.0)
        both = ends(edges, generator)
        if both is None:
            equal += 1
            continue
        search = RouteSearch(Searcher(edges), *both)
        budget = budget_of(search, generator)
        found = search.within(budget).path.time_s
        truth = brute_force(edges, *both, budget * (1.0 + 1e-9))
        largest = max(largest, abs(found / truth - 1.0))
        equal += int(abs(found / truth - 1.0) < 1e-6)
    return {'grids': count, 'equal': equal, 'largest_difference': float(largest)}


def timed(work: Callable[[], Any]) -> tuple[float, Any]:
    """Return processor seconds of this process and the result."""
    begin = time.process_time()
    result = work()
    return time.process_time() - begin, result


def part_routes(count: int, side: int, effort: SearchEffort) -> Figures:
    """Time routes on random fields and budgets, with the peers."""
    seconds, gaps, labels = [], [], []
    peers: dict[str, list[float]] = {'weighted_sum': [], 'radiation_layer': []}
    kept = {'weighted_sum': 0, 'radiation_layer': 0}
    mcp: list[float] = []
    for seed in range(count):
        generator = np.random.default_rng([seed, 2])
        grid = terrain(side, seed)
        edges = edges_of(*grid, 1.0)
        both = ends(edges, generator)
        if both is None:
            continue
        search = RouteSearch(Searcher(edges), *both)
        budget = budget_of(search, generator)

        def work(edges: Edges = edges, both: Any = both, budget: float = budget) -> Any:
            return RouteSearch(Searcher(edges), *both).within(budget, effort)

        spent, found = timed(work)
        seconds.append(spent)
        gaps.append(found.gap_fraction)
        labels.append(found.label_count)
        for name, peer in (('weighted_sum', weighted_sum), ('radiation_layer', radiation_layer)):
            answer = peer(edges, grid, both, budget)
            if answer is not None:
                kept[name] += 1
                peers[name].append(answer / found.path.time_s - 1.0)
        mcp.extend(mcp_seconds(grid, both))
    return {
        'routes': len(seconds),
        'cpu_s_median': statistics.median(seconds),
        'cpu_s_p95': float(np.quantile(seconds, 0.95)),
        'cpu_s_worst': max(seconds),
        'gap_worst': max(gaps),
        'proven_optimal': sum(gap == 0.0 for gap in gaps),
        'labels_worst': max(labels),
        'peers_within_budget': kept,
        'peers_time_above_ours_mean': {
            name: statistics.fmean(values) if values else None for name, values in peers.items()
        },
        'skimage_mcp_one_path_s_median': statistics.median(mcp) if mcp else None,
    }


def weighted_sum(edges: Edges, _grid: Any, both: tuple[int, int], budget: float) -> float | None:
    """Return the time of the fastest path within the budget that 8 weights find."""
    searcher = Searcher(edges)
    times = []
    for price in np.geomspace(1e-3, 1e3, 8):
        path = searcher.tree(both[0], (1.0, float(price), 0.0), {both[1]}).path_to(both[1])
        found = edges.path_of(path)
        if found.dose_usv <= budget:
            times.append(found.time_s)
    return min(times) if times else None


def radiation_layer(edges: Edges, grid: Any, both: tuple[int, int], budget: float) -> float | None:
    """Return the time of the path of the cost-map layer, None if it is not within the budget."""
    is_free, _, rates = grid
    low, high = float(rates[is_free].min()), float(rates[is_free].max())
    # 0 to 252 between the levels, as in a cost map of Nav2, plus the neutral cost of 50.
    cost = 50.0 + 252.0 * np.clip((rates - low) / (high - low), 0.0, 1.0)
    layer = edges_of(is_free, cost, np.zeros_like(cost), 1.0)
    path = Searcher(layer).tree(both[0], (1.0, 0.0, 0.0), {both[1]}).path_to(both[1])
    found = edges.path_of(path)
    return found.time_s if found.dose_usv <= budget else None


def mcp_seconds(grid: Any, both: tuple[int, int]) -> list[float]:
    """Return the time of one least-cost path by scikit-image, empty where it is not installed."""
    try:
        from skimage.graph import MCP_Geometric
    except ImportError:
        return []
    is_free, slowness, _ = grid
    columns = is_free.shape[1]
    costs = np.where(is_free, slowness, -1.0)

    def work() -> None:
        search = MCP_Geometric(costs)
        search.find_costs([divmod(both[0], columns)], [divmod(both[1], columns)])

    return [timed(work)[0]]


def part_tours(count: int, points: int, side: int) -> Figures:
    """Time tours of 12 points; compare those of 6 with all orders and exact ways."""
    seconds, gaps, curves = [], [], []
    for seed in range(count):
        search, budget = tour_case(seed, points, side)
        spent, trip = timed(partial(search.best, budget))
        seconds.append(spent)
        gaps.append(trip.gap_fraction)
        edges = edges_of(*terrain(side, seed), 1.0)
        both = ends(edges, np.random.default_rng([seed, 3]))
        if both:
            route = RouteSearch(Searcher(edges), *both)
            curves.append(timed(partial(route.trade_off, 8))[0])
    return {
        'tours': count,
        'points': points,
        'cpu_s_median': statistics.median(seconds),
        'cpu_s_worst': max(seconds),
        'gap_median': statistics.median(gaps),
        'gap_worst': max(gaps),
        'curve_of_8_cpu_s_worst': max(curves, default=None),
    }


def tour_case(seed: int, points: int, side: int) -> tuple[TourSearch, Budgets]:
    """Return a fresh search through random points, and a budget that all of them fit."""
    generator = np.random.default_rng([seed, 4])
    edges = edges_of(*terrain(side, seed), 1.0)
    searcher = Searcher(edges)
    start = ends(edges, generator)
    if start is None:
        raise ValueError(f'seed {seed}: no two sides are connected')
    reached = np.flatnonzero(np.isfinite(searcher.tree(start[0], (1.0, 0.0, 0.0)).costs))
    cells = generator.choice(reached, points, replace=False)
    stops = [TourPoint(cell=int(cell), dwell_s=30.0) for cell in cells]
    probe = TourSearch(searcher, start[0], stops)
    everything = (1 << points) - 1
    low, high = probe.cleanest_usv(everything), probe.fastest(everything).dose_usv
    budget = low * (high / low) ** generator.uniform(0.1, 0.9)
    return TourSearch(searcher, start[0], stops), Budgets(dose_usv=budget, time_s=AMPLE)


def part_replan(count: int, side: int) -> Figures:
    """Time a new way after a cell on the way is blocked."""
    seconds = []
    for seed in range(count):
        generator = np.random.default_rng([seed, 5])
        grid = terrain(side, seed)
        edges = edges_of(*grid, 1.0)
        both = ends(edges, generator)
        if both is None:
            continue
        first = RouteSearch(Searcher(edges), *both)
        budget = budget_of(first, generator)
        path = first.within(budget).path.cells
        grid[0].ravel()[path[len(path) // 2]] = False

        def work(grid: Any = grid, both: Any = both, budget: float = budget) -> Any:
            is_free, slowness, rates = grid
            search = RouteSearch(Searcher(edges_of(is_free, slowness, rates, 1.0)), *both)
            return search.within(max(budget, search.cleanest.dose_usv * (1 + 1e-9)),
                                 SearchEffort(is_exact=False, prices=()))  # fmt: skip

        seconds.append(timed(work)[0])
    return {
        'replans': len(seconds),
        'cpu_s_median': statistics.median(seconds),
        'cpu_s_p95': float(np.quantile(seconds, 0.95)),
    }


def part_drive_replan(run: Path, count: int) -> Figures:
    """Plan the rest of a drive anew: something stands 4 m ahead, at drawn places of its way."""
    reader, files, vehicle = MapReader(), MapFiles(folder=run), GroundVehicle()
    ground = reader.read(files, vehicle, 0.5, 1e5)
    near = three_points(ground)
    request = DriveRequest(start=TENT, evidence=near, dose_budget_usv=80.0, curve_points=0)
    track = plan_drive(request, ground).track[:, :2]
    generator = np.random.default_rng([count, 7])
    seconds, read, refused = [], [], 0
    for _ in range(count):
        at = int(generator.integers(len(track) // 10, len(track) // 2))
        east, north = track[at + 8].tolist()
        again = replace(
            request,
            start=ground.grid.position_at(*track[at].tolist()),
            end=TENT,
            evidence=near[int(generator.integers(3)) :],
            blocked=tuple(ground.grid.position_at(east + k, north) for k in (-0.3, 0.0, 0.3)),
        )
        try:
            seconds.append(timed(partial(plan_drive, again, ground))[0])
        except GroundError:
            refused += 1
        # The ground is known, the dose rates are read anew.
        read.append(timed(partial(reader.read, files, vehicle, 0.5, 1e5))[0])
    return {
        'replans': len(seconds),
        'refused': refused,
        'cpu_s_median': statistics.median(seconds),
        'cpu_s_p95': float(np.quantile(seconds, 0.95)),
        'cpu_s_of_new_dose_rates_median': statistics.median(read),
    }


# The yellow tent beside the track of the scene `derailment`, and its source.
TENT = GeoPosition(53.279695, -9.063585)
WRECK = GeoPosition(53.27985, -9.06330)
TRUE_RATE_USVH, TRUE_UP_M = 90_000.0, 1.0


def part_derailment(run: Path, count: int) -> Figures:
    """Plan on the estimated map, take the dose in the true field."""
    vehicle = GroundVehicle()
    ground = read_ground_map(MapFiles(folder=run), vehicle, 0.5, 1e5)
    near = three_points(ground)
    first = comparison(ground, TENT, near)
    draws = [one for seed in range(count) if (one := drawn_case(ground, seed)) is not None]
    return {
        'tent_to_three_points': first,
        'draws': len(draws),
        'median_times_less_dose': statistics.median(one['times_less_dose'] for one in draws),
        'median_more_time': statistics.median(one['more_time'] for one in draws),
        'at_most_5_percent_more_time': {
            'draws_with_10_times_less_dose': sum(one['times_less_dose'] >= 10.0 for one in draws)
        },
    }


def three_points(ground: GroundMap) -> tuple[EvidencePoint, ...]:
    """Return three marks 6, 10 and 14 m from the source, in three directions."""
    east, north = ground.grid.enu_of(WRECK)
    marks = ((6.0, -100.0), (10.0, 200.0), (14.0, -30.0))
    return tuple(
        EvidencePoint(
            id=f'{distance:g} m', dwell_s=30.0,
            position=ground.grid.position_at(
                east + distance * math.cos(math.radians(angle)),
                north + distance * math.sin(math.radians(angle)),
            ),
        )
        for distance, angle in marks
    )  # fmt: skip


def drawn_case(ground: GroundMap, seed: int) -> Figures | None:
    """Return the comparison for a start and a goal drawn on free ground, None if not connected."""
    generator = np.random.default_rng([seed, 6])
    free = np.flatnonzero(ground.is_free)
    places = ground.grid.place_of(generator.choice(free, 2))
    start, goal = (ground.grid.position_at(*place) for place in places.tolist())
    try:
        mark = EvidencePoint(id='goal', position=goal, dwell_s=0.0)
        return comparison(ground, start, (mark,))
    except GroundError:
        return None


def comparison(
    ground: GroundMap, start: GeoPosition, evidence: tuple[EvidencePoint, ...]
) -> Figures:
    """Return how much less dose a drive takes with at most 5 % more time than the fastest."""

    def planned(budget: float) -> DrivePlan:
        return plan_drive(
            DriveRequest(start=start, evidence=evidence, dose_budget_usv=budget, curve_points=0),
            ground,
        )

    fastest = planned(AMPLE)
    low, high = 0.0, fastest.forecast.upper_usv * 1.01
    best = fastest
    for _ in range(7):
        middle = 0.5 * (low + high)
        try:
            plan = planned(middle)
        except GroundError:
            low = middle
            continue
        if plan.left_out or plan.time_s > 1.05 * fastest.time_s:
            low = middle
        else:
            high, best = middle, plan
    ours, theirs = transit_usv(best, ground), transit_usv(fastest, ground)
    return {
        'times_less_dose': theirs / max(ours, 1e-12),
        'more_time': best.time_s / fastest.time_s - 1.0,
        'transit_usv': ours,
        'fastest_transit_usv': theirs,
        'dwell_usv': best.standing_usv,
        'gap': best.gap_fraction,
    }


def transit_usv(plan: DrivePlan, ground: GroundMap) -> float:
    """Return the dose of driving in the true field, dwells apart."""
    east, north = ground.grid.enu_of(WRECK)
    places, seconds = plan.track[:, :2], plan.track[:, 2].copy()
    squares = (places[:, 0] - east) ** 2 + (places[:, 1] - north) ** 2 + (TRUE_UP_M - 1.0) ** 2
    rates = TRUE_RATE_USVH / np.maximum(squares, 0.01)
    steps = np.diff(seconds)
    # A dwell is a step in time at one place.
    moved = np.hypot(*(places[1:] - places[:-1]).T) > 1e-9
    pairs = 0.5 * (rates[1:] + rates[:-1])
    limit = 10.0 * np.median(steps[moved])
    return float((pairs * np.minimum(steps, limit))[moved].sum() / 3600.0)


def main() -> int:
    """Run the parts that were asked for and print their figures as JSON."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parts = ('exact', 'routes', 'large', 'tours', 'replan', 'drive_replan', 'derailment')
    parser.add_argument('--part', choices=parts, action='append')
    parser.add_argument('--count', type=int, default=0, help='cases of each part')
    parser.add_argument('--run', type=Path, help='run directory of the derailment')
    options = parser.parse_args()
    chosen = options.part or parts[:-2]
    count = options.count
    works: dict[str, Callable[[], Figures]] = {
        'exact': lambda: part_exact(count or 1000),
        'routes': lambda: part_routes(count or 200, 300, SearchEffort()),
        'large': lambda: part_routes(
            count or 10, 1000, SearchEffort(enough_gap=LARGE_GAP, is_exact=False)
        ),
        'tours': lambda: part_tours(count or 10, 12, 300),
        'replan': lambda: part_replan(count or 50, 300),
        'drive_replan': lambda: part_drive_replan(options.run, count or 40),
        'derailment': lambda: part_derailment(options.run, count or 200),
    }
    # Compile before anything is timed.
    part_exact(2)
    part_routes(1, 40, SearchEffort())
    part_tours(1, 3, 40)
    for name in chosen:
        sys.stdout.write(json.dumps({name: works[name]()}, indent=1) + '\n')
        sys.stdout.flush()
    return 0


if __name__ == '__main__':
    raise SystemExit(main())
