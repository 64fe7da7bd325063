# SPDX-License-Identifier: Apache-2.0
"""A participant works once a step, reports it, and repeats what got lost."""

from itertools import groupby
from types import SimpleNamespace

import pytest
from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock

from rocsafe_ros import lockstep
from rocsafe_ros.conversions import ns_of_stamp, stamp_of_ns
from rocsafe_ros.interfaces import topics
from rocsafe_ros.lockstep import Participant

STEP_NS = 100_000_000
DEADLINE_S = 60.0


@pytest.fixture
def table(ros):
    """A world's side of the lock-step and one participant that counts its steps."""
    yield from lockstep_of(ros)


@pytest.fixture
def late(ros):
    """The same with a participant that does not hear everybody yet."""
    yield from lockstep_of(ros, is_ready=False)


def lockstep_of(ros, *, is_ready=True):
    """Yield a world's side, and a participant whose idleness and readiness can be set."""
    world, drone = (Node(name, context=ros.context) for name in ('world', 'drone'))
    table = SimpleNamespace(steps=[], reports=[], idle_from_ns=10**18, is_ready=is_ready)
    table.clock = topics.create_publisher(world, topics.CLOCK)
    topics.create_subscription(world, topics.STEP_DONE, table.reports.append)

    def on_step(time_ns):
        table.steps.append(time_ns)
        return time_ns >= table.idle_from_ns

    table.participant = Participant(drone, 'drone', on_step, lambda: table.is_ready)
    for node in (world, drone):
        ros.executor.add_node(node)
    ros.spin_until(lambda: table.clock.get_subscription_count() >= 1, DEADLINE_S)
    yield table
    for node in (world, drone):
        ros.executor.remove_node(node)
        node.destroy_node()


def tick(table, time_ns):
    """Publish a time."""
    table.clock.publish(Clock(clock=stamp_of_ns(time_ns)))


def reported(table):
    """Return (time, idleness) of the reports; one that was repeated counts once."""
    return [said for said, _ in groupby((ns_of_stamp(r.step), r.is_idle) for r in table.reports)]


def repetitions(late, monkeypatch):
    """Return a list that grows with each repetition of the report: whether it was told."""
    seen = []
    monkeypatch.setattr(lockstep, 'MOST_HELD_BACK', 3)
    tell = late.participant._tell
    late.participant._tell = lambda report: (
        tell(report),
        seen.append(late.participant._has_begun),
    )
    return seen


def test_time_waits_for_who_is_not_ready(ros, late, monkeypatch):
    """No report before all are heard, then all of them."""
    seen = repetitions(late, monkeypatch)
    tick(late, STEP_NS)
    ros.spin_until(lambda: len(seen) == 2, DEADLINE_S)
    assert late.reports == []
    late.is_ready = True
    ros.spin_until(lambda: late.reports, DEADLINE_S)
    assert ns_of_stamp(late.reports[0].step) == STEP_NS
    late.is_ready = False
    tick(late, 2 * STEP_NS)
    ros.spin_until(lambda: ns_of_stamp(late.reports[-1].step) == 2 * STEP_NS, DEADLINE_S)


def test_nobody_is_waited_for_without_end(ros, late, monkeypatch):
    """After so many repetitions the participant begins all the same."""
    seen = repetitions(late, monkeypatch)
    tick(late, STEP_NS)
    ros.spin_until(lambda: late.reports, DEADLINE_S)
    assert seen[:4] == [False, False, False, True]


def test_each_step_is_worked_once_and_reported(ros, table):
    """Work, then the report with the time worked."""
    for number in (1, 2, 3):
        tick(table, number * STEP_NS)
        ros.spin_until(lambda n=number: len(reported(table)) >= n, DEADLINE_S)
    assert table.steps == [STEP_NS, 2 * STEP_NS, 3 * STEP_NS]
    assert [time_ns for time_ns, _ in reported(table)] == table.steps


def test_time_published_again_is_not_worked_again(ros, table):
    """The world repeats a time whose report it misses; the report is repeated, the work not."""
    tick(table, STEP_NS)
    ros.spin_until(lambda: len(table.reports) == 1, DEADLINE_S)
    tick(table, STEP_NS)
    ros.spin_until(lambda: len(table.reports) >= 2, DEADLINE_S)
    assert table.steps == [STEP_NS]
    assert ns_of_stamp(table.reports[1].step) == STEP_NS


def test_report_tells_idleness(ros, table):
    """The world can stop when nobody has anything to do."""
    table.idle_from_ns = 2 * STEP_NS
    for number in (1, 2):
        tick(table, number * STEP_NS)
        ros.spin_until(lambda n=number: len(reported(table)) >= n, DEADLINE_S)
    assert reported(table) == [(STEP_NS, False), (2 * STEP_NS, True)]


def test_new_request_ends_idleness_at_once(ros, table):
    """A participant that gets work between two steps says so without waiting for time."""
    table.idle_from_ns = 0
    tick(table, STEP_NS)
    ros.spin_until(lambda: len(table.reports) >= 1, DEADLINE_S)
    table.participant.report(is_idle=False)
    ros.spin_until(lambda: not table.reports[-1].is_idle, DEADLINE_S)
    assert table.steps == [STEP_NS]


def test_participant_that_joins_late_works_the_time_its_node_has_heard(ros):
    """A restarted node may hear the time before it takes part; that time stands still for it."""
    overrides = [Parameter('use_sim_time', value=True)]
    world = Node('world', context=ros.context)
    drone = Node('drone', context=ros.context, parameter_overrides=overrides)
    clock = topics.create_publisher(world, topics.CLOCK)
    steps = []
    for node in (world, drone):
        ros.executor.add_node(node)

    def has_heard():
        clock.publish(Clock(clock=stamp_of_ns(STEP_NS)))
        return drone.get_clock().now().nanoseconds == STEP_NS

    ros.spin_until(has_heard, DEADLINE_S)
    Participant(drone, 'drone', lambda time_ns: steps.append(time_ns) or True)
    assert steps == [STEP_NS]
    for node in (world, drone):
        ros.executor.remove_node(node)
        node.destroy_node()
