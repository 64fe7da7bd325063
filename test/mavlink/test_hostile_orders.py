# SPDX-License-Identifier: Apache-2.0
"""Orders to a bridge with values that no honest sender has: each is answered, none flies away."""

import math
import random

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from std_srvs.srv import Trigger
from test.fakes.hostile_message import spoil
from test.mavlink.airspace import Airspace
from test.mavlink.operator_post import HOME_PLACE, Ground, survey

from rocsafe_geo.position import offset
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import GeoPolygon
from rocsafe_ros.conversions import point_of_position
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.plan_digest import route_digest

RUNS = 250
ORDERS = [
    *(calls.HOLD, calls.RESUME, calls.RETURN_HOME, calls.LAND, calls.GO_TO),
    *(calls.SET_SPEED, calls.PUSH_FENCE, calls.PUSH_RALLY, calls.PREFLIGHT),
]
# Of the fake copter from its home, in a survey of 120 m.
FURTHEST_M = 400.0


def request_of(spec):
    """Return a request that would be obeyed, as far as one can tell for any service."""
    request = spec.call_type.Request()
    corners = [(-300.0, -300.0), (300.0, -300.0), (300.0, 300.0), (-300.0, 300.0)]
    square = [point_of_position(offset(HOME_PLACE, *corner)) for corner in corners]
    for name, kind in request.get_fields_and_field_types().items():
        if kind.endswith('GeoPoint'):
            setattr(request, name, point_of_position(offset(HOME_PLACE, 30.0, 40.0)))
        elif kind.endswith('GeoPoint>'):
            setattr(request, name, square[:2])
        elif kind.endswith('GeoPolygon>') and name == 'inclusions':
            setattr(request, name, [GeoPolygon(points=square)])
        elif kind == 'double':
            setattr(request, name, 20.0 if 'height' in name else 5.0)
    return request


@pytest.mark.all
@pytest.mark.parametrize('seed', [1, 2, 3])
def test_whatever_is_ordered_the_bridge_answers(ros, tmp_path, seed):
    """Services and goals with wild numbers, texts and lists, on the ground and in the air."""
    rng, air = random.Random(seed), Airspace()
    ground = Ground(ros, air, tmp_path)
    ground.listen(topics.FIX)
    ground.until(lambda: ground.heard['fix', 'rav1'])
    lease, results, obeyed = ground.lease(), [], 0
    clients = [ground.operator.create_client(o.call_type, f'rav1/{o.name}') for o in ORDERS]
    ground.until(lambda: all(client.service_is_ready() for client in clients))
    for number in range(RUNS):
        share = rng.choice((0.0, 0.05, 0.3, 1.0))
        if rng.random() < 0.3:
            goal = FlyRoute.Goal(route=survey(), plan_id=f'p{number}', replace=rng.random() < 0.5)
            goal = spoil(goal, rng, share)
            goal.lease, goal.confirmation = lease, route_digest(goal.plan_id, goal.route)
            accepted = ground.action.send_goal_async(goal)
            ground.until(accepted.done)
            results.append(accepted.result().get_result_async())
        else:
            index = rng.randrange(len(ORDERS))
            request = spoil(request_of(ORDERS[index]), rng, share)
            if hasattr(request, 'lease'):
                request.lease = lease
            answer = clients[index].call_async(request)
            ground.until(answer.done)
            obeyed += bool(getattr(answer.result(), 'success', False))
        copter = air.copters[1]
        assert math.hypot(*copter.place) < FURTHEST_M
        assert copter.height_m < 130.0
    assert obeyed > RUNS // 20
    assert ground.call('rav1/return_home', Trigger).success
    ground.until(lambda: not air.copters[1].is_armed)
    ground.close()
    air.close()
