# SPDX-License-Identifier: Apache-2.0
"""A recorder, and a node that is not known yet, are no audience."""

from rclpy.node import Node
from std_msgs.msg import String

from rocsafe_ros.domain.audience import Audience

DEADLINE_S = 30.0


class Info:
    """What the graph says of a subscription."""

    def __init__(self, node_name):
        self.node_name = node_name


class Graph:
    """Stands for a node and its publisher."""

    topic_name = 'picture'

    def __init__(self):
        self.names, self.count, self.questions = [], 0, 0

    def get_subscription_count(self):
        """Return how many subscriptions match."""
        return self.count

    def get_subscriptions_info_by_topic(self, _topic):
        """Return who they are, as far as known."""
        self.questions += 1
        return [Info(name) for name in self.names]


def test_unknown_subscriber_is_no_viewer_until_it_is_known():
    """A recorder that is being discovered has no name yet; the graph is asked until it has."""
    graph = Graph()
    audience = Audience(graph, graph)
    assert not audience.is_watching
    graph.names, graph.count = ['_NODE_NAME_UNKNOWN_'], 1
    assert not audience.is_watching
    graph.names = ['recorder']
    assert not audience.is_watching
    asked = graph.questions
    assert not audience.is_watching
    assert graph.questions == asked
    graph.names, graph.count = ['recorder', 'viewer'], 2
    assert audience.is_watching


def test_viewer_counts_beside_a_recorder(ros):
    """Over real topics."""
    nodes = [Node(name, context=ros.context) for name in ('camera', 'recorder', 'viewer')]
    for node in nodes:
        ros.executor.add_node(node)
    camera, recorder, viewer = nodes
    publisher = camera.create_publisher(String, 'picture', 1)
    audience = Audience(camera, publisher)
    recorder.create_subscription(String, 'picture', print, 1)
    ros.spin_until(lambda: publisher.get_subscription_count() == 1, DEADLINE_S)
    assert not audience.is_watching
    viewer.create_subscription(String, 'picture', print, 1)
    ros.spin_until(lambda: audience.is_watching, DEADLINE_S)
    for node in nodes:
        ros.executor.remove_node(node)
        node.destroy_node()
