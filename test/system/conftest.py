# SPDX-License-Identifier: Apache-2.0
"""A whole mission in processes of its own, watched from outside."""

import hashlib
import json
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from threading import Event, Thread
from typing import Any

import pytest
from test.conftest import reserved_domain

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.run_directory import RunDirectory

SCENARIO = Path(__file__).with_name('small.yaml')
# Of a mission that takes some ten seconds on two free cores.
DEADLINE_S = 120.0


class Flight:
    """One `rocsafe run`, of the small mission unless another scenario is named; or resumed."""

    def __init__(
        self,
        command: Path,
        domain_id: int,
        folder: Path,
        *options: str,
        scenario: Path = SCENARIO,
        has_reader: bool = True,
        runs: Path | None = None,
        is_new: bool = True,
    ) -> None:
        self._runs = runs or folder / 'runs'
        self._name = scenario.stem
        self._output = folder / 'output.txt'
        folder.mkdir()
        self._output.touch()
        what = [scenario, '--out', self._runs] if is_new else []
        with self._output.open('wb') if has_reader else _pipe_without_reader() as output:
            self.process = subprocess.Popen(
                [command, 'run', *what, *options],
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
                env={**os.environ, 'ROS_DOMAIN_ID': str(domain_id)},
            )

    @property
    def output(self) -> str:
        """What the command has printed so far."""
        return self._output.read_text(encoding='utf-8')

    @property
    def run(self) -> RunDirectory:
        """The run directory; waits until there is one."""
        pattern = f'{self._name}-*'
        self.wait_until(lambda: any(self._runs.glob(pattern)))
        return RunDirectory(next(self._runs.glob(pattern)))

    @property
    def has_begun(self) -> bool:
        """Whether it made a run directory."""
        return self._runs.exists()

    def wait_until(self, condition: Callable[[], bool]) -> None:
        """Wait until `condition` holds; the mission must not end before."""
        end = time.monotonic() + DEADLINE_S
        while not condition():
            assert time.monotonic() < end, f'deadline, after:\n{self.output}'
            assert self.process.poll() is None, f'mission ended early:\n{self.output}'
            time.sleep(0.05)

    def wait_for_images(self, count: int) -> None:
        """Wait until `count` photographs are stored."""
        self.wait_until(lambda: len(self.images()) >= count)

    def pid_of(self, name: str) -> int:
        """Return the id of a process of the run, as its supervisor noted it."""
        log = self.run.log_of('orchestrator').read_text(encoding='utf-8')
        return int(re.findall(rf' {name}: started, process (\d+)', log)[-1])

    def living(self) -> list[int]:
        """Return the ids of the processes of the run that are alive."""
        log = self.run.log_of('orchestrator').read_text(encoding='utf-8')
        pids = [int(pid) for pid in re.findall(r': started, process (\d+)', log)]
        return [pid for pid in pids if is_alive(pid)]

    def images(self) -> dict[str, str]:
        """Return the photographs that the manifest names, each with the hash of its file."""
        manifest = self.run.images / 'manifest.jsonl'
        text = manifest.read_text(encoding='utf-8') if manifest.is_file() else ''
        # The last line may be half written.
        lines = [line for line in text.splitlines(keepends=True) if line.endswith('\n')]
        records = [json.loads(line) for line in lines]
        return {record['shot_id']: record['stored_sha256'] for record in records}

    def damaged_images(self) -> set[str]:
        """Return photographs that are not as they were stored, or that the manifest lacks."""
        folder, named = self.run.images, self.images()
        hashes = {
            path.stem: hashlib.sha256(path.read_bytes()).hexdigest()
            for path in folder.glob('*.jpg')
        }
        return {name for name in named.keys() | hashes if named.get(name) != hashes.get(name)}

    def info(self) -> dict[str, Any]:
        """Return what the run noted about itself."""
        content: dict[str, Any] = json.loads(self.run.run_info.read_text(encoding='utf-8'))
        return content

    def end(self) -> int:
        """Wait for the end and return the exit code."""
        try:
            return self.process.wait(timeout=DEADLINE_S)
        except subprocess.TimeoutExpired:
            pytest.fail(f'hangs, after:\n{self.output}')


def _pipe_without_reader() -> Any:
    read, write = os.pipe()
    os.close(read)
    return os.fdopen(write, 'wb')


def is_alive(pid: int) -> bool:
    """Return whether a process runs; a zombie, or one that has ended, does not."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except OSError:
        return False


@pytest.fixture(scope='session')
def ros_domain_id(default_domain: int | None) -> Iterator[int]:
    """Reserve a domain for missions alone: other tests keep vehicles of their own in theirs."""
    if default_domain is None:
        pytest.skip('no ROS 2 here: source it or run make setup')
    with reserved_domain() as number:
        yield number


@pytest.fixture(scope='session')
def rocsafe() -> Path:
    """Give the path of the `rocsafe` command of this workspace."""
    try:
        return find_executable('rocsafe_orchestrator', 'rocsafe')
    except SetupError as error:
        pytest.skip(str(error))


class Hangar:
    """Starts missions of a scenario in a folder, and ends what is left of them."""

    def __init__(self, command: Path, domain_id: int, folder: Path, scenario: Path) -> None:
        self._command = command
        self._domain_id = domain_id
        self._folder = folder
        self._scenario = scenario
        self._flights: list[Flight] = []

    def __call__(self, *options: str, **settings: Any) -> Flight:
        """Start the mission with `options` of `rocsafe run`, and settings of `Flight`."""
        folder = self._folder / f'flight-{len(self._flights)}'
        flight = Flight(
            self._command, self._domain_id, folder, *options, scenario=self._scenario, **settings
        )
        self._flights.append(flight)
        return flight

    def __enter__(self) -> 'Hangar':
        return self

    def __exit__(self, *_: object) -> None:
        """End what still flies."""
        for flight in self._flights:
            if flight.process.poll() is None:
                os.killpg(flight.process.pid, signal.SIGKILL)
                flight.process.wait()


@pytest.fixture
def fly(
    rocsafe: Path, ros_domain_id: int, tmp_path: Path, request: pytest.FixtureRequest
) -> Iterator[Hangar]:
    """Give a function that starts the mission that the module of the test names, or the small."""
    with Hangar(rocsafe, ros_domain_id, tmp_path, _scenario_of(request)) as hangar:
        yield hangar


@pytest.fixture(scope='session')
def flown() -> dict[Path, Flight]:
    """Give the missions that were flown to their end, by scenario: modules share them."""
    return {}


@pytest.fixture(scope='module')
def complete(
    flown: dict[Path, Flight],
    rocsafe: Path,
    ros_domain_id: int,
    tmp_path_factory: pytest.TempPathFactory,
    request: pytest.FixtureRequest,
) -> Flight:
    """Give the mission, flown to its end as fast as possible."""
    scenario = _scenario_of(request)
    if scenario not in flown:
        folder = tmp_path_factory.mktemp('complete')
        with Hangar(rocsafe, ros_domain_id, folder, scenario) as hangar:
            flight = hangar()
            assert flight.end() == 0, flight.output
        flown[scenario] = flight
    return flown[scenario]


def _scenario_of(request: pytest.FixtureRequest) -> Path:
    scenario: Path = getattr(request.module, 'SCENARIO', SCENARIO)
    return scenario


class Intruder:
    """Another program in the domain of the missions."""

    def __init__(self, node: Any) -> None:
        self._node = node
        self.heard_steps = 0

    def disturb(self) -> None:
        """Publish times of the far future, and steps of the vehicles, from now on."""
        from rosgraph_msgs.msg import Clock

        from rocsafe_interfaces.msg import StepDone
        from rocsafe_ros.conversions import stamp_of_ns
        from rocsafe_ros.interfaces import topics

        later = stamp_of_ns(2_000_000_000_000_000_000)
        clock = topics.create_publisher(self._node, topics.CLOCK)
        steps = topics.create_publisher(self._node, topics.STEP_DONE)
        topics.create_subscription(self._node, topics.STEP_DONE, self._on_step)

        def publish() -> None:
            clock.publish(Clock(clock=later))
            for name in ('rav1', 'rav2', 'recorder', 'radiation_field'):
                steps.publish(StepDone(participant=name, step=later))

        self._node.create_timer(0.05, publish)

    def pretend(self, name: str) -> None:
        """Publish, from now on, as a lost vehicle of the name far away in a high dose rate."""
        from sensor_msgs.msg import NavSatFix

        from rocsafe_interfaces.msg import RadiationReading, VehicleState
        from rocsafe_ros.interfaces import topics

        specs = (topics.FIX, topics.GROUND_TRUTH_FIX, topics.RADIATION, topics.STATE)
        outputs = [topics.create_publisher(self._node, spec, name) for spec in specs]
        fix = NavSatFix(latitude=53.27, longitude=-9.06, altitude=90.0)
        reading = RadiationReading(vehicle=name, dose_rate_usvh=1e6)
        state = VehicleState(vehicle=name, state=VehicleState.CRASHED, ending=3, is_simulated=True)
        topics.create_subscription(self._node, topics.FIX, self._on_fix, name)

        def publish() -> None:
            for message in (fix, reading, state):
                message.header.stamp = self._stamp
            for output, message in zip(outputs, (fix, fix, reading, state), strict=True):
                output.publish(message)

        self._stamp = fix.header.stamp
        self._node.create_timer(0.02, publish)

    def _on_fix(self, fix: Any) -> None:
        self._stamp = fix.header.stamp

    def _on_step(self, report: Any) -> None:
        self.heard_steps += report.step.sec < 2_000_000_000

    @contextmanager
    def vehicle(self, name: str) -> Iterator[None]:
        """Serve a vehicle's flights."""
        from rclpy.action import ActionServer
        from rclpy.node import Node

        from rocsafe_interfaces.action import FlyRoute

        node = Node('bridge', namespace=f'/{name}', context=self._node.context)
        server = ActionServer(node, FlyRoute, 'fly_route', lambda _goal: FlyRoute.Result())
        yield
        server.destroy()
        node.destroy_node()


@pytest.fixture
def intruder(ros: Any) -> Iterator[Intruder]:
    """Give another program, which spins beside the test."""
    from rclpy.node import Node

    node = Node('intruder', context=ros.context)
    ros.executor.add_node(node)
    is_over = Event()

    def spin() -> None:
        while not is_over.is_set():
            ros.executor.spin_once(timeout_sec=0.02)

    thread = Thread(target=spin)
    thread.start()
    yield Intruder(node)
    is_over.set()
    thread.join()
    node.destroy_node()
