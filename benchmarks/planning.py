# SPDX-License-Identifier: Apache-2.0
"""How good plans are: a table of targets and measured values, peers in the same run.

    python benchmarks/planning.py [--part tsplib|mtsplib|grids|start|large|terrain ...]
        [--budget S ...] [--seeds N] [--only TEXT ...] [--no-peers] [--wall] [--json FILE]

At the end it says which targets are met and which are missed.

Instances are read from $ROCSAFE_SHARED/data/mtsp (TSPLIB files and best_known.csv); without them
their parts are left out. Costs are unrounded Euclidean lengths of the longest closed route. One
thread searches; parts `grids` and `large` add the thread that proves. Budgets are seconds of
processor time, of both threads together, so that other work on the machine changes little; with
`--wall` of the clock, as those of the peers and of the other parts always are. The whole table
takes hours: `--budget 1 --seeds 1 --no-peers` takes minutes. `--only` takes parts of the names of
cases: `--part tsplib --budget 60 --only 'rat783 m=3' 'pcb1173 m=5'`.
"""

import argparse
import json
import os
import statistics
import subprocess
import sys
import time
from collections.abc import Iterator
from dataclasses import asdict, dataclass, replace
from pathlib import Path

import numpy as np
from planning_instances import MTSPLIB, TSPLIB, AbsentError, Floats, instance, published
from planning_peers import INSTANT, PEERS
from planning_terrain import over_hills
from rich.console import Console
from rich.table import Table

from rocsafe_planner.solver import Progress, SearchOptions, Solution, one_depot, solve

_START = """
import time
began = time.perf_counter()
import numpy as np
from rocsafe_planner.solver import SearchOptions, one_depot, solve
loaded = time.perf_counter()
points = np.random.default_rng(0).uniform(0, 100, ({n}, 2))
first = []
problem = one_depot(points[1:], points[0], 5)
note = lambda progress: first.append(time.perf_counter())
solve(problem, SearchOptions(proposals=16384, lanes=1, bound_share=0.0), note)
warm = time.perf_counter()
del first[:]
solve(problem, SearchOptions(proposals=16384, lanes=1, bound_share=0.0), note)
peak = next(line for line in open("/proc/self/status") if line.startswith("VmHWM"))
print(warm - began, first[0] - warm, int(peak.split()[1]) / 1024)
"""


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """One line of the table."""

    case: str
    measured: str
    value: float
    target: str
    is_met: bool | None
    remark: str = ''


def searches(
    points: Floats, vehicles: int, budget_s: float, share: float, options: argparse.Namespace
) -> list[Solution]:
    """Return what the solver finds with one searching thread from each seed."""
    problem = one_depot(points[1:], points[0], vehicles)
    chosen = SearchOptions(
        budget_s=budget_s,
        lanes=1,
        threads=1,
        bound_share=share,
        clock=time.monotonic if options.wall else time.process_time,
    )
    return [solve(problem, replace(chosen, seed=seed)) for seed in seeds(options)]


def excess(value: float, reference: float) -> float:
    """Return by how many per cent a value exceeds a reference."""
    return 100.0 * (value / reference - 1.0)


def tsplib(options: argparse.Namespace) -> Iterator[Row]:
    """Compare with the least published values: target 1."""
    for name, fleets in TSPLIB.items():
        points = instance(name)
        for vehicles, budget_s in [(m, s) for m in fleets for s in options.budget]:
            case = f'{name} m={vehicles} {budget_s:g} s'
            if not wanted(case, options):
                continue
            best = published(name, vehicles)
            found = searches(points, vehicles, budget_s, 0.0, options)
            off = excess(statistics.median(one.value for one in found), best)
            yield row(case, 'above published, %', off, _allowed(len(points), budget_s))
            yield from peers(case, points, vehicles, budget_s, (best, options))


def _allowed(size: int, budget_s: float) -> float | None:
    """Return the per cent above the published value that target 1 allows."""
    if budget_s >= 60:
        return 0.0 if size >= 783 else 0.5
    if budget_s >= 10:
        return 1.0 if size <= 2400 else None
    return 2.0 if size <= 800 and budget_s >= 1 else None


def mtsplib(options: argparse.Namespace) -> Iterator[Row]:
    """Compare with the best of the table of planning.md: target 1."""
    for name, fleets in MTSPLIB.items():
        for vehicles, best in fleets.items():
            case = f'{name} m={vehicles} 10 s'
            if not wanted(case, options):
                continue
            points = instance(name)
            found = searches(points, vehicles, 10.0, 0.0, options)
            off = excess(statistics.median(one.value for one in found), best)
            yield row(case, 'above best of table, %', off, 0.005)
            yield from peers(case, points, vehicles, 10.0, (best, options))


def grids(options: argparse.Namespace) -> Iterator[Row]:
    """Prove gaps on survey grids and beat the paper's greedy: targets 2 and 3."""
    for side, vehicles in [(side, m) for side in (20, 50) for m in (3, 5, 10)]:
        points = instance(f'grid{side}')
        for budget_s in options.budget:
            case = f'grid {side}x{side} m={vehicles} {budget_s:g} s'
            if not wanted(case, options):
                continue
            found = searches(points, vehicles, budget_s, 0.15, options)
            gap = 100.0 * statistics.median(solution.gap for solution in found)
            value = statistics.median(solution.value for solution in found)
            limit = (1.5 if budget_s < 10 else 1.25) if vehicles < 10 else 3.5
            is_due = vehicles < 10 or budget_s >= 10
            yield row(case, 'proven gap, %', gap, limit if is_due else None, f'{value:.2f}')
            saved = -excess(value, PEERS["paper's greedy"](points, vehicles, 0.0))
            least = None if budget_s < 10 else 18.0 if side == 20 else 8.5
            yield row(case, "below the paper's greedy, %", saved, least, at_least=True)
            splits = [PEERS[name](points, vehicles, 0.0) for name in INSTANT[1:]]
            yield row(
                case, 'below best survey split, %', -excess(value, min(splits)), 0.0, at_least=True
            )
            bound = max(solution.bound.value for solution in found)
            yield from peers(case, points, vehicles, budget_s, (bound, options))


def start(options: argparse.Namespace) -> Iterator[Row]:
    """Time the start of a new process, and weigh it: target 4."""
    for size in (400, 6000):
        case = f'start n={size}'
        if not wanted(case, options):
            continue
        runs = [_started(size) for _ in seeds(options)]
        warm, first, memory = (statistics.median(column) for column in zip(*runs, strict=True))
        yield row(case, 'imports and first search, s', warm, 1.5 if size == 400 else None)
        yield row(case, 'first plan, s', first, 0.2)
        yield row(case, 'memory, MB', memory, 500.0)


def _started(size: int) -> tuple[float, float, float]:
    """Return seconds of a first search with imports, of a later first plan, and MB, elsewhere."""
    done = subprocess.run(
        [sys.executable, '-c', _START.format(n=size)],
        check=True,
        capture_output=True,
        text=True,
        timeout=600,
    )
    warm, first, memory = (float(word) for word in done.stdout.split())
    return warm, first, memory


def large(options: argparse.Namespace) -> Iterator[Row]:
    """Plan for 10 000 viewpoints and 50 drones: target 4."""
    case = 'grid 100x100 m=50'
    if not wanted(case, options):
        return
    points = instance('grid100')
    seen: list[Progress] = []
    solve(one_depot(points[1:], points[0], 50), SearchOptions(budget_s=60.0), seen.append)
    yield row(case, 'first valid plan, s', seen[0].elapsed_s, 5.0)
    yield row(case, 'above the bound in 60 s, %', 100.0 * seen[-1].gap, 10.0)


def terrain(options: argparse.Namespace) -> Iterator[Row]:
    """Plan over hills, by the clock: a first plan as soon as elsewhere."""
    over_hills(60.0, 0.1)
    for side_m in (100.0, 250.0, 500.0):
        case = f'hills {side_m:g} m'
        if not wanted(case, options):
            continue
        found = [over_hills(side_m, 5.0) for _ in seeds(options)]
        counts, first, gaps = (statistics.median(column) for column in zip(*found, strict=True))
        yield row(case, 'first plan, s', first, 0.2, f'{counts:g} viewpoints')
        yield row(case, 'above the bound in 5 s, %', 100.0 * gaps, None)


def peers(
    case: str,
    points: Floats,
    vehicles: int,
    budget_s: float,
    against: tuple[float, argparse.Namespace],
) -> Iterator[Row]:
    """Run the peers on a case, unless they are not wanted; absent ones say so."""
    reference, options = against
    if options.no_peers:
        return
    for name, run in PEERS.items():
        try:
            value = run(points, vehicles, budget_s)
        except AbsentError as error:
            yield Row(
                case=case,
                measured=name,
                value=float('nan'),
                target='',
                is_met=None,
                remark=str(error),
            )
            continue
        yield row(
            case,
            f'{name}: above the same reference, %',
            excess(value, reference),
            None,
            f'{value:.2f}',
        )


def row(
    case: str,
    measured: str,
    value: float,
    limit: float | None,
    remark: str = '',
    *,
    at_least: bool = False,
) -> Row:
    """Return a line with its target."""
    if limit is None:
        return Row(
            case=case, measured=measured, value=value, target='', is_met=None, remark=remark
        )
    is_met = value >= limit if at_least else value <= limit
    target = f'{">=" if at_least else "<="} {limit:g}'
    return Row(
        case=case, measured=measured, value=value, target=target, is_met=is_met, remark=remark
    )


def wanted(case: str, options: argparse.Namespace) -> bool:
    """Answer whether a case was asked for."""
    return not options.only or any(text in case for text in options.only)


def seeds(options: argparse.Namespace) -> range:
    """Return the seeds of a run."""
    return range(options.seeds)


PARTS = {
    'tsplib': tsplib,
    'mtsplib': mtsplib,
    'grids': grids,
    'start': start,
    'large': large,
    'terrain': terrain,
}


def main() -> int:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--part', nargs='*', choices=PARTS, default=list(PARTS))
    parser.add_argument('--budget', nargs='*', type=float, default=[1.0, 10.0, 60.0])
    parser.add_argument('--seeds', type=int, default=5)
    parser.add_argument('--only', nargs='*', default=[], help='parts of the names of cases')
    parser.add_argument('--no-peers', action='store_true')
    parser.add_argument('--wall', action='store_true', help='budgets of the clock')
    parser.add_argument('--json', type=Path, help='write the lines there too')
    options = parser.parse_args()
    solve(one_depot(np.eye(2), np.zeros(2), 2), SearchOptions(proposals=1))
    lines: list[Row] = []
    for part in options.part:
        try:
            for line in PARTS[part](options):
                print(
                    f'{line.case:28s} {line.measured:38s} {line.value:9.3f} {line.target}',
                    file=sys.stderr,
                    flush=True,
                )
                lines.append(line)
        except AbsentError as error:
            print(f'{part}: {error}', file=sys.stderr)
    if not lines:
        wish = f' that --only names: {", ".join(options.only)}' if options.only else ''
        print(f'no case of {", ".join(options.part)}{wish}', file=sys.stderr)
        return 1
    show(lines, options)
    if options.json:
        options.json.write_text(json.dumps([asdict(line) for line in lines], indent=1))
    return 0


def show(lines: list[Row], options: argparse.Namespace) -> None:
    """Print the lines as a table."""
    table = Table(title=f'Plans, median of {options.seeds} seeds, {os.cpu_count()} cores')
    for heading in ('case', 'measured', 'value', 'target', 'met', 'remark'):
        table.add_column(heading, justify='right' if heading == 'value' else 'left')
    for line in lines:
        met = {True: 'yes', False: 'NO', None: ''}[line.is_met]
        value = f'{line.value:.3f}'
        table.add_row(line.case, line.measured, value, line.target, met, line.remark)
    console = Console(width=130)
    console.print(table)
    missed = [f'{line.case}: {line.measured}' for line in lines if line.is_met is False]
    due = sum(line.is_met is not None for line in lines)
    console.print(f'{due - len(missed)} of {due} targets met, {len(missed)} missed')
    for name in missed:
        console.print(f'missed: {name}', highlight=False)


if __name__ == '__main__':
    sys.exit(main())
