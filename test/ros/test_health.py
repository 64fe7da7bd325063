# SPDX-License-Identifier: Apache-2.0
"""Each node tells its health, and who speaks another version of the interfaces."""

from dataclasses import dataclass, field

from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.node import Node

from rocsafe_interfaces.msg import VehicleState
from rocsafe_ros.conversions import diagnostic, vehicle_diagnostic
from rocsafe_ros.domain.interface_versions import TOPICS_A_LOOK, InterfaceVersions
from rocsafe_ros.interfaces import topics
from rocsafe_ros.process.health import HealthReporter

DEADLINE_S = 30.0
STATE = 'rocsafe_interfaces/msg/VehicleState'


@dataclass
class Hash:
    """What the graph says of the type of an endpoint."""

    value: bytes
    version: int = 1


@dataclass
class End:
    """An endpoint in the graph."""

    topic_name: str = '/rav1/state'
    node_name: str = 'recorder'
    node_namespace: str = '/'
    topic_type: str = STATE
    topic_type_hash: Hash = field(default_factory=lambda: Hash(b'a' * 32))


class Graph:
    """Stands for a node that subscribes to topics, of which others publish some."""

    def __init__(self, others=(), count=1):
        self.publishers = ()
        self.subscriptions = [End(topic_name=f'/topic{k}') for k in range(count)]
        self.others = list(others)
        self.nodes = [('recorder', '/')]
        self.asked = []

    def get_node_names_and_namespaces(self):
        """Return the nodes that are known."""
        return list(self.nodes)

    def get_fully_qualified_name(self):
        """Return its name."""
        return '/recorder'

    def get_publishers_info_by_topic(self, topic):
        """Return who publishes."""
        self.asked.append(topic)
        return self.others

    def get_subscriptions_info_by_topic(self, topic):
        """Return itself."""
        return [End(topic_name=topic)]


def bridge(content, version=1):
    """Return the endpoint of a bridge."""
    return End(node_name='bridge', node_namespace='/rav1', topic_type_hash=Hash(content, version))


def test_another_version_is_one_clear_line():
    """Once for a node and a type, naming both nodes, the type and what to do."""
    versions = InterfaceVersions(Graph([bridge(b'b' * 32)]))
    (line,) = versions.new_mismatches()
    assert line == (
        f'/rav1/bridge has another version of {STATE} on /topic0 than /recorder: '
        'build both from the same version of rocsafe_interfaces'
    )
    assert versions.new_mismatches() == []
    assert versions.mismatches == (line,)


def test_same_or_untold_versions_are_no_mismatch():
    """A hash of zeros is none: some middleware does not tell it."""
    versions = InterfaceVersions(Graph([bridge(b'a' * 32), bridge(b'\0' * 32, version=0)]))
    assert versions.new_mismatches() == []


def test_all_topics_are_compared_in_turn():
    """A recorder of a large fleet does not ask for thousands of topics at once."""
    graph = Graph(count=3 * TOPICS_A_LOOK)
    versions = InterfaceVersions(graph)
    versions.new_mismatches()
    assert 1 <= len(graph.asked) <= TOPICS_A_LOOK
    for _ in range(3 * TOPICS_A_LOOK):
        versions.new_mismatches()
    assert len(set(graph.asked)) == 3 * TOPICS_A_LOOK


def test_topics_are_compared_slowly_until_a_node_comes():
    """A look costs time that grows with the fleet: all at once again only when somebody is new."""
    graph = Graph(count=3 * TOPICS_A_LOOK)
    versions = InterfaceVersions(graph)
    for _ in range(3 * TOPICS_A_LOOK):
        versions.new_mismatches()
    graph.asked.clear()
    versions.new_mismatches()
    assert len(graph.asked) == 1
    graph.nodes.append(('bridge', '/rav1'))
    graph.asked.clear()
    for _ in range(3 * TOPICS_A_LOOK):
        versions.new_mismatches()
    # At one topic a look there would be one question a look.
    assert len(graph.asked) > 3 * TOPICS_A_LOOK + 1


def test_vehicle_taken_by_its_pilot_is_a_warning():
    """Values carry their units in their names."""
    state = VehicleState(vehicle='rav1', state=VehicleState.FLYING, battery_fraction=0.5)
    told = vehicle_diagnostic(state)
    values = {value.key: value.value for value in told.values}
    assert (told.name, told.level, told.message) == ('rav1', DiagnosticStatus.OK, 'flying')
    assert values['battery_percent'] == '50.0'
    state.taken_by = 'pilot'
    assert vehicle_diagnostic(state).level == DiagnosticStatus.WARN


class Patient(Node):
    """A node that knows of its health."""

    def health(self):
        """Return two statuses."""
        return [diagnostic('waits', is_warning=True), diagnostic('flies', name='rav1')]


def test_nodes_report_their_health(ros):
    """One status a node with its full name and values, and those that it tells of others."""
    plain = Node('plain', namespace='/fleet', context=ros.context)
    patient = Patient('patient', context=ros.context)
    for node in (plain, patient):
        ros.executor.add_node(node)
    heard = {}
    topics.create_subscription(
        plain, topics.DIAGNOSTICS, lambda m: heard.update({s.name: s for s in m.status})
    )
    reporters = [HealthReporter(node) for node in (plain, patient)]
    ros.spin_until(lambda: {'/fleet/plain', '/patient', 'rav1'} <= set(heard), DEADLINE_S)
    assert heard['/patient'].level == DiagnosticStatus.WARN
    assert {'process_id', 'uptime_s'} <= {value.key for value in heard['/fleet/plain'].values}
    for reporter, node in zip(reporters, (plain, patient), strict=True):
        reporter.close()
        ros.executor.remove_node(node)
        node.destroy_node()
