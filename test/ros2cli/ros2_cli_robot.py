# SPDX-License-Identifier: Apache-2.0
"""A node with one of everything, for the ros2 command to look at."""

import array
import math
from collections.abc import Callable
from threading import Event, Thread
from typing import Any

import rclpy
from rcl_interfaces.msg import FloatingPointRange, ParameterDescriptor
from rclpy.action import ActionServer, CancelResponse, GoalResponse
from rclpy.callback_groups import ReentrantCallbackGroup
from rclpy.context import Context
from rclpy.executors import MultiThreadedExecutor
from rclpy.node import Node
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from sensor_msgs.msg import CompressedImage, NavSatFix
from std_msgs.msg import String
from std_srvs.srv import SetBool

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import Region

PERIOD_S = 0.05
STEP_S = 0.1
LATCHED = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
BEST_EFFORT = QoSProfile(depth=1, reliability=ReliabilityPolicy.BEST_EFFORT)


class Robot:
    """Node `/rav1/robot`, spinning in a thread; what reached it is in `heard` and `cancelled`."""

    def __init__(self, domain_id: int) -> None:
        self._context = Context()
        rclpy.init(context=self._context, domain_id=domain_id)
        self._node = rclpy.create_node('robot', namespace='/rav1', context=self._context)
        self._executor = MultiThreadedExecutor(num_threads=3, context=self._context)
        self._stopped = Event()
        self.heard: list[str] = []
        self.cancelled = Event()
        self._declare_parameters()
        self._publish()
        self._serve()
        self._executor.add_node(self._node)
        self._thread = Thread(target=self._executor.spin)
        self._thread.start()

    def is_known_to(self, other: Node) -> bool:
        """Whether another node has met all that this one has."""
        looks: tuple[Callable[[Node], list[Any]], ...] = (
            lambda node: node.get_node_names_and_namespaces(),
            lambda node: node.get_topic_names_and_types(),
            lambda node: node.get_service_names_and_types(),
        )
        return all(all(one in look(other) for one in look(self._node)) for look in looks)

    def close(self) -> None:
        """Stop the thread and take the node down."""
        self._stopped.set()
        self._executor.shutdown(timeout_sec=2.0)
        self._thread.join(timeout=2.0)
        self._node.destroy_node()
        rclpy.shutdown(context=self._context)

    def _declare_parameters(self) -> None:
        speeds = ParameterDescriptor(
            floating_point_range=[FloatingPointRange(from_value=0.0, to_value=20.0)]
        )
        self._node.declare_parameter('speed_mps', 5.0, speeds)
        self._node.declare_parameter('names', ['a', 'b'])
        self._node.declare_parameter('count', 3)
        self._node.declare_parameter('battery.cells', [1, 2])

    def _publish(self) -> None:
        self._fix = self._node.create_publisher(NavSatFix, 'fix', BEST_EFFORT)
        self._image = self._node.create_publisher(CompressedImage, 'image', 10)
        self._region = self._node.create_publisher(Region, '/region', LATCHED)
        self._region.publish(Region(name='yard'))
        self._node.create_subscription(String, 'command', self._hear, 10)
        self._node.create_timer(PERIOD_S, self._tick)

    def _hear(self, message: String) -> None:
        self.heard.append(message.data)

    def _tick(self) -> None:
        fix = NavSatFix(latitude=52.5, longitude=-1e-7, altitude=math.nan)
        fix.header.frame_id = 'gps'
        fix.position_covariance[0] = 1.5
        self._fix.publish(fix)
        self._image.publish(CompressedImage(format='jpeg', data=array.array('B', range(200))))

    def _serve(self) -> None:
        self._node.create_service(SetBool, 'switch', self._switch)
        self._action = ActionServer(
            self._node,
            FlyRoute,
            'fly_route',
            self._fly,
            goal_callback=self._judge,
            cancel_callback=lambda _handle: CancelResponse.ACCEPT,
            callback_group=ReentrantCallbackGroup(),
        )

    def _switch(self, request: SetBool.Request, response: SetBool.Response) -> SetBool.Response:
        response.success = request.data
        response.message = 'on' if request.data else 'off'
        return response

    def _judge(self, goal: FlyRoute.Goal) -> GoalResponse:
        return GoalResponse.REJECT if goal.plan_id == 'bad' else GoalResponse.ACCEPT

    def _fly(self, handle: object) -> FlyRoute.Result:
        steps = 2 if handle.request.plan_id != 'long' else 200
        for index in range(steps):
            if handle.is_cancel_requested or self._stopped.is_set():
                handle.canceled()
                self.cancelled.set()
                return FlyRoute.Result(outcome=FlyRoute.Result.CANCELLED)
            handle.publish_feedback(FlyRoute.Feedback(viewpoint_index=index))
            self._stopped.wait(STEP_S)
        handle.succeed()
        return FlyRoute.Result(viewpoints_visited=2)
