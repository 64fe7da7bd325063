# SPDX-License-Identifier: Apache-2.0
"""Orders with values that no honest sender has: each is answered, and the vehicle is there yet."""

import math
import random
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.action import ActionClient
from std_srvs.srv import Trigger
from test.fakes.hostile_message import spoil
from test.sim.node_stand import DEADLINE_S, FRAME, Operator, point, route

from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import GeoPolygon
from rocsafe_interfaces.srv import Lease
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import Scope

RUNS = 800
SERVICES = [
    spec
    for spec in calls.CALLS
    if spec.scope is Scope.VEHICLE
    and hasattr(spec.call_type, 'Request')
    and spec.name not in (calls.LEASE.name, calls.PREFLIGHT.name)
]
HEARD = (topics.CMD_VEL, topics.GIMBAL_COMMAND, topics.RECEIPTS)


def request_of(spec: Any, lease: str) -> Any:
    """Return a request that would be obeyed, as far as one can tell for any service."""
    request = spec.call_type.Request()
    fields = request.get_fields_and_field_types()
    square = [point((0.0, 0.0, 0.0)), point((90.0, 0.0, 0.0)), point((90.0, 90.0, 0.0))]
    for name, kind in fields.items():
        if name == 'lease':
            request.lease = lease
        elif kind.endswith('GeoPoint'):
            setattr(request, name, point((20.0, 10.0, 30.0)))
        elif kind.endswith('GeoPoint>'):
            setattr(request, name, square)
        elif kind.endswith('GeoPolygon>'):
            setattr(request, name, [GeoPolygon(points=square)])
        elif kind == 'double':
            setattr(request, name, 5.0)
    return request


@pytest.mark.all
@pytest.mark.parametrize('seed', [1, 2, 3])
def test_whatever_is_ordered_the_vehicle_answers(operator: Operator, rav: Any, seed: int) -> None:
    """Services, goals and topics with wild numbers, texts and lists; it may fly or stand."""
    rav(lock_step=False, fix_rate_hz=20.0)
    rng = random.Random(seed)
    states = operator.listen(topics.STATE)
    given = operator.ask(Lease, 'rav1/lease', Lease.Request(holder='anna', duration_s=3600.0))
    lease = given.control.lease
    clients = [operator.node.create_client(one.call_type, f'rav1/{one.name}') for one in SERVICES]
    fly = ActionClient(operator.node, FlyRoute, 'rav1/fly_route')
    out = [
        topics.create_publisher(operator.node, spec, 'rav1' if spec.scope is Scope.VEHICLE else '')
        for spec in HEARD
    ]
    operator.ros.spin_until(fly.server_is_ready, DEADLINE_S)
    there = [n for n, client in enumerate(clients) if client.service_is_ready()]
    assert len(there) > 8
    answered = 0
    for number in range(RUNS):
        what = rng.randrange(6)
        share = rng.choice((0.0, 0.1, 0.3, 1.0))
        if what == 0:
            goal = FlyRoute.Goal(route=route(), plan_id=f'p{number}', replace=True)
            goal = spoil(goal, rng, share)
            goal.lease = lease
            operator.wait(fly.send_goal_async(goal))
        elif what == 1:
            index = rng.randrange(len(out))
            out[index].publish(spoil(HEARD[index].message_type(), rng, 1.0))
        else:
            index = rng.choice(there)
            request = spoil(request_of(SERVICES[index], lease), rng, share)
            if hasattr(request, 'lease'):
                request.lease = lease
            answer = operator.wait(clients[index].call_async(request))
            answered += bool(getattr(answer, 'success', False))
    # Some were honest, and were obeyed.
    assert answered > RUNS // 20
    assert operator.call('rav1/hold', Trigger.Request()) is not None
    before = len(states)
    operator.ros.spin_until(lambda: len(states) > before, DEADLINE_S)
    assert {one.vehicle for one in states} == {'rav1'}
    for one in states:
        where = one.position
        assert math.isfinite(where.latitude + where.longitude + where.altitude + one.speed_mps)
        assert FRAME.enu_of(GeoPosition(where.latitude, where.longitude, 60.0)).max() < 5000.0
