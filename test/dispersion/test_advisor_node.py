# SPDX-License-Identifier: Apache-2.0
"""The node ``advisor`` names the agent while readings and reports come."""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_dispersion.advice_conversions import report_of
from rocsafe_dispersion.advisor_node import AdvisorNode
from rocsafe_interfaces.msg import AgentReport, GasReading, GeoPoint
from rocsafe_ros.conversions import stamp_of_ns
from rocsafe_ros.interfaces import topics

DEADLINE_S = 60.0
UNKNOWN_PLACE = GeoPoint(latitude=math.nan, longitude=math.nan, altitude=math.nan)


def gas(number: int) -> GasReading:
    """Return a reading of chlorine."""
    message = GasReading(
        sensor='electrochemical_chlorine', unit='ppm', calibration_gas='chlorine', raw=8.0,
        corrected=8.0, std=0.1, limit=0.1, window_s=1.0,
        position=GeoPoint(latitude=53.28, longitude=-9.06, altitude=70.0),
    )  # fmt: skip
    message.header.stamp = stamp_of_ns((number + 1) * 10**9)
    return message


def test_the_agent_is_named_while_the_mission_flies(ros, tmp_path):
    """From detector, smell and placard; nonsense is refused and a restart forgets nothing."""
    overrides = [
        Parameter('vehicles', value=['rav1']),
        Parameter('period_s', value=0.2),
        Parameter('spool_directory', value=str(tmp_path)),
    ]
    node = AdvisorNode(context=ros.context, parameter_overrides=overrides)
    other = Node('other', context=ros.context)
    drone = topics.create_publisher(other, topics.GAS, 'rav1')
    people = topics.create_publisher(other, topics.AGENT_REPORTS)
    heard = []
    topics.create_subscription(other, topics.AGENT, heard.append)
    for each in (node, other):
        ros.executor.add_node(each)
    ros.spin_until(
        lambda: drone.get_subscription_count() and people.get_subscription_count(), DEADLINE_S
    )
    for number in range(5):
        drone.publish(gas(number))
    people.publish(AgentReport(observation='smell_of_nothing', is_true=True))
    people.publish(AgentReport())
    people.publish(AgentReport(un_number=1017))
    people.publish(
        AgentReport(observation='smell_chlorine', is_true=True, witness='driver',
                    position=UNKNOWN_PLACE)
    )  # fmt: skip
    ros.spin_until(
        lambda: bool(heard) and heard[-1].report_count == 1 and bool(heard[-1].sensors), DEADLINE_S
    )
    last = heard[-1]
    assert last.agents[0] == 'chlorine'
    assert last.probabilities[0] > 0.99
    assert sum(last.probabilities) == pytest.approx(1.0)
    assert 'no agent' in last.agents
    assert last.procedures[0] == 'irritant-gas.md: Chlorine, UN 1017'
    assert list(last.sensors) == ['electrochemical_chlorine']
    ros.executor.remove_node(node)
    node.destroy_node()
    heard.clear()
    again = AdvisorNode(context=ros.context, parameter_overrides=overrides)
    ros.executor.add_node(again)
    ros.spin_until(lambda: bool(heard), DEADLINE_S)
    assert heard[-1].report_count == 1
    ros.executor.remove_node(again)
    again.destroy_node()


@pytest.mark.parametrize(
    'message',
    [
        AgentReport(),
        AgentReport(observation='smell_chlorine', un_number=1017),
        AgentReport(observation='smell_of_nothing'),
        AgentReport(observation='smell_chlorine', position=GeoPoint(latitude=91.0, longitude=0.0)),
    ],
)
def test_nonsense_is_refused(message):
    """With the error that the node tells in one line."""
    with pytest.raises((ValueError, KeyError)):
        report_of(message)
