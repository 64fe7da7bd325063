# SPDX-License-Identifier: Apache-2.0
"""World and vehicles as nodes, and an operator who listens to them, for tests."""

from pathlib import Path
from typing import Any

from rclpy.action import ActionClient
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger
from test.sim.vehicle_files import autopilot_file, cameras_file

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import GeoPoint, Route, ShotReceipt, Viewpoint
from rocsafe_interfaces.srv import Lease
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec

ORIGIN = GeoPosition(53.28, -9.06, 60.0)
FRAME = LocalFrame(ORIGIN)
START_S = 1_700_000_000.0
HOME_ENU = (-20.0, 5.0, 0.0)
SMALL = {'image_width_px': 64, 'image_height_px': 48}
# Fast, so that flights are short.
BRISK = {
    'jerk_mps3': 20.0,
    'vertical_acceleration_mps2': 5.0,
    'vertical_jerk_mps3': 20.0,
    'landing_height_m': 0.0,
    'landing_speed_mps': 5.0,
    'home_wait_s': 0.0,
}
DEADLINE_S = 60.0


def common(folder: Path, *cameras: dict[str, Any]) -> dict[str, Any]:
    """Return parameters of small, fast vehicles, whose files are written to `folder`."""
    return {
        'origin_latitude_deg': ORIGIN.latitude_deg,
        'origin_longitude_deg': ORIGIN.longitude_deg,
        'origin_altitude_m': ORIGIN.altitude_m,
        'cameras_file': cameras_file(folder, *(cameras or (SMALL,))),
        'autopilot_file': autopilot_file(folder, **BRISK),
        'hover_s': 0.5,
        'climb_rate_mps': 5.0,
        'descent_rate_mps': 5.0,
    }


def parameters(**values: Any) -> list[Parameter]:
    """Return parameter overrides."""
    return [Parameter(name, value=value) for name, value in values.items()]


def point(enu: tuple[float, float, float]) -> GeoPoint:
    """Return a local point as a message."""
    place = FRAME.position_of(enu)
    return GeoPoint(
        latitude=place.latitude_deg, longitude=place.longitude_deg, altitude=place.altitude_m
    )


def route(vehicle: str = 'rav1', count: int = 4) -> Route:
    """Return a route over `count` viewpoints in a row, 8 m apart."""
    return Route(
        vehicle=vehicle,
        home=point(HOME_ENU),
        viewpoints=[
            Viewpoint(
                id=10 + number,
                position=point((8.0 * number, 0.0, 20.0)),
                height_agl_m=20.0,
                yaw_rad=0.3,
            )
            for number in range(count)
        ],
    )


class Operator:
    """A test's own node: sends commands, keeps what it hears, gives receipts if told to."""

    def __init__(self, ros: Any, name: str = 'operator') -> None:
        self.ros = ros
        self.node = Node(name, context=ros.context)
        ros.executor.add_node(self.node)
        self.heard: dict[str, list[Any]] = {}
        self.gives_receipts = False
        self._receipts = topics.create_publisher(self.node, topics.RECEIPTS)

    def listen(self, spec: TopicSpec, vehicle: str = 'rav1') -> list[Any]:
        """Return a list that fills with the messages of a topic."""
        heard: list[Any] = []
        topics.create_subscription(self.node, spec, heard.append, vehicle)
        return heard

    def wait_until_heard(self, node: Node, *specs: TopicSpec) -> None:
        """Wait until the publishers of a vehicle's node have found who listens to them."""
        names = {f'{node.get_namespace()}/{spec.name}' for spec in specs}
        found = [each for each in node.publishers if each.topic_name in names]
        assert len(found) == len(names)
        self.ros.spin_until(
            lambda: all(each.get_subscription_count() for each in found), DEADLINE_S
        )

    def store_shots(self, vehicle: str = 'rav1') -> list[Any]:
        """Return a list that fills with photographs; each gets a receipt if that is wanted."""
        shots: list[Any] = []

        def on_shot(message: Any) -> None:
            shots.append(message)
            if self.gives_receipts:
                self._receipts.publish(
                    ShotReceipt(
                        vehicle=message.vehicle,
                        shot_id=message.shot_id,
                        sha256=message.sha256,
                        status=ShotReceipt.STORED,
                    )
                )

        topics.create_subscription(self.node, topics.SHOT, on_shot, vehicle)
        return shots

    def wait(self, future: Any) -> Any:
        """Return the result of a future."""
        self.ros.spin_until(future.done, DEADLINE_S)
        return future.result()

    def call(self, name: str, request: Any) -> Any:
        """Return the response of a service."""
        service_type = SetBool if isinstance(request, SetBool.Request) else Trigger
        return self.ask(service_type, name, request)

    def ask(self, service_type: Any, name: str, request: Any) -> Any:
        """Return the response of a service of any type."""
        client = self.node.create_client(service_type, name)
        self.ros.spin_until(client.service_is_ready, DEADLINE_S)
        return self.wait(client.call_async(request))

    def lease(self, vehicle: str = 'rav1', **fields: Any) -> str:
        """Take the lease of a vehicle and return what orders carry."""
        request = Lease.Request(holder='operator', duration_s=600.0, **fields)
        answer = self.ask(Lease, f'{vehicle}/lease', request)
        assert answer.success, answer.message
        return str(answer.control.lease)

    def order(self, service_type: Any, name: str, vehicle: str = 'rav1', **fields: Any) -> Any:
        """Return the response to an order that carries the lease."""
        request = service_type.Request(lease=self.lease(vehicle), **fields)
        return self.ask(service_type, f'{vehicle}/{name}', request)

    def send(self, message: Route, plan_id: str = 'plan', feedback: Any = None) -> Any:
        """Send a route; return the goal's handle."""
        client = ActionClient(self.node, FlyRoute, f'{message.vehicle or "rav1"}/fly_route')
        self.ros.spin_until(client.server_is_ready, DEADLINE_S)
        lease = self.lease(message.vehicle or 'rav1')
        goal = FlyRoute.Goal(route=message, plan_id=plan_id, lease=lease)
        return self.wait(client.send_goal_async(goal, feedback_callback=feedback))

    def fly(self, message: Route, plan_id: str = 'plan', feedback: Any = None) -> Any:
        """Send a route and return status and result at its end."""
        return self.wait(self.send(message, plan_id, feedback).get_result_async())
