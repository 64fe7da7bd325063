# SPDX-License-Identifier: Apache-2.0
"""The node ``viewer``: a live view of the scene of a mission, with its vehicles and lines."""

from functools import partial
from typing import Any

from nav_msgs.msg import Odometry, Path
from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_msgs.msg import Header
from visualization_msgs.msg import MarkerArray

from rocsafe_interfaces.srv import SetLight
from rocsafe_ros.conversions import MAP_FRAME, jpeg_message, stamp_of_ns
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run
from rocsafe_scene.cameras.ground_camera import jpeg_of
from rocsafe_scene.errors import ViewError
from rocsafe_scene.live.live_view import DrawnLine, LiveView, Sight, pose_at, pose_behind
from rocsafe_scene.live.window import Window
from rocsafe_sim.messages.light_conversions import light_of
from rocsafe_sim.messages.view_conversions import lines_of, sight_of, track_of
from rocsafe_sim.viewer_options import ViewerOptions

JPEG_QUALITY = 85
TITLE = 'ROCSAFE: 0 overview, 1 to 9 behind a vehicle, q ends'


class ViewerNode(Node):
    """Draws the scene with vehicles, their tracks and routes, and the drawings of programs.

    Publishes scene/view while anybody listens. Service: scene/set_light. Subscribes: odom, path,
    route_markers of the vehicles; drawings. It is not part of a mission, which never waits for it.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('viewer', **node_options)
        self._options = declare_options(self, ViewerOptions)
        self._follow = self._options.follow
        self._sights: dict[str, Sight] = {}
        self._lines: dict[str, list[DrawnLine]] = {}
        try:
            self._view = LiveView(self._options.scene(), self._options.lens)
            self._window = Window(TITLE) if self._options.window else None
        except ViewError as error:
            raise ParameterError(f'viewer: {error}') from error
        self._publisher = topics.create_publisher(self, topics.SCENE_VIEW)
        self.create_service(SetLight, calls.SET_SCENE_LIGHT.name, self._on_light)
        for number, name in enumerate(self._options.vehicles):
            for spec, heard in (
                (topics.ODOM, partial(self._on_odom, name)),
                (topics.PATH, partial(self._on_path, number, name)),
                (topics.ROUTE_MARKERS, partial(self._on_markers, f'{name} route')),
            ):
                topics.create_subscription(self, spec, heard, name)
        topics.create_subscription(self, topics.DRAWINGS, partial(self._on_markers, 'drawings'))
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(1.0 / self._options.rate_hz, self._on_timer, clock=steady)

    @property
    def is_wanted(self) -> bool:
        """Whether its window, if it has one, is open."""
        return self._window is None or self._window.is_open

    def _on_odom(self, name: str, message: Odometry) -> None:
        self._sights[name] = sight_of(name, message)

    def _on_path(self, number: int, name: str, message: Path) -> None:
        self._lines[name] = [track_of(number, message)]

    def _on_markers(self, name: str, message: MarkerArray) -> None:
        self._lines[name] = lines_of(message)

    def _on_light(
        self, request: SetLight.Request, response: SetLight.Response
    ) -> SetLight.Response:
        try:
            self._view.set_light(light_of(request, self.get_clock().now().nanoseconds))
        except (ViewError, ValueError) as refusal:
            response.message = str(refusal)
            return response
        response.success = True
        return response

    def _on_timer(self) -> None:
        is_heard = self._publisher.get_subscription_count() > 0
        if self._window is None and not is_heard:
            return
        now_ns = self.get_clock().now().nanoseconds
        lines = [line for drawn in self._lines.values() for line in drawn]
        sights = [self._sights[name] for name in self._options.vehicles if name in self._sights]
        image = self._view.picture(now_ns, self._pose(), sights, lines)
        if is_heard:
            header = Header(stamp=stamp_of_ns(now_ns), frame_id=MAP_FRAME)
            self._publisher.publish(jpeg_message(jpeg_of(image, JPEG_QUALITY), header))
        if self._window is not None:
            for key in self._window.show(image):
                self._obey(key)

    def _pose(self) -> Any:
        followed = self._sights.get(self._follow)
        options = self._options
        return pose_behind(followed) if followed else pose_at(options.eye_m, options.target_m)

    def _obey(self, key: str) -> None:
        vehicles = ('', *self._options.vehicles)
        if key.isdigit() and int(key) < len(vehicles):
            self._follow = vehicles[int(key)]
        elif key == 'q' and self._window is not None:
            self._window.close()


def main() -> int:
    """Run the node until it is asked to stop, or its window is closed."""
    return run(ViewerNode, outlives=lambda node: node.is_wanted)


if __name__ == '__main__':
    raise SystemExit(main())
