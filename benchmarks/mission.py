# SPDX-License-Identifier: Apache-2.0
"""Measure whole missions: speed against real time, start-up, memory, size of the fleet.

    python benchmarks/mission.py                  # the derailment mission, then fleets of 1 to 30
    python benchmarks/mission.py --fleets 1 3     # other sizes
    python benchmarks/mission.py --repeat 3       # the median of three runs each

Every row is a run of `rocsafe run` as a user starts it. Real-time factor: simulated over wall
seconds of the phase `flying`. Start-up: from the command to the first take-off. Memory: the
largest sum over all processes of the run, once as resident set (shared pages counted in every
process) and once as proportional set (shared pages divided among their users).
"""

import argparse
import json
import math
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass
from pathlib import Path

import yaml
from rich.console import Console
from rich.table import Table

from rocsafe_geo.position import GeoPosition, offset

ROOT = Path(__file__).resolve().parent.parent
DERAILMENT = ROOT / 'config' / 'scenarios' / 'derailment.yaml'
FLEET_SIZES = (1, 3, 10, 30)
DEADLINE_S = 900.0
SAMPLE_S = 0.25
GOAL_FACTOR = 20.0
GOAL_START_UP_S = 8.0
# Homes of a fleet stand on a line south of the region.
HOME_SPACING_M = 15.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """Measured values of one mission.

    `resident_mb` and `proportional_mb` are the largest sums over all processes, MiB.
    """

    real_time_factor: float
    start_up_s: float
    whole_run_s: float
    resident_mb: float
    proportional_mb: float
    processes: int
    images: int


def main() -> int:
    """Run the missions and print the table; 1 if one of them failed."""
    arguments = _arguments()
    rows: list[tuple[str, list[Measurement]]] = []
    with tempfile.TemporaryDirectory(prefix='rocsafe-bench-') as folder:
        missions = {'derailment, a process per RAV': DERAILMENT}
        for size in arguments.fleets:
            missions[f'fleet of {size}'] = _fleet_scenario(size, Path(folder))
        for name, scenario in missions.items():
            runs = [_measure(scenario, Path(folder)) for _ in range(arguments.repeat)]
            rows.append((name, [run for run in runs if run is not None]))
    _print(rows)
    return 0 if all(len(runs) == arguments.repeat for _, runs in rows) else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description='Measure whole missions.')
    parser.add_argument('--repeat', type=int, default=1, help='runs of each mission [1]')
    parser.add_argument(
        '--fleets', type=int, nargs='*', default=FLEET_SIZES, help='sizes of fleets [1 3 10 30]'
    )
    return parser.parse_args()


def _fleet_scenario(size: int, folder: Path) -> Path:
    """Write the derailment with `size` RAVs flown by one process; return the file."""
    scenario = yaml.safe_load(DERAILMENT.read_text())
    south_west = GeoPosition(latitude_deg=53.2785, longitude_deg=-9.0660)
    homes = [offset(south_west, HOME_SPACING_M * number, 0.0) for number in range(size)]
    scenario['name'] = f'fleet-{size}'
    scenario['simulation']['processes'] = 'fleet'
    scenario['vehicles'] = [
        {
            'name': f'rav{number}',
            'home': [home.latitude_deg, home.longitude_deg],
            'cruise_speed_mps': 8.0,
        }
        for number, home in enumerate(homes, 1)
    ]
    path = folder / f'fleet-{size}.yaml'
    path.write_text(yaml.safe_dump(scenario))
    return path


def _measure(scenario: Path, folder: Path) -> Measurement | None:
    """Fly `scenario` once; None, with its last words, if that did not work."""
    out = folder / 'run'
    shutil.rmtree(out, ignore_errors=True)
    started = time.monotonic()
    process = subprocess.Popen(
        ['rocsafe', 'run', str(scenario), '--out', str(out)],
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    )
    memory = _watch(process, started + DEADLINE_S)
    whole_run_s = time.monotonic() - started
    words = process.communicate()[0]
    if process.returncode != 0:
        print(f'{scenario.name}: exit code {process.returncode}\n{words}', file=sys.stderr)
        return None
    summary = json.loads(next(out.rglob('summary.json')).read_text())
    run_info = json.loads(next(out.rglob('run.json')).read_text())
    # The run's own clock starts when Python has read the program.
    before_s = whole_run_s - run_info['wall_time_s']
    return Measurement(
        real_time_factor=summary['real_time_factor'],
        start_up_s=before_s + summary['start_up_s'],
        whole_run_s=whole_run_s,
        resident_mb=memory[0],
        proportional_mb=memory[1],
        processes=int(memory[2]),
        images=summary['images_stored'],
    )


def _watch(process: 'subprocess.Popen[str]', end: float) -> tuple[float, float, float]:
    """Return the largest resident, proportional (MiB) and process count until it ends."""
    largest = (0.0, 0.0, 0.0)
    while process.poll() is None:
        if time.monotonic() > end:
            process.kill()
            break
        now = _memory(_family(process.pid))
        largest = (max(largest[0], now[0]), max(largest[1], now[1]), max(largest[2], now[2]))
        time.sleep(SAMPLE_S)
    return largest


def _family(root: int) -> list[int]:
    """Return the process ids of `root` and all its descendants."""
    parents: dict[int, list[int]] = {}
    for entry in os.listdir('/proc'):  # noqa: PTH208 - only names are wanted
        if entry.isdigit() and (stat := _text(f'/proc/{entry}/stat')):
            parent = int(stat.rsplit(')', 1)[1].split()[1])
            parents.setdefault(parent, []).append(int(entry))
    family = [root]
    for pid in family:
        family.extend(parents.get(pid, []))
    return family


def _memory(pids: list[int]) -> tuple[float, float, float]:
    resident_kb = proportional_kb = 0
    for pid in pids:
        for line in _text(f'/proc/{pid}/smaps_rollup').splitlines():
            if line.startswith('Rss:'):
                resident_kb += int(line.split()[1])
            elif line.startswith('Pss:'):
                proportional_kb += int(line.split()[1])
    return resident_kb / 1024.0, proportional_kb / 1024.0, float(len(pids))


def _text(path: str) -> str:
    """Return the text of a file of /proc, empty if the process has gone."""
    try:
        return Path(path).read_text()
    except OSError:
        return ''


def _print(rows: list[tuple[str, list[Measurement]]]) -> None:
    table = Table(title=f'Missions, median of the runs, {os.cpu_count()} cores')
    table.add_column('mission')
    for heading in (
        f'real time x (goal {GOAL_FACTOR:g})',
        f'start-up s (goal {GOAL_START_UP_S:g})',
        'whole run s',
        'resident MiB',
        'proportional MiB',
        'processes',
        'images',
    ):
        table.add_column(heading, justify='right')
    for name, runs in rows:
        table.add_row(name, *_cells(runs))
    Console(width=150).print(table)


def _cells(runs: list[Measurement]) -> list[str]:
    def middle(field: str) -> float:
        values = [getattr(run, field) for run in runs]
        return statistics.median(values) if values else math.nan

    return [
        f'{middle("real_time_factor"):.1f}',
        f'{middle("start_up_s"):.1f}',
        f'{middle("whole_run_s"):.1f}',
        f'{middle("resident_mb"):.0f}',
        f'{middle("proportional_mb"):.0f}',
        f'{middle("processes"):.0f}',
        f'{middle("images"):.0f}',
    ]


if __name__ == '__main__':
    sys.exit(main())
