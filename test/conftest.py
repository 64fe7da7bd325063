# SPDX-License-Identifier: Apache-2.0
"""Fixtures of all tests."""

import contextlib
import functools
import gc
import importlib.util
import os
import random
import signal
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pytest
from hypothesis import settings

# Time limits of single examples measure the machine's load, not the code.
# Continuous integration tries the same examples each time, or it would refuse a change for a
# fault that the change does not have; at a desk every run looks for new ones.
settings.register_profile('rocsafe', deadline=None, derandomize='CI' in os.environ)
# Of `make test-fast`: tests that name no number of examples get fewer.
settings.register_profile('fast', settings.get_profile('rocsafe'), max_examples=20)
settings.load_profile('rocsafe')

# Threads of the linear algebra wait for each other in loops: on busy cores, ten times as long.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

POLL_S = 0.02
MISSIONS = 'missions'
LINES_OF_A_TRY = 60
DOMAINS = range(1, 101)


# Modules whose import says that a test file starts processes.
PROCESS_MODULES = ('subprocess', 'multiprocessing', 'pty')


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Mark the tests that use nodes or processes, and give those of nodes a second try.

    The mark `process` is found out, so that nobody has to remember it: `make test-fast` leaves
    these tests out. A machine that stops for seconds fails tests of nodes whatever the code does;
    the summary lists second tries. Tests that compute in their own process have one try.
    """
    for item in items:
        is_system = item.get_closest_marker('system') is not None
        if is_system or 'ros_domain_id' in item.fixturenames or _starts_processes(item):
            item.add_marker(pytest.mark.process)
        if is_system or 'ros' in item.fixturenames:
            item.add_marker(pytest.mark.flaky(reruns=1))


def pytest_collection_finish(session: pytest.Session) -> None:
    """Let the garbage collector pass over all that the collected tests are made of."""
    gc.collect()
    gc.freeze()


def pytest_terminal_summary(terminalreporter: pytest.TerminalReporter) -> None:
    """Show why tests had a second try: what passes then is a fault of product or test, too."""
    for report in terminalreporter.getreports('rerun'):
        terminalreporter.write_sep('_', f'first try of {report.nodeid}')
        lines = report.longreprtext.splitlines()
        terminalreporter.write_line('\n'.join(lines[-LINES_OF_A_TRY:]))


def _starts_processes(item: pytest.Item) -> bool:
    """Return whether the file of a test, its fixtures or its helpers can start processes."""
    modules = {item.module.__name__, *(one.func.__module__ for one in _fixtures(item))}
    return any(_can_start_processes(name) for name in modules)


@functools.cache
def _can_start_processes(module: str) -> bool:
    """Return whether a module, or a test's helper of which it has something, can do so."""
    spaces = [vars(sys.modules[module])] if module in sys.modules else []
    helpers = {getattr(value, '__module__', None) for space in spaces for value in space.values()}
    spaces += [
        vars(sys.modules[name])
        for name in helpers
        if isinstance(name, str) and name.startswith('test.') and name in sys.modules
    ]
    return any(
        name in space and space['__name__'] != __name__
        for space in spaces
        for name in PROCESS_MODULES
    )


def _fixtures(item: pytest.Item) -> Iterator[Any]:
    """Yield the definitions of the fixtures that a test uses."""
    for name in item.fixturenames:
        yield from item._fixtureinfo.name2fixturedefs.get(name, ())[-1:]


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Let one worker fly all missions, and share the other tests by files, if asked for files.

    A mission keeps all cores busy: two at once would only wait for each other. They begin first:
    no other work takes as long.
    """
    if config.getoption('dist') != 'loadscope':
        return None
    from xdist.scheduler import LoadScopeScheduling

    class MissionsTogether(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return MISSIONS if nodeid.startswith('test/system/') else nodeid.split('::')[0]

        def _assign_work_unit(self, node: Any) -> None:
            if MISSIONS in self.workqueue:
                self.workqueue.move_to_end(MISSIONS, last=False)
            super()._assign_work_unit(node)

    return MissionsTogether(config, log)


MOST_THREADS = 40
"""Of a process of tests; each DDS participant has about ten."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RosSession:
    """A ROS context of one test with the executor that spins its nodes."""

    context: Any
    executor: Any

    def spin_until(self, condition: Callable[[], bool], deadline_s: float) -> None:
        """Spin until `condition` holds; fail the test at the deadline."""
        end = time.monotonic() + deadline_s
        while not condition():
            if time.monotonic() > end:
                pytest.fail(f'not within {deadline_s} s: {condition}')
            self.executor.spin_once(timeout_sec=POLL_S)


@pytest.fixture(scope='session', autouse=True)
def ros_stays_on_this_machine(tmp_path_factory: pytest.TempPathFactory) -> None:
    """Keep discovery on the loopback interface, DDS by UDP, and logs out of the home folder."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['FASTDDS_BUILTIN_TRANSPORTS'] = 'UDPv4'
    os.environ['ROS_LOG_DIR'] = str(tmp_path_factory.mktemp('ros_log'))


@pytest.fixture(scope='session', autouse=True)
def default_domain(ros_stays_on_this_machine: None) -> Iterator[int | None]:
    """Reserve a domain, also for processes of tests that ask for none; None without ROS."""
    if importlib.util.find_spec('domain_coordinator') is None:
        yield None
        return
    with reserved_domain() as number:
        os.environ['ROS_DOMAIN_ID'] = str(number)
        yield number


@pytest.fixture(scope='module', autouse=True)
def environment_is_left_as_it_was(default_domain: int | None) -> Iterator[None]:
    """Undo what commands that run in this process set for their children."""
    before = dict(os.environ)
    yield
    if os.environ != before:
        os.environ.clear()
        os.environ.update(before)


@pytest.fixture(scope='session', autouse=True)
def ctrl_c_is_heard() -> None:
    """Let children obey SIGINT also where a shell started the tests in its background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope='session')
def ros_domain_id(default_domain: int | None) -> int:
    """Give the domain of the tests; folders whose nodes others must not hear reserve their own."""
    if default_domain is None:
        pytest.skip('no ROS 2 here: source it or run make setup')
    return default_domain


@pytest.fixture
def own_domain(ros_domain_id: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the command find its domain where it looks: tests of other folders have theirs there."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain_id))


@contextmanager
def reserved_domain() -> Iterator[int]:
    """Hold a domain that nobody else on this machine has, and give its number.

    `domain_coordinator` keeps test runs apart that hold their domain. It does not know of nodes
    that a killed test run left behind, nor of those that others started without it: domains
    whose UDP ports are in use are left out.
    """
    import domain_coordinator

    numbers = iter(_silent_domains() or DOMAINS)
    with domain_coordinator.domain_id(selector=lambda: next(numbers)) as number:
        yield int(number)


def _silent_domains() -> list[int]:
    """Return the domains without a participant on this machine, in random order."""
    from rocsafe_ros.domain.discovery import UDP_TABLE, local_participants

    try:
        table = UDP_TABLE.read_text()
    except OSError:
        return list(DOMAINS)
    silent = [number for number in DOMAINS if local_participants(table, number) == 0]
    return random.sample(silent, len(silent))


@pytest.fixture(scope='session')
def plain_topics() -> None:
    """Let no topic look for publishers of another quality of service; each look costs each spin.

    The executor of the tests goes through all that it could wait for, before each wait.
    """
    from rclpy import event_handler

    for kind in (event_handler.PublisherEventCallbacks, event_handler.SubscriptionEventCallbacks):
        kind.__init__.__kwdefaults__['use_default_callbacks'] = False


@pytest.fixture
def ros(ros_domain_id: int, plain_topics: None) -> Iterator[RosSession]:
    """Give a test its own context and executor, and take them down after it."""
    rclpy = pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    from rclpy.context import Context
    from rclpy.exceptions import InvalidHandle
    from rclpy.executors import SingleThreadedExecutor

    context = Context()
    rclpy.init(context=context, domain_id=ros_domain_id)
    executor = SingleThreadedExecutor(context=context)
    yield RosSession(context=context, executor=executor)
    nodes = executor.get_nodes()
    executor.shutdown(timeout_sec=2.0)
    # Nodes of a context that is shut down stay in the domain as long as something refers to them.
    for node in nodes:
        # Not those that the test has destroyed.
        with contextlib.suppress(InvalidHandle), node.handle:
            node.destroy_node()
    rclpy.shutdown(context=context)
    # A node that is part of a reference cycle keeps its participant. Fast DDS was seen to wait for
    # ever when one of a dozen in a process was collected while the others heard each other.
    if sum(1 for _ in Path('/proc/self/task').iterdir()) > MOST_THREADS:
        gc.collect()


@pytest.fixture(scope='session')
def drawing() -> None:
    """Skip, with the reason, where nothing can draw."""
    from rocsafe_scene.errors import EngineError
    from rocsafe_scene.graphics.pipe import open_pipe

    try:
        open_pipe()
    except EngineError as error:
        pytest.skip(str(error))
