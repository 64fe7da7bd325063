# SPDX-License-Identifier: Apache-2.0
"""The table of topics is the contract: names, scopes and qualities of service."""

import pytest
from rclpy.qos import DurabilityPolicy, ReliabilityPolicy

from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import name_of
from rocsafe_ros.interfaces.qos import MEASUREMENTS_KEPT


def test_names_are_unique_and_relative():
    """Only names that ROS itself fixes are absolute."""
    names = [spec.name for spec in (*topics.TOPICS, *calls.CALLS)]
    assert len(names) == len(set(names))
    fixed = {name for name in names if name.startswith('/')}
    assert fixed <= {'/clock', '/diagnostics', '/rosout', '/tf', '/tf_static'}


def test_everything_is_published_reliably():
    """Best-effort publishers never reach reliable subscribers, so there are none.

    But packets between agents, which repair losses themselves and are heard as best effort.
    """
    for spec in (spec for spec in topics.TOPICS if spec is not topics.FLEET_DELTA):
        assert spec.qos.reliability is ReliabilityPolicy.RELIABLE, spec.name


@pytest.mark.parametrize(
    'spec', [topics.PLAN, topics.REGION, topics.MOSAIC, topics.STATE, topics.MISSION_STATE]
)
def test_state_is_latched(spec):
    """Who comes late gets the last state at once, and acts on the last one only."""
    assert spec.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
    assert spec.is_state


@pytest.mark.parametrize('spec', [topics.CMD_VEL, topics.GIMBAL_COMMAND, topics.AGENT_REPORTS])
def test_what_people_publish_by_hand_is_heard(spec):
    """`ros2 topic pub` keeps no messages: a subscriber that asks for kept ones never hears it."""
    assert spec.qos.durability is DurabilityPolicy.VOLATILE


def test_of_velocities_only_the_newest_is_followed():
    """A vehicle that is busy for a while does not follow a queue of old ones."""
    assert topics.CMD_VEL.is_state
    assert topics.CMD_VEL.qos.durability is DurabilityPolicy.VOLATILE


def test_what_is_published_again_and_again_is_not_overwritten():
    """A publisher that keeps one message loses those that its subscribers are late for.

    22 % of accumulated_dose were lost so. A path alone has all earlier messages in itself.
    """
    single = {spec.name: spec.rate for spec in topics.TOPICS if spec.qos.depth == 1}
    once = {name for name, rate in single.items() if rate in ('on change', 'once')}
    assert set(single) - once == {topics.PATH.name}


@pytest.mark.parametrize(
    'spec', [topics.FIX, topics.GROUND_TRUTH_FIX, topics.RADIATION, topics.RECEIPTS]
)
def test_measurements_reach_who_comes_late(spec):
    """A recorder that is started again gets what was published while it was away."""
    assert spec.qos.durability is DurabilityPolicy.TRANSIENT_LOCAL
    assert spec.qos.depth == MEASUREMENTS_KEPT


def test_vehicle_is_a_namespace():
    """A node outside the vehicle's namespace names the vehicle."""
    assert name_of(topics.FIX) == 'fix'
    assert name_of(topics.FIX, 'rav1') == 'rav1/fix'


def test_fleet_names_take_no_vehicle():
    """A plan belongs to the fleet."""
    with pytest.raises(ValueError, match='plan belongs to the fleet'):
        name_of(topics.PLAN, 'rav1')
