# SPDX-License-Identifier: Apache-2.0
"""One hand at a time: the lease of a vehicle as service, topic and condition of every order."""

import shutil
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient
from std_srvs.srv import Trigger
from test.sim.node_stand import DEADLINE_S, Operator, route

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import Control, VehicleState
from rocsafe_interfaces.srv import Lease, Resume
from rocsafe_ros.interfaces import topics


def take(operator: Operator, **fields: Any) -> Any:
    """Return the answer to somebody who asks for the lease of rav1."""
    return operator.ask(Lease, 'rav1/lease', Lease.Request(duration_s=600.0, **fields))


def send(operator: Operator, lease: str) -> Any:
    """Send a route with a lease and return the future of its result."""
    client = ActionClient(operator.node, FlyRoute, 'rav1/fly_route')
    operator.ros.spin_until(client.server_is_ready, DEADLINE_S)
    goal = FlyRoute.Goal(route=route(), plan_id='p', lease=lease)
    return operator.wait(client.send_goal_async(goal)).get_result_async()


def test_orders_without_the_lease_are_refused_by_name(operator: Operator, rav: Any) -> None:
    """A route and a resume are refused; the refusal says who leads. Hold needs no lease."""
    rav(lock_step=False, fix_rate_hz=20.0)
    states = operator.listen(topics.STATE)
    for lease in ('', 'nobody/1'):
        refused = operator.wait(send(operator, lease)).result
        assert refused.outcome == FlyRoute.Result.REJECTED
        assert refused.error_msg == 'rav1: nobody leads rav1; take the lease first'
    first = take(operator, holder='anna', mission='m1')
    assert first.success
    refused = operator.wait(send(operator, '')).result
    assert refused.error_msg.startswith('rav1: rav1 is led by anna, mission m1 for ')
    flown = send(operator, first.control.lease)
    operator.ros.spin_until(lambda: states and states[-1].state == VehicleState.FLYING, DEADLINE_S)
    assert operator.call('rav1/hold', Trigger.Request()).success
    assert 'led by anna' in operator.ask(Resume, 'rav1/resume', Resume.Request()).message
    again = operator.ask(Resume, 'rav1/resume', Resume.Request(lease=first.control.lease))
    assert again.success, again.message
    assert operator.call('rav1/land', Trigger.Request()).success
    assert operator.wait(flown).result.outcome == FlyRoute.Result.RETURNED_EARLY


def test_takeover_is_published_and_stops_the_first_holder(operator: Operator, rav: Any) -> None:
    """Who leads is latched; whoever takes over on purpose is obeyed, and nobody else."""
    rav(lock_step=False)
    heard = operator.listen(topics.CONTROL)
    first = take(operator, holder='anna')
    assert not take(operator, holder='bert').success
    second = take(operator, holder='bert', mission='m2', take_over=True)
    assert second.success
    operator.ros.spin_until(lambda: heard and heard[-1].holder == 'bert', DEADLINE_S)
    said: Control = heard[-1]
    assert (said.vehicle, said.mission, said.lease) == ('rav1', 'm2', second.control.lease)
    assert said.text == 'led by bert, mission m2, taken over from anna'
    assert said.epoch == first.control.epoch + 1
    refused = operator.wait(send(operator, first.control.lease)).result
    assert 'rav1 is led by bert, mission m2' in refused.error_msg


def test_lease_survives_its_node(operator: Operator, rav: Any, tmp_path: Path) -> None:
    """A vehicle's node that is started again obeys the same holder and refuses the others."""
    first = rav(lock_step=False, spool_directory=str(tmp_path))
    lease = take(operator, holder='anna').control.lease
    rav.stop(first)
    rav(lock_step=False, spool_directory=str(tmp_path), fix_rate_hz=20.0)
    assert 'led by anna' in take(operator, holder='bert').message
    assert take(operator, holder='anna').control.lease == lease


def test_goal_goes_to_exactly_one_of_two_nodes_of_a_name(
    operator: Operator, rav: Any, tmp_path: Path
) -> None:
    """Two nodes are called rav1: only the one that granted the lease takes off."""
    ours, other = (rav(lock_step=False, fix_rate_hz=20.0) for _ in range(2))
    server = ours._interface.lease.server
    assert server != other._interface.lease.server
    # Both have a service of this name: only the one that is meant answers.
    answers = [take(operator, holder='anna', server=server) for _ in range(3)]
    assert {answer.control.server for answer in answers} == {server}
    flown = send(operator, answers[-1].control.lease)
    vehicle = ours._interface._rav.vehicle
    operator.ros.spin_until(lambda: vehicle.flight is not None, DEADLINE_S)
    assert other._interface._rav.vehicle.flight is None
    answer = operator.ask(Resume, 'rav1/resume', Resume.Request(lease=answers[-1].control.lease))
    # The other one would say that it cannot, since it never flew.
    assert (answer.success, answer.message) == (True, '')
    assert not flown.done()


def test_cancel_reaches_only_the_node_that_flies_the_goal(operator: Operator, rav: Any) -> None:
    """Another vehicle of this name, which hears the cancel too, flies on."""
    ours, other = (rav(lock_step=False, fix_rate_hz=20.0) for _ in range(2))
    client = ActionClient(operator.node, FlyRoute, 'rav1/fly_route')
    goals = []
    for node in (ours, other):
        lease = take(operator, holder='anna', server=node._interface.lease.server).control.lease
        goal = FlyRoute.Goal(route=route(), plan_id='p', lease=lease)
        goals.append(operator.wait(client.send_goal_async(goal)))
    vehicles = [node._interface._rav.vehicle for node in (ours, other)]
    operator.ros.spin_until(lambda: all(one.flight is not None for one in vehicles), DEADLINE_S)
    goals[0].cancel_goal_async()
    operator.ros.spin_until(lambda: vehicles[0].summary() is not None, DEADLINE_S)
    for _ in range(3):
        # What it answers now came after the cancel.
        take(operator, holder='anna', server=other._interface.lease.server)
    assert vehicles[1].summary() is None


def test_goal_that_is_cancelled_before_time_begins_is_never_flown(
    operator: Operator, world: Any, rav: Any
) -> None:
    """It waits for the first step, and is withdrawn."""
    node = rav()
    goal = operator.send(route())
    operator.wait(goal.cancel_goal_async())
    ended = operator.wait(goal.get_result_async())
    assert ended.status == GoalStatus.STATUS_CANCELED
    states = operator.listen(topics.STATE)
    world('rav1', speed=20.0)
    operator.ros.spin_until(lambda: states and states[-1].header.stamp.sec > 0, DEADLINE_S)
    assert node._interface._rav.vehicle.flight is None


def test_lease_is_granted_where_the_disk_fails(
    operator: Operator, rav: Any, tmp_path: Path
) -> None:
    """A full disk must not keep anybody from leading a vehicle, or end its node."""
    spool = tmp_path / 'spool'
    rav(lock_step=False, spool_directory=str(spool))
    assert take(operator, holder='anna').success
    shutil.move(spool, tmp_path / 'aside')
    spool.write_text('no folder')
    second = take(operator, holder='bert', take_over=True)
    assert second.success, second.message
    refused = operator.wait(send(operator, '')).result
    assert 'rav1 is led by bert' in refused.error_msg
