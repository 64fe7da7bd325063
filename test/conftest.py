# SPDX-License-Identifier: Apache-2.0
"""Fixtures of all tests."""

import os
import signal
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from typing import Any

import pytest
from hypothesis import settings

# Time limits of single examples measure the machine's load, not the code.
# Continuous integration tries the same examples each time, or it would refuse a change for a
# fault that the change does not have; at a desk every run looks for new ones.
settings.register_profile('rocsafe', deadline=None, derandomize='CI' in os.environ)
settings.load_profile('rocsafe')

# Threads of the linear algebra wait for each other in loops: on busy cores, ten times as long.
os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

POLL_S = 0.02


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Give a test that talks to other processes a second try, which the summary lists.

    A machine that stands still for seconds fails them all, whatever the code does. What is
    computed in the test's own process has one try.
    """
    for item in items:
        if 'ros' in getattr(item, 'fixturenames', ()) or item.get_closest_marker('system'):
            item.add_marker(pytest.mark.flaky(reruns=1))


@pytest.hookimpl(optionalhook=True)
def pytest_xdist_make_scheduler(config: pytest.Config, log: Any) -> Any:
    """Let one worker fly all missions, and share the other tests by files.

    A mission keeps all cores busy: two at once would only wait for each other.
    """
    from xdist.scheduler import LoadScopeScheduling

    class MissionsTogether(LoadScopeScheduling):
        def _split_scope(self, nodeid: str) -> str:
            return 'missions' if nodeid.startswith('test/system/') else nodeid.split('::')[0]

    return MissionsTogether(config, log)


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
    """Keep discovery on the loopback interface and logs out of the home folder."""
    os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    os.environ['ROS_LOG_DIR'] = str(tmp_path_factory.mktemp('ros_log'))


@pytest.fixture(scope='session', autouse=True)
def ctrl_c_is_heard() -> None:
    """Let children obey SIGINT also where a shell started the tests in its background."""
    if signal.getsignal(signal.SIGINT) is signal.SIG_IGN:
        signal.signal(signal.SIGINT, signal.default_int_handler)


@pytest.fixture(scope='session')
def ros_domain_id(ros_stays_on_this_machine: None) -> Iterator[int]:
    """Reserve a domain of our own, so that parallel runs do not hear each other."""
    with reserved_domain() as number:
        os.environ['ROS_DOMAIN_ID'] = str(number)
        yield number


@pytest.fixture
def own_domain(ros_domain_id: int, monkeypatch: pytest.MonkeyPatch) -> None:
    """Let the command find its domain where it looks: tests of other folders have theirs there."""
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain_id))


@contextmanager
def reserved_domain() -> Iterator[int]:
    """Hold a domain that nobody else on this machine has, and give its number."""
    domain_coordinator = pytest.importorskip(
        'domain_coordinator', reason='no ROS 2 here: source it or run make setup'
    )
    with domain_coordinator.domain_id() as number:
        yield int(number)


@pytest.fixture
def ros(ros_domain_id: int) -> Iterator[RosSession]:
    """Give a test its own context and executor, and take them down after it."""
    rclpy = pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    from rclpy.context import Context
    from rclpy.executors import SingleThreadedExecutor

    context = Context()
    rclpy.init(context=context, domain_id=ros_domain_id)
    executor = SingleThreadedExecutor(context=context)
    yield RosSession(context=context, executor=executor)
    executor.shutdown(timeout_sec=2.0)
    rclpy.shutdown(context=context)


@pytest.fixture(scope='session')
def drawing() -> None:
    """Skip, with the reason, where nothing can draw."""
    from rocsafe_scene.errors import EngineError
    from rocsafe_scene.graphics.pipe import open_pipe

    try:
        open_pipe()
    except EngineError as error:
        pytest.skip(str(error))
