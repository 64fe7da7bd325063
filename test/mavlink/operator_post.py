# SPDX-License-Identifier: Apache-2.0
"""A bridge, and an operator who hears and orders."""

import time
from pathlib import Path

from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter
from test.fakes.fake_autopilot import HOME
from test.mavlink.airspace import SEPARATION_M, write_drones

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import MissionState, Route, VehicleState, Viewpoint
from rocsafe_interfaces.srv import Lease
from rocsafe_mavlink.bridge_node import BridgeNode
from rocsafe_ros.conversions import point_of_position
from rocsafe_ros.interfaces import topics
from rocsafe_ros.plan_digest import route_digest

# Of a flight on a machine that does ten other things.
DEADLINE_S = 60.0
HOME_PLACE = GeoPosition(*HOME, 488.0 + SEPARATION_M)


class Ground:
    """A bridge, and an operator who hears and orders."""

    def __init__(self, ros, air, state_directory, drone=None, **options):
        self.ros = ros
        self.air = air
        systems = list(air.copters)
        self.names = [f'rav{system}' for system in systems]
        values = {
            'drones_file': write_drones(Path(state_directory), air.link, systems, **(drone or {})),
            'position_rate_hz': 2.0,
            'origin_latitude_deg': HOME[0],
            'origin_longitude_deg': HOME[1],
            'origin_altitude_m': HOME_PLACE.altitude_m,
            'state_directory': str(state_directory),
            **options,
        }
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        self.bridge = BridgeNode(context=ros.context, parameter_overrides=overrides)
        self.operator = Node('operator', context=ros.context)
        for node in (self.bridge, *self.bridge.vehicle_nodes, self.operator):
            ros.executor.add_node(node)
        self.heard = {}
        self.actions = []
        self.action = ActionClient(self.operator, FlyRoute, 'rav1/fly_route')

    def listen(self, spec, vehicle='rav1'):
        """Keep the messages of a topic from now on; return the list."""
        kept = self.heard.setdefault((spec.name, vehicle), [])
        topics.create_subscription(self.operator, spec, kept.append, vehicle)
        return kept

    def until(self, condition, deadline_s=DEADLINE_S):
        """Fly and spin until `condition` holds."""

        def is_so():
            self.air.step()
            return condition()

        self.ros.spin_until(is_so, deadline_s)

    def listen_for(self, seconds):
        """Fly and spin for some wall time."""
        end_s = time.monotonic() + seconds
        self.until(lambda: time.monotonic() >= end_s, seconds + DEADLINE_S)

    def call(self, name, kind, **fields):
        """Call a service and return its answer."""
        is_order = 'lease' in kind.Request.get_fields_and_field_types() and kind is not Lease
        if is_order and 'lease' not in fields:
            fields['lease'] = self.lease(name.partition('/')[0])
        client = self.operator.create_client(kind, name)
        with self.air.calm():
            self.until(client.service_is_ready)
            future = client.call_async(kind.Request(**fields))
            self.until(future.done)
        self.operator.destroy_client(client)
        return future.result()

    def lease(self, vehicle='rav1'):
        """Take the lease of a vehicle and return what orders carry."""
        answer = self.call(f'{vehicle}/lease', Lease, holder='operator', duration_s=3600.0)
        assert answer.success, answer.message
        return answer.control.lease

    def fly(self, plan_id='p1', route=None, *, replace=False):
        """Send a route; return the future of its result."""
        route = survey() if route is None else route
        goal = FlyRoute.Goal(
            route=route,
            plan_id=plan_id,
            replace=replace,
            lease=self.lease(),
            confirmation=route_digest(plan_id, route),
        )
        return self.send(goal)

    def send(self, goal):
        """Send a goal; return the future of its result."""
        with self.air.calm():
            self.until(self.action.server_is_ready)
            accepted = self.action.send_goal_async(goal, feedback_callback=self._on_feedback)
            self.until(accepted.done)
        self.goal = accepted.result()
        return self.goal.get_result_async()

    def in_air(self, route=None, deadline_s=DEADLINE_S):
        """Fly a route; return the future of its result when its first viewpoint is behind."""
        result = self.fly(route=route)
        self.listen(topics.STATE)
        self.until(lambda: result.done() or self.seen().viewpoints_visited >= 1, deadline_s)
        assert not result.done(), result.result().result.error_msg
        return result

    def ended(self, result, deadline_s=DEADLINE_S):
        """Return how a flight ended."""
        self.until(result.done, deadline_s)
        return result.result().result

    def _on_feedback(self, message):
        self.heard.setdefault('feedback', []).append(message.feedback)

    def state(self, vehicle='rav1'):
        """Return the newest state that was heard."""
        kept = self.heard.get(('state', vehicle)) or self.listen(topics.STATE, vehicle)
        return kept[-1] if kept else None

    def wait_for_state(self, *states):
        """Wait until the vehicle is in one of `states`."""
        self.listen(topics.STATE)
        self.until(lambda: self.state() is not None and self.state().state in states)

    def seen(self, vehicle='rav1'):
        """Return the newest state that was heard, an unknown one before the first."""
        return self.state(vehicle) or VehicleState()

    def fly_as(self, vehicle, route, plan_id='p1'):
        """Send a route to one of several vehicles; return the future of its result."""
        action = ActionClient(self.operator, FlyRoute, f'{vehicle}/fly_route')
        self.until(action.server_is_ready)
        goal = FlyRoute.Goal(
            route=route,
            plan_id=plan_id,
            lease=self.lease(vehicle),
            confirmation=route_digest(plan_id, route),
        )
        accepted = action.send_goal_async(goal)
        self.until(accepted.done)
        self.actions.append(action)
        return accepted.result().get_result_async()

    def supervise(self):
        """Publish what a mission publishes while it lives."""
        publisher = topics.create_publisher(self.operator, topics.MISSION_STATE)
        publisher.publish(MissionState())
        self.timer = self.operator.create_timer(0.5, lambda: publisher.publish(MissionState()))

    def abandon(self):
        """Stop publishing it."""
        self.timer.cancel()

    def close(self):
        """Destroy the nodes."""
        for action in (self.action, *self.actions):
            action.destroy()
        for node in (*self.bridge.vehicle_nodes, self.bridge, self.operator):
            self.ros.executor.remove_node(node)
            node.destroy_node()


def survey(count=4, vehicle='rav1', *, height_m=15.0, step_m=30.0):
    """Return a route of viewpoints in a row to the north."""
    places = [offset(HOME_PLACE, 0.0, step_m * (n + 1), height_m) for n in range(count)]
    return Route(
        vehicle=vehicle,
        home=point_of_position(HOME_PLACE),
        viewpoints=[
            Viewpoint(id=7 + n, position=point_of_position(place), height_agl_m=height_m)
            for n, place in enumerate(places)
        ],
    )
