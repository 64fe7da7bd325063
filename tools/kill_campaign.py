#!/usr/bin/env python3
# SPDX-License-Identifier: Apache-2.0
"""Kill processes of small missions at random, run after run, and judge each.

    python tools/kill_campaign.py --minutes 5 --results runs/kills.jsonl
    python tools/kill_campaign.py --scenario test/system/agents.yaml --results runs/agents.jsonl

Some processes are only stopped, for less or for longer than a vehicle may be silent. Each line of
the results is a run with its seed, its blows and its faults, none if all is well. A campaign goes
on where the file ends, so it may be spread over days. The exit code is 1 if a run of this part has
a fault.
"""

import argparse
import hashlib
import json
import math
import os
import random
import re
import shutil
import signal
import subprocess
import sys
import time
from collections import Counter
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from threading import Event, Thread
from typing import Any

SCENARIO = Path(__file__).parents[1] / 'test' / 'system' / 'small.yaml'
ORCHESTRATOR = 'orchestrator'
# A mission that waits for a process that stands still gives up after this time.
CONFIG = '/**/orchestrator:\n  ros__parameters:\n    stall_timeout_s: 10.0\n'
BLOWS_A_RUN = (3, 9)
# Choices from here on are of the orchestrator.
ORCHESTRATOR_FROM = 0.97
# A blow comes at most so long after the one before, s.
LONGEST_S = 3.0
# A process that was stopped goes on after this time, s: short times are as likely as long ones.
STANDSTILL_S = (0.05, 20.0)
DEADLINE_S = 240.0
# DDS takes a killed vehicle for alive for 20 s, and `fleet_verbs` stays 5 s longer than the last.
ORPHAN_S = 40.0
# In which a process that is ended writes where its threads are, s.
STACKS_S = 5.0
POLL_S = 0.02
# Products of a mission that is complete.
PRODUCTS = (
    'scenario.yaml', 'run.json', 'plan.json', 'mosaic.tif', 'mission.mcap', 'readings.csv',
    'summary.json', 'report.html',
)  # fmt: skip
BLOWS = {'kill': signal.SIGKILL, 'stop': signal.SIGSTOP, 'terminate': signal.SIGTERM}


@dataclass(frozen=True, slots=True, kw_only=True)
class Blow:
    """A signal to a process, `after_s` after the blow before; `for_s` is how long it is stopped.

    `choice`, 0 to 1, chooses among the processes that are running then; `target` is the one that
    was hit, empty if none was running.
    """

    kind: str
    choice: float
    after_s: float
    for_s: float = 0.0
    target: str = ''


@dataclass(slots=True, kw_only=True)
class Result:
    """One run: its blows, and what is wrong with its end."""

    seed: int
    blows: list[Blow]
    code: int | None = None
    outcome: str = ''
    text: str = ''
    wall_s: float = 0.0
    acknowledged: int = 0
    faults: list[str] = field(default_factory=list)

    @property
    def kills(self) -> int:
        """Number of blows that hit a process."""
        return sum(bool(blow.target) for blow in self.blows)


def drawn_blows(seed: int) -> list[Blow]:
    """Return the blows of a run."""
    chance = random.Random(seed)  # noqa: S311 - no secret
    blows = []
    for _ in range(chance.randint(*BLOWS_A_RUN)):
        kind = chance.choices(tuple(BLOWS), (6, 2, 1))[0]
        blows.append(
            Blow(
                kind=kind,
                choice=chance.random(),
                after_s=round(chance.uniform(0.0, LONGEST_S), 3),
                for_s=_standstill_s(chance) if kind == 'stop' else 0.0,
            )
        )
    return blows


def _standstill_s(chance: random.Random) -> float:
    shortest_s, longest_s = STANDSTILL_S
    return round(shortest_s * math.pow(longest_s / shortest_s, chance.random()), 3)


class Run:
    """One mission in a folder of its own."""

    def __init__(self, rocsafe: str, scenario: Path, folder: Path) -> None:
        self._rocsafe = rocsafe
        self._folder = folder
        folder.mkdir(parents=True)
        config = folder / 'config.yaml'
        config.write_text(CONFIG)
        self._output = folder / 'output.txt'
        with self._output.open('wb') as output:
            self.process = subprocess.Popen(
                [rocsafe, 'run', scenario, '--out', folder / 'runs', '--config', config,
                 '--speed', '25'],
                stdin=subprocess.DEVNULL, stdout=output, stderr=subprocess.STDOUT,
                start_new_session=True, env={**os.environ, 'PYTHONFAULTHANDLER': '1'},
            )  # fmt: skip

    def end(self) -> None:
        """End a mission that does not end; its output and its logs then say where each waits."""
        os.killpg(self.process.pid, signal.SIGABRT)
        with suppress(subprocess.TimeoutExpired):
            self.process.wait(STACKS_S)
        with suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()

    @property
    def path(self) -> Path | None:
        """The run directory, None before it is made."""
        return next((self._folder / 'runs').glob('*-*'), None)

    def text_of(self, name: str) -> str:
        """Return a file of the run directory, empty if it is not there."""
        try:
            return (self.path / name).read_text(errors='replace') if self.path else ''
        except OSError:
            return ''

    def output(self) -> str:
        """Return what the command printed."""
        return self._output.read_text(errors='replace')

    def running(self) -> dict[str, int]:
        """Return the processes that are running, by name."""
        pattern = re.compile(r' (\w+): started, process (\d+)')
        noted = dict(pattern.findall(self.text_of('logs/orchestrator.log')))
        living = self.living()
        found = {name: int(pid) for name, pid in noted.items() if int(pid) in living}
        return found | ({ORCHESTRATOR: self.process.pid} if self.process.poll() is None else {})

    def living(self) -> list[int]:
        """Return every process that belongs to the run: its folder is in the command line."""
        mark = os.fsencode(self._folder)
        return [pid for pid in _pids() if pid != self.process.pid and mark in _command(pid)]

    def wait_for_processes(self, end_s: float) -> None:
        """Wait until a process is started, or the mission has ended."""
        while len(self.running()) == 1 and time.monotonic() < end_s:
            time.sleep(POLL_S)

    def report(self) -> 'subprocess.CompletedProcess[str]':
        """Make the products again."""
        command = [self._rocsafe, 'report', str(self.path)]
        return subprocess.run(
            command, capture_output=True, text=True, timeout=DEADLINE_S, check=False
        )

    def images(self) -> dict[str, str]:
        """Return the photographs of the manifest, each with the hash of its file."""
        lines = self.text_of('images/manifest.jsonl').splitlines(keepends=True)
        records = [json.loads(line) for line in lines if line.endswith('\n')]
        return {record['shot_id']: record['stored_sha256'] for record in records}

    def missing(self) -> set[int]:
        """Return the viewpoints of the first plan that no photograph of the manifest shows."""
        plan = json.loads(self.text_of('plan.json'))
        planned = {view['id'] for route in plan['routes'] for view in route['viewpoints']}
        records = (json.loads(self.text_of(f'images/{name}.json')) for name in self.images())
        return planned - {record['viewpoint_id'] for record in records}

    def files(self) -> dict[str, str]:
        """Return the hash of each photograph that lies in the store."""
        paths = (self.path / 'images').glob('*.jpg') if self.path else ()
        return {path.stem: hashlib.sha256(path.read_bytes()).hexdigest() for path in paths}


def _pids() -> Iterator[int]:
    return (int(path.name) for path in Path('/proc').glob('[0-9]*'))


def _command(pid: int) -> bytes:
    """Return the command line of a process, empty for one that has ended."""
    try:
        return Path(f'/proc/{pid}/cmdline').read_bytes()
    except OSError:
        return b''


def strike(run: Run, blow: Blow) -> str:
    """Carry out a blow and return whom it hit, empty if nobody."""
    running = run.running()
    # The orchestrator ends the run whatever hits it, so it is hit seldom.
    names = sorted(running.keys() - {ORCHESTRATOR})
    if blow.choice >= ORCHESTRATOR_FROM:
        names = [ORCHESTRATOR] if ORCHESTRATOR in running else []
    if not names:
        return ''
    target = names[int(blow.choice / ORCHESTRATOR_FROM * len(names)) % len(names)]
    try:
        os.kill(running[target], BLOWS[blow.kind])
        if blow.kind == 'stop':
            time.sleep(blow.for_s)
            os.kill(running[target], signal.SIGCONT)
    except ProcessLookupError:
        return ''
    return target


def flown(rocsafe: str, scenario: Path, folder: Path, seed: int, receipts: 'Receipts') -> Result:
    """Fly a mission under blows and judge it."""
    result, begin = Result(seed=seed, blows=drawn_blows(seed)), time.monotonic()
    receipts.forget()
    run = Run(rocsafe, scenario, folder)
    try:
        if result.blows[0].choice < ORCHESTRATOR_FROM:
            run.wait_for_processes(begin + DEADLINE_S)
        result.blows = [_struck(run, blow) for blow in result.blows]
        result.code = run.process.wait(max(1.0, begin + DEADLINE_S - time.monotonic()))
    except subprocess.TimeoutExpired:
        result.faults.append(f'not ended within {DEADLINE_S:g} s')
        run.end()
    result.wall_s = round(time.monotonic() - begin, 1)
    was_killed = any(blow.target == ORCHESTRATOR and blow.kind == 'kill' for blow in result.blows)
    result.acknowledged = len(receipts.stored)
    result.faults += judged(run, result, receipts.stored, was_killed=was_killed)
    return result


def _struck(run: Run, blow: Blow) -> Blow:
    end = time.monotonic() + blow.after_s
    while time.monotonic() < end and run.process.poll() is None:
        time.sleep(POLL_S)
    return replace(blow, target=strike(run, blow))


def judged(run: Run, result: Result, stored: set[str], *, was_killed: bool) -> list[str]:
    """Return what is wrong with a run that has ended."""
    faults = [*_orphans(run)]
    if was_killed and run.text_of('run.json'):
        done = run.report()
        if done.returncode or 'Traceback' in done.stderr:
            faults.append(f'no report of the killed run: {done.stderr[-300:]}')
    faults += _tracebacks(run)
    if run.text_of('logs/end.log'):
        faults.append('ended by its deadline: logs/end.log tells what it waited for')
    images, files = run.images(), run.files()
    lost = {name for name in stored if name not in images or images[name] != files.get(name)}
    if lost:
        faults.append(f'acknowledged photographs lost: {sorted(lost)}')
    summary = json.loads(run.text_of('summary.json') or '{}')
    result.outcome = summary.get('outcome', '')
    result.text = json.loads(run.text_of('run.json') or '{}').get('outcome_text', '')
    if result.code == 0:
        missing = [name for name in PRODUCTS if not run.text_of(name)]
        faults += [f'complete without {name}' for name in missing]
        if left := run.missing():
            faults.append(f'complete without photographs of viewpoints {sorted(left)}')
    elif result.outcome == 'complete':
        faults.append(f'exit code {result.code}, but the summary says complete')
    elif run.text_of('run.json') and not result.outcome and 'products' not in run.output():
        faults.append(f'no summary, and no word why: {run.output()[-300:]}')
    return faults


def _orphans(run: Run) -> Iterator[str]:
    end = time.monotonic() + ORPHAN_S
    while (left := run.living()) and time.monotonic() < end:
        time.sleep(POLL_S)
    for pid in left:
        yield f'orphan {pid}: {Path(f"/proc/{pid}/comm").read_text().strip()}'
        os.kill(pid, signal.SIGKILL)


def _tracebacks(run: Run) -> Iterator[str]:
    texts = {'output': run.output()}
    if run.path is not None:
        texts |= {
            path.name: path.read_text(errors='replace') for path in run.path.glob('logs/*.log')
        }
    for name, text in texts.items():
        if 'Traceback' in text:
            yield f'traceback in {name}: {text[text.index("Traceback") :][-400:]}'


class Receipts:
    """Hears which photographs are acknowledged, as a vehicle does."""

    def __init__(self, node: Any) -> None:
        from rocsafe_ros.interfaces import topics

        self.stored: set[str] = set()
        topics.create_subscription(node, topics.RECEIPTS, self._on_receipt)

    def forget(self) -> None:
        """Begin a new run."""
        self.stored = set()

    def _on_receipt(self, receipt: Any) -> None:
        if receipt.status != receipt.REJECTED:
            self.stored.add(receipt.shot_id)


@contextmanager
def listening() -> Iterator[Receipts]:
    """Spin a node that listens, beside the campaign."""
    import rclpy  # noqa: TID251 - it listens as a vehicle does
    from rclpy.node import Node  # noqa: TID251

    from rocsafe_ros.domain.network import bind_interfaces

    bind_interfaces(os.environ)
    rclpy.init()
    node, is_over = Node('kill_campaign'), Event()

    def spin() -> None:
        while not is_over.is_set():
            rclpy.spin_once(node, timeout_sec=0.1)

    thread = Thread(target=spin)
    thread.start()
    try:
        yield Receipts(node)
    finally:
        is_over.set()
        thread.join()
        rclpy.try_shutdown()


def campaign(
    scenario: Path, results: Path, folder: Path, minutes: float, most: int
) -> list[Result]:
    """Fly until the time is over or `most` blows have hit, and note each run in `results`."""
    rocsafe = shutil.which('rocsafe')
    if rocsafe is None:
        raise SystemExit('rocsafe is not on the PATH: . ./env.sh')
    results.parent.mkdir(parents=True, exist_ok=True)
    first = len(results.read_text().splitlines()) if results.is_file() else 0
    flights: list[Result] = []
    end = time.monotonic() + 60.0 * minutes
    with listening() as receipts:
        while time.monotonic() < end and sum(one.kills for one in flights) < most:
            seed = first + len(flights)
            place = folder / f'kill-{os.getpid()}-{seed}'
            result = flown(rocsafe, scenario, place, seed, receipts)
            flights.append(result)
            with results.open('a') as file:
                file.write(json.dumps(asdict(result)) + '\n')
            if not result.faults and result.outcome in ('complete', ''):
                shutil.rmtree(place)
    return flights


def main() -> int:
    """Run a part of the campaign and print its figures."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else '')
    parser.add_argument('--minutes', type=float, default=5.0)
    parser.add_argument('--kills', type=int, default=10**6, help='most blows that hit')
    parser.add_argument('--scenario', type=Path, default=SCENARIO, help='that is flown')
    parser.add_argument('--results', type=Path, default=Path('runs/kills.jsonl'))
    parser.add_argument('--folder', type=Path, default=Path('runs'), help='of the missions')
    arguments = parser.parse_args()
    os.environ.setdefault('ROS_AUTOMATIC_DISCOVERY_RANGE', 'LOCALHOST')
    flights = campaign(
        arguments.scenario.resolve(),
        arguments.results,
        arguments.folder.resolve(),
        arguments.minutes,
        arguments.kills,
    )
    for result in flights:
        for fault in result.faults:
            print(f'seed {result.seed}: {fault}')
    ends = Counter(result.outcome or f'exit code {result.code}' for result in flights)
    print(', '.join(f'{count} {end}' for end, count in ends.items()))
    kills, faults = sum(one.kills for one in flights), sum(len(one.faults) for one in flights)
    print(f'{len(flights)} runs, {kills} blows hit, {faults} faults')
    return 1 if faults else 0


if __name__ == '__main__':
    sys.exit(main())
