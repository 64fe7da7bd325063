# SPDX-License-Identifier: Apache-2.0
"""The router node over real topics and actions."""

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter
from test.ground.villages import position, write_labels, write_village

from rocsafe_ground.router_node import RouterNode
from rocsafe_interfaces.action import PlanGroundRoute
from rocsafe_interfaces.msg import EvidencePoint
from rocsafe_ros.conversions import point_of_position
from rocsafe_ros.interfaces.topics import (
    EVIDENCE,
    GROUND_COSTS,
    GROUND_PATH,
    GROUND_ROUTE,
    create_subscription,
)

# Of a search whose loops are compiled first, on a machine that does ten other things.
DEADLINE_S = 60.0
START, MARK = (-20.0, 7.0), (20.0, 9.0)


class Router:
    """A router node, and a client that asks it."""

    def __init__(self, ros, **parameters):
        overrides = [Parameter(name, value=value) for name, value in parameters.items()]
        self.ros = ros
        self.node = RouterNode(context=ros.context, parameter_overrides=overrides)
        self.client_node = Node('client', context=ros.context)
        self.client = ActionClient(self.client_node, PlanGroundRoute, 'plan_ground_route')
        self.heard, self.routes = {}, []
        for spec in (EVIDENCE, GROUND_COSTS, GROUND_PATH, GROUND_ROUTE):
            create_subscription(
                self.client_node, spec, lambda message, name=spec.name: self.hear(name, message)
            )
        ros.executor.add_node(self.node)
        ros.executor.add_node(self.client_node)
        ros.spin_until(self.client.server_is_ready, DEADLINE_S)

    def hear(self, name, message):
        """Keep the newest message of a topic."""
        self.heard[name] = message
        if name == GROUND_ROUTE.name:
            self.routes.append(message.route_id)

    def ask(self, goal):
        """Return the result of a goal."""
        return self.result_of(self.send(goal))

    def send(self, goal):
        """Send a goal."""
        return self.client.send_goal_async(goal)

    def result_of(self, sent):
        """Wait for the result of a goal that was sent."""
        self.ros.spin_until(sent.done, DEADLINE_S)
        answer = sent.result().get_result_async()
        self.ros.spin_until(answer.done, DEADLINE_S)
        return answer.result().result

    def close(self):
        """Take both nodes down."""
        self.client.destroy()
        self.client_node.destroy_node()
        self.node.destroy_node()


@pytest.fixture
def router(ros, tmp_path):
    """Return a router that writes to ``out``."""
    made = Router(ros, export_directory=str(tmp_path / 'out'))
    yield made
    made.close()


def goal_of(folder, **changes):
    """Return a goal to one mark in a village."""
    values = {
        'vehicle': 'rgv1',
        'start': point_of_position(position(*START)),
        'evidence': [
            EvidencePoint(
                id='drum', kind='mark', position=point_of_position(position(*MARK)),
                priority=1.0, dwell_s=20.0,
            )
        ],
        'dose_budget_usv': 200.0,
        'products': str(folder),
    }  # fmt: skip
    return PlanGroundRoute.Goal(**{**values, **changes})


def test_a_goal_that_is_sent_twice_is_planned_once(router, tmp_path):
    """Both get the one route, which is published and written once; the next one is another."""
    folder = write_village(tmp_path)
    sent = [router.send(goal_of(folder)) for _ in range(2)]
    routes = [router.result_of(one).route.route_id for one in sent]
    assert routes == ['drive-1', 'drive-1']
    assert router.ask(goal_of(folder)).route.route_id == 'drive-2'
    router.ros.spin_until(lambda: 'drive-2' in router.routes, DEADLINE_S)
    assert router.routes == ['drive-1', 'drive-2']
    assert (tmp_path / 'out' / 'again-1' / 'route.json').exists()


def test_a_router_that_is_started_again_keeps_the_drives_before(ros, tmp_path):
    """The next drive has the next number, and a folder of its own."""
    folder, out = write_village(tmp_path), tmp_path / 'out'
    for number, path in enumerate((out, out / 'again-1'), 1):
        made = Router(ros, export_directory=str(out))
        assert made.ask(goal_of(folder)).route.route_id == f'drive-{number}'
        assert (path / 'route.json').exists()
        made.close()
    assert not (out / 'again-2').exists()


def test_goal_gets_its_route(router, tmp_path):
    """Result, latched topics and exported files hold the same route."""
    result = router.ask(goal_of(write_village(tmp_path)))
    assert (result.error_code, result.error_msg) == (PlanGroundRoute.Result.NONE, '')
    route = result.route
    assert [stop.evidence for stop in route.stops if stop.evidence] == ['drum']
    assert str(route.stops[0].position) == str(route.stops[-1].position)
    assert route.dose_usv <= route.dose_upper_usv <= 200.0
    router.ros.spin_until(lambda: len(router.heard) == 4, DEADLINE_S)
    # As text: altitudes are NaN, which equals nothing.
    assert str(router.heard['ground/route']) == str(route)
    path, costs = router.heard['ground/path'], router.heard['ground/costs']
    assert len(path.poses) == len(route.stops)
    assert path.poses[0].pose.position.x == pytest.approx(START[0], abs=costs.info.resolution)
    assert set(costs.data) >= {-1, 100}
    assert max(cost for cost in costs.data if cost < 100) > 50
    assert router.heard['evidence'].points[0].id == 'drum'
    assert (tmp_path / 'out' / 'route.json').is_file()


@pytest.mark.parametrize(
    ('changes', 'code', 'text'),
    [
        ({'dose_budget_usv': 0.001}, PlanGroundRoute.Result.BEYOND_BUDGET, 'takes'),
        ({'dose_budget_usv': -1.0}, PlanGroundRoute.Result.INVALID_REQUEST, 'dose_budget_usv'),
        ({'evidence': []}, PlanGroundRoute.Result.INVALID_REQUEST, 'at least one point'),
        ({'products': '/nowhere'}, PlanGroundRoute.Result.NO_MAP, 'no such folder'),
        (
            {'start': point_of_position(position(900.0, 0.0))},
            PlanGroundRoute.Result.NO_MAP,
            'beyond the map',
        ),
    ],
)
def test_refusal_names_the_reason(router, tmp_path, changes, code, text):
    """By a code and in one line; the router goes on."""
    result = router.ask(goal_of(write_village(tmp_path), **changes))
    assert result.error_code == code
    assert text in result.error_msg


def test_things_of_its_labels_are_evidence_of_a_goal_that_asks_for_them(ros, tmp_path):
    """The result names them, so that what is left can be asked for by name after a drive."""
    folder = write_village(tmp_path)
    made = Router(ros, labels_file=str(write_labels(folder)))
    wanted = {'to_objects': True, 'object_dwell_s': 7.0}
    result = made.ask(goal_of(folder, evidence=[], **wanted))
    assert [one.id for one in result.objects] == ['drum-1', 'drum-2']
    assert {(one.kind, one.dwell_s) for one in result.objects} == {('object', 7.0)}
    stops = {stop.evidence for stop in result.route.stops if stop.evidence}
    assert stops == {'drum-1', 'drum-2'}
    made.ros.spin_until(lambda: 'evidence' in made.heard, DEADLINE_S)
    assert [one.id for one in made.heard['evidence'].points] == ['drum-1', 'drum-2']
    rest = made.ask(goal_of(folder, evidence=result.objects[1:]))
    assert [one.evidence for one in rest.route.stops if one.evidence] == ['drum-2']
    assert rest.objects == []
    twice = made.ask(goal_of(folder, evidence=result.objects[:1], **wanted))
    assert twice.error_msg.startswith('evidence: drum-1 is there twice')
    made.close()


def test_goal_that_asks_for_things_of_a_router_without_labels_is_refused(router, tmp_path):
    """It does not drive to the rest in silence."""
    result = router.ask(goal_of(write_village(tmp_path), to_objects=True))
    assert result.error_code == PlanGroundRoute.Result.NO_MAP
    assert 'labels_file' in result.error_msg
