# SPDX-License-Identifier: Apache-2.0
"""The live view of a scene: what it draws, and who sees it."""

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from geometry_msgs.msg import Point, PoseStamped
from nav_msgs.msg import Odometry, Path
from std_msgs.msg import ColorRGBA
from test.sim.node_stand import DEADLINE_S, Operator, parameters
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_interfaces.srv import SetLight
from rocsafe_ros.interfaces import calls, topics
from rocsafe_scene.errors import EngineError
from rocsafe_scene.live.live_view import pose_at
from rocsafe_sim import viewer_node
from rocsafe_sim.viewer_options import ViewerOptions

WINDOWLESS = {'scene_file': 'scene.yaml', 'vehicles': ['rav1', 'rgv1'], 'rate_hz': 20.0}


class Drawn:
    """A view that remembers what it was to draw."""

    def __init__(self, *_arguments: Any) -> None:
        self.calls: list[Any] = []
        self.lights: list[Any] = []

    def picture(self, _time_ns: int, pose: Any, sights: Any, lines: Any) -> Any:
        """Remember, and return a grey picture."""
        self.calls.append(SimpleNamespace(pose=pose, sights=list(sights), lines=list(lines)))
        return np.full((16, 16, 3), 127, np.uint8)

    def set_light(self, order: Any) -> None:
        """Take one order."""
        if self.lights:
            raise EngineError('draws without shadows')
        self.lights.append(order)


@pytest.fixture
def viewer(ros: Any, monkeypatch: pytest.MonkeyPatch) -> Any:
    """Give a viewer that follows rgv1, and draws nothing."""
    monkeypatch.setattr(viewer_node, 'LiveView', Drawn)
    values = parameters(**WINDOWLESS, follow='rgv1')
    node = viewer_node.ViewerNode(context=ros.context, parameter_overrides=values)
    ros.executor.add_node(node)
    return node


def test_vehicles_and_lines_are_drawn_while_somebody_looks(
    viewer: Any, operator: Operator
) -> None:
    """Tracks, routes and drawings; from behind the vehicle that is followed."""
    node, spin = operator.node, operator.ros.spin_until
    view: Drawn = viewer._view
    publishers = [
        topics.create_publisher(node, spec, 'rgv1')
        for spec in (topics.ODOM, topics.PATH, topics.ROUTE_MARKERS)
    ]
    spin(lambda: all(each.get_subscription_count() for each in publishers), DEADLINE_S)
    odom = Odometry()
    odom.pose.pose.position = Point(x=10.0, y=5.0, z=1.0)
    steps = [PoseStamped(), PoseStamped()]
    steps[1].pose.position = Point(x=10.0, y=5.0, z=1.0)
    route = Marker(type=Marker.LINE_STRIP, color=ColorRGBA(r=1.0, a=1.0))
    route.points = [Point(), Point(x=3.0), Point(x=3.0, y=4.0)]
    for publisher, message in zip(
        publishers, (odom, Path(poses=steps), MarkerArray(markers=[route])), strict=True
    ):
        publisher.publish(message)
    assert not view.calls, 'nobody looks'
    pictures: list[Any] = []
    topics.create_subscription(node, topics.SCENE_VIEW, pictures.append)
    spin(
        lambda: view.calls and view.calls[-1].sights and len(view.calls[-1].lines) == 2, DEADLINE_S
    )
    drawn = view.calls[-1]
    assert [(one.name, one.place) for one in drawn.sights] == [('rgv1', (10.0, 5.0, 1.0))]
    assert sorted(len(line.places) for line in drawn.lines) == [2, 3]
    assert drawn.lines[-1].colour in ((0, 0, 255), drawn.lines[0].colour)
    assert drawn.pose[0][0] < 10.0 < drawn.pose[0][2] + 10.0
    spin(lambda: pictures, DEADLINE_S)
    assert bytes(pictures[-1].data[:2]) == b'\xff\xd8'


def test_the_light_changes_or_is_refused_with_the_reason(viewer: Any, operator: Operator) -> None:
    """As that of a vehicle's cameras."""
    request = SetLight.Request(sun_as_scenario=True, fog=0.5)
    assert operator.ask(SetLight, calls.SET_SCENE_LIGHT.name, request).success
    assert viewer._view.lights[0].air.fog == 0.5
    assert (
        operator.ask(SetLight, calls.SET_SCENE_LIGHT.name, request).message
        == 'draws without shadows'
    )
    wrong = operator.ask(SetLight, calls.SET_SCENE_LIGHT.name, SetLight.Request(fog=7.0))
    assert 'fog' in wrong.message


@pytest.mark.parametrize(
    ('values', 'words'),
    [
        ({'eye_m': (0.0, 1.0)}, 'eye_m is'),
        ({'eye_m': (0.0, 0.0, 0.0)}, 'target_m is'),
        ({'follow': 'rav7'}, "follow is 'rav7'"),
        ({'scene_file': ''}, "scene_file is ''"),
    ],
)
def test_wrong_parameters_are_named(values: dict[str, Any], words: str) -> None:
    """In one line."""
    with pytest.raises(ValueError, match=words):
        ViewerOptions(**{'scene_file': 's.yaml', 'vehicles': ('rav1',), **values})


def test_the_camera_looks_at_its_target() -> None:
    """Its third axis points there."""
    eye, rotation = pose_at((0.0, -10.0, 10.0), (0.0, 0.0, 0.0))
    assert rotation[:, 2] == pytest.approx([0.0, 0.5**0.5, -(0.5**0.5)])
    assert eye.tolist() == [0.0, -10.0, 10.0]
