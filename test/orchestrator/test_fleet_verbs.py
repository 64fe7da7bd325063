# SPDX-License-Identifier: Apache-2.0
"""Commands to all vehicles at once: one answer each, soon, whatever the others do."""

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import Trigger

from rocsafe_interfaces.srv import FleetCommand, Lease, Resume
from rocsafe_orchestrator.fleet_verbs_node import ANSWER_S, FleetVerbsNode
from rocsafe_orchestrator.process_table.launches import find_executable
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.interface_spec import CallSpec
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.control_lease import LeaseRefusedError
from rocsafe_ros.lease.server_node import LeaseServer

DEADLINE_S = 60.0
MANY = tuple(f'rav{number}' for number in range(1, 51))


class Vehicle:
    """A vehicle that answers as it is told, or never."""

    def __init__(self, ros: Any, name: str) -> None:
        self.told: list[str] = []
        self.refusal = ''
        self.node = VehicleScopeNode('vehicle', namespace=f'/{name}', context=ros.context)
        self.lease = LeaseServer(self.node, None)
        for spec in (calls.HOLD, calls.RETURN_HOME, calls.LAND):
            self.node.create_service(Trigger, spec.name, self._answering(spec.name))
        self.lease.serve(calls.RESUME, self._answering('resume'))
        ros.executor.add_node(self.node)

    def fall_silent(self) -> None:
        """Answer nothing any more, though the services are there."""
        for service in self.node.services:
            service.send_response = lambda _response, _header: None

    def _answering(self, verb: str) -> Callable[[Any, Any], Any]:
        def on_call(_request: Any, response: Any) -> Any:
            self.told.append(verb)
            response.success, response.message = not self.refusal, self.refusal
            return response

        return on_call


class Stand:
    """The node under test, vehicles, and an operator."""

    def __init__(self, ros: Any, names: tuple[str, ...], missing: tuple[str, ...] = ()) -> None:
        self.ros = ros
        self.vehicles = {name: Vehicle(ros, name) for name in names if name not in missing}
        self.operator = Node('operator', context=ros.context)
        self.verbs = FleetVerbsNode(
            context=ros.context,
            parameter_overrides=[
                Parameter('vehicles', value=list(names)),
                Parameter('mission', value='m1'),
            ],
        )
        for node in (self.operator, self.verbs):
            ros.executor.add_node(node)
        clients = self.verbs._commands.items()
        ros.spin_until(
            lambda: all(c.service_is_ready() for (_, name), c in clients if name not in missing),
            DEADLINE_S,
        )

    def call(self, spec: CallSpec, *vehicles: str) -> Any:
        """Return the answers to a command."""
        client = self.operator.create_client(FleetCommand, spec.name)
        self.ros.spin_until(client.service_is_ready, DEADLINE_S)
        answer = client.call_async(FleetCommand.Request(vehicles=list(vehicles)))
        self.ros.spin_until(answer.done, DEADLINE_S)
        return answer.result()

    def close(self) -> None:
        """Destroy the nodes."""
        for node in (self.verbs, self.operator, *(v.node for v in self.vehicles.values())):
            node.destroy_node()


@pytest.fixture
def stand(ros: Any) -> Iterator[Callable[..., Stand]]:
    """Return a function that makes a stand."""
    made: list[Stand] = []

    def make(*names: str, missing: tuple[str, ...] = ()) -> Stand:
        made.append(Stand(ros, names, missing))
        return made[-1]

    yield make
    for one in made:
        one.close()


@pytest.mark.parametrize(
    ('spec', 'verb'),
    [
        (calls.FLEET_HOLD, 'hold'),
        (calls.FLEET_RETURN_HOME, 'return_home'),
        (calls.FLEET_LAND, 'land'),
    ],
)
def test_all_are_told(stand: Callable[..., Stand], spec: CallSpec, verb: str) -> None:
    """Each vehicle gets the command once, and has one answer in the order of names."""
    post = stand('rav2', 'rav1')
    answer = post.call(spec)
    assert answer.success
    assert [(one.vehicle, one.success) for one in answer.answers] == [
        ('rav1', True),
        ('rav2', True),
    ]
    assert [vehicle.told for vehicle in post.vehicles.values()] == [[verb], [verb]]


def test_no_vehicle_keeps_the_others_from_obeying(stand: Callable[..., Stand]) -> None:
    """One refuses, one is silent, one is not there, one is unknown: the others are told."""
    post = stand('rav1', 'rav2', 'rav3', 'rav4', missing=('rav3',))
    post.vehicles['rav1'].refusal = 'rav1: the pilot has it'
    post.vehicles['rav2'].fall_silent()
    answer = post.call(calls.FLEET_HOLD, 'rav1', 'rav2', 'rav3', 'rav4', 'rav9')
    assert not answer.success
    assert {one.vehicle: one.message for one in answer.answers} == {
        'rav1': 'rav1: the pilot has it',
        'rav2': f'rav2: no answer within {ANSWER_S:g} s',
        'rav3': 'rav3: cannot be reached',
        'rav4': '',
        'rav9': 'rav9: is not of this fleet',
    }
    assert post.vehicles['rav4'].told == ['hold']


def test_resume_has_the_lease_of_its_mission(stand: Callable[..., Stand]) -> None:
    """It goes on with what its mission ordered, and takes nothing from another holder."""
    post = stand('rav1', 'rav2', 'rav3')
    for name, holder, mission in (('rav1', 'orchestrator', 'm1'), ('rav2', 'anna', 'm2')):
        client = post.verbs.create_client(Lease, f'{name}/lease')
        post.ros.spin_until(client.service_is_ready, DEADLINE_S)
        taken = client.call_async(Lease.Request(holder=holder, mission=mission))
        post.ros.spin_until(taken.done, DEADLINE_S)
    post.ros.spin_until(lambda: post.verbs._controls['rav1'].mission == 'm1', DEADLINE_S)
    answers = {one.vehicle: one for one in post.call(calls.FLEET_RESUME).answers}
    assert answers['rav1'].success
    assert answers['rav3'].success
    assert 'rav2 is led by anna, mission m2' in answers['rav2'].message
    assert post.vehicles['rav2'].told == []
    with pytest.raises(LeaseRefusedError, match='led by orchestrator, mission m1'):
        post.vehicles['rav1'].lease.require('')
    assert Resume is calls.RESUME.call_type


def test_fifty_vehicles_are_answered_for_within_a_second(stand: Callable[..., Stand]) -> None:
    """Some of them silent: the node answers by its own deadline, not by theirs."""
    post = stand(*MANY)
    for name in MANY[::10]:
        post.vehicles[name].fall_silent()
    answer = post.call(calls.FLEET_HOLD)
    assert [one.vehicle for one in answer.answers] == sorted(MANY)
    silent = {one.vehicle for one in answer.answers if not one.success}
    assert set(MANY[::10]) <= silent
    heard = [post.vehicles[name] for name in MANY if name not in MANY[::10]]
    post.ros.spin_until(lambda: all(one.told == ['hold'] for one in heard), DEADLINE_S)


SUPERVISOR = """
import os, subprocess, sys, time
environment = {**os.environ, 'ROCSAFE_SUPERVISOR_PID': str(os.getpid())}
child = subprocess.Popen(sys.argv[1:], env=environment, start_new_session=True)
print(child.pid, flush=True)
time.sleep(600)
"""


def test_it_outlives_its_supervisor_and_ends_after_the_vehicles(
    ros: Any, ros_domain_id: int, own_domain: None, tmp_path: Path
) -> None:
    """`kill -9` of the orchestrator: vehicles are still commanded; without them it ends."""
    executable = str(find_executable('rocsafe_orchestrator', 'fleet_verbs'))
    words = [executable, '--ros-args', '-p', "vehicles:=['rav1']"]
    vehicle = Vehicle(ros, 'rav1')
    operator = Node('operator', context=ros.context)
    ros.executor.add_node(operator)
    supervisor = subprocess.Popen(
        [sys.executable, '-c', SUPERVISOR, *words], stdout=subprocess.PIPE, text=True
    )
    assert supervisor.stdout is not None
    pid = int(supervisor.stdout.readline())
    try:
        client = operator.create_client(FleetCommand, calls.FLEET_HOLD.name)
        ros.spin_until(client.service_is_ready, DEADLINE_S)
        supervisor.send_signal(signal.SIGKILL)
        supervisor.wait()

        def is_obeyed() -> bool:
            answer = client.call_async(FleetCommand.Request())
            ros.spin_until(answer.done, DEADLINE_S)
            return bool(answer.result().success)

        ros.spin_until(is_obeyed, DEADLINE_S)
        told = len(vehicle.told)
        ros.spin_until(is_obeyed, DEADLINE_S)
        assert len(vehicle.told) > told
        vehicle.node.destroy_node()
        ros.spin_until(lambda: not is_running(pid), DEADLINE_S)
    finally:
        if is_running(pid):
            os.kill(pid, signal.SIGKILL)
        operator.destroy_node()


def is_running(pid: int) -> bool:
    """Return whether a process is there and not only left to be reaped."""
    try:
        return Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()[0] != 'Z'
    except FileNotFoundError:
        return False


def command(verb: str) -> list[str]:
    """Return the words of `rocsafe fleet`."""
    return [str(find_executable('rocsafe_orchestrator', 'rocsafe')), 'fleet', verb]


def test_command_prints_each_answer(
    stand: Callable[..., Stand], own_domain: None, ros: Any
) -> None:
    """`rocsafe fleet hold`: one line a vehicle, and exit code 1 if one has not obeyed."""
    post = stand('rav1', 'rav2')
    post.vehicles['rav2'].refusal = 'rav2: cannot hold: landed'
    process = subprocess.Popen(
        command('hold'),
        stdout=subprocess.PIPE,
        text=True,
    )
    ros.spin_until(lambda: process.poll() is not None, DEADLINE_S)
    assert process.stdout is not None
    assert process.stdout.read().splitlines() == ['rav1: hold', 'rav2: cannot hold: landed']
    assert process.returncode == 1


def test_command_without_a_mission_says_so(own_domain: None) -> None:
    """One line, at once."""
    begun = time.monotonic()
    done = subprocess.run(
        command('land'),
        capture_output=True,
        text=True,
        timeout=DEADLINE_S,
        check=False,
    )
    assert done.returncode == 1
    assert done.stderr.startswith('rocsafe: no mission is running in ROS domain ')
    assert time.monotonic() - begun < DEADLINE_S
