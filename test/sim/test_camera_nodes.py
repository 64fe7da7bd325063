# SPDX-License-Identifier: Apache-2.0
"""Cameras of vehicles over real topics: several of them, gimbals, streams."""

import math
from typing import Any

import cv2
import numpy as np
import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from std_srvs.srv import SetBool
from test.sim.node_stand import DEADLINE_S, SMALL, Operator, route

from rocsafe_interfaces.msg import GimbalCommand
from rocsafe_interfaces.srv import Look, SetFieldOfView
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec, of_camera
from rocsafe_scene.cameras.camera import Truth
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.cameras.mounted_camera import CameraModel
from rocsafe_sim.rav.shared_parts import SharedParts

DEPTH = np.array([[31.5, np.inf, 2.25], [30.25, 2.0, 40.5]], np.float32)
NUMBERS = np.array([[2, 0, 70_000], [65_535, 3, 1]], np.uint32)
TABLE = '[{"number": 0, "name": "sky", "class": "sky", "colour": [135, 190, 235]}]'
TINY = {'image_width_px': 48, 'image_height_px': 32}
FRONT = {'name': 'front', 'pitch_deg': -60, **TINY}
TURNED = {
    'name': 'turned', 'horizontal_fov_deg': 40, 'gimbal': True, 'gimbal_rate_dps': 30,
    'gimbal_highest_deg': -50, **TINY,
}  # fmt: skip


def of(camera: str, spec: TopicSpec) -> TopicSpec:
    """Return a topic of the first camera as that of another."""
    return of_camera(spec, camera)


def pixels(message: Any) -> Any:
    """Return the picture of a raw image message."""
    return np.frombuffer(message.data, np.uint8).reshape(message.height, message.width, 3)


def test_every_camera_takes_a_picture_at_a_viewpoint(
    operator: Operator, world: Any, rav: Any
) -> None:
    """Each on its own topics, at the same moment, with its own intrinsics and pose."""
    world('rav1', autostart=False)
    vehicle = rav(cameras=(SMALL, FRONT))
    shots = operator.store_shots()
    images = operator.listen(of('front', topics.CAMERA_IMAGE))
    infos = operator.listen(of('front', topics.CAMERA_INFO))
    poses = operator.listen(of('front', topics.CAMERA_POSE))
    jpegs = operator.listen(of('front', topics.CAMERA_IMAGE_COMPRESSED))
    first = operator.listen(topics.CAMERA_IMAGE)
    sender = operator.send(route(count=1))
    operator.wait_until_heard(
        vehicle,
        of('front', topics.CAMERA_IMAGE),
        of('front', topics.CAMERA_POSE),
        topics.CAMERA_IMAGE,
    )
    operator.call('world/run', SetBool.Request(data=True))
    operator.wait(sender.get_result_async())
    operator.ros.spin_until(
        lambda: all(map(len, (shots, images, infos, poses, jpegs, first))), DEADLINE_S
    )
    assert infos[0].width == images[0].width == 48
    assert infos[0].k[0] == pytest.approx(24.0 / math.tan(math.radians(30.0)))
    stamps = {ns_of_stamp(m.header.stamp) for m in (shots[0], images[0], infos[0], poses[0])}
    assert len(stamps) == 1
    assert images[0].header.frame_id == 'rav1/front_optical'
    assert pixels(first[0]).shape == (48, 64, 3)
    decoded = cv2.imdecode(np.frombuffer(jpegs[0].data, np.uint8), cv2.IMREAD_COLOR)
    assert np.abs(decoded.astype(int) - pixels(images[0])).mean() < 8.0
    q = poses[0].pose.orientation
    ahead_up = 1.0 - 2.0 * (q.x * q.x + q.y * q.y)
    # 60 deg below the horizon, but for the vehicle's sway
    assert ahead_up == pytest.approx(-math.sin(math.radians(60.0)), abs=0.05)


def test_a_gimbal_obeys_and_says_where_it_points(operator: Operator, world: Any, rav: Any) -> None:
    """It turns at its rate of simulated time, stops at its limit, and a nonsense is not obeyed."""
    world('rav1', speed=5.0)
    vehicle = rav(cameras=(SMALL, TURNED))
    states = operator.listen(of('turned', topics.GIMBAL_STATE))
    commands = topics.create_publisher(operator.node, of('turned', topics.GIMBAL_COMMAND), 'rav1')
    operator.ros.spin_until(lambda: bool(states), DEADLINE_S)
    assert states[0].is_settled
    assert states[0].pitch_rad == pytest.approx(-math.pi / 2)
    operator.ros.spin_until(
        lambda: (
            commands.get_subscription_count() > 0
            and vehicle.count_publishers('/rav1/turned/gimbal/command') > 0
        ),
        DEADLINE_S,
    )
    commands.publish(GimbalCommand(pitch_rad=math.nan))
    commands.publish(GimbalCommand(pitch_rad=0.0, yaw_rad=math.radians(60.0)))
    operator.ros.spin_until(lambda: states[-1].is_settled and states[-1].yaw_rad > 0.5, DEADLINE_S)
    assert states[-1].pitch_rad == pytest.approx(math.radians(-50.0))
    assert states[-1].yaw_rad == pytest.approx(math.radians(60.0))
    moving = [state for state in states if not state.is_settled]
    times_s = [ns_of_stamp(state.header.stamp) / 1e9 for state in moving]
    assert len(moving) > 5
    rates = np.diff([state.yaw_rad for state in moving]) / np.diff(times_s)
    assert np.degrees(rates) == pytest.approx(np.full(len(rates), 30.0), abs=0.1)


def test_looks_and_streams_have_the_field_of_view_that_is_set(
    operator: Operator, world: Any, rav: Any
) -> None:
    """With their camera_info; photographs of the survey keep the scenario's, as their record."""
    world('rav1', autostart=False)
    vehicle = rav(cameras=(SMALL, FRONT))
    shots, infos = operator.store_shots(), operator.listen(topics.CAMERA_INFO)
    set_fov, look = calls.SET_FOV.name, calls.LOOK.name

    def focal_px() -> float:
        return operator.ask(Look, f'rav1/{look}', Look.Request()).camera_info.k[0]

    before = focal_px()
    narrow = SetFieldOfView.Request(horizontal_fov_deg=30.0)
    assert operator.ask(SetFieldOfView, f'rav1/{set_fov}', narrow).success
    assert focal_px() == pytest.approx(32.0 / math.tan(math.radians(15.0)))
    refused = operator.ask(
        SetFieldOfView, f'rav1/{set_fov}', SetFieldOfView.Request(horizontal_fov_deg=151.0)
    )
    assert refused.message.startswith('rav1: camera: horizontal_fov_deg is 151')
    sender = operator.send(route(count=1))
    operator.wait_until_heard(vehicle, topics.CAMERA_INFO)
    operator.call('world/run', SetBool.Request(data=True))
    operator.wait(sender.get_result_async())
    operator.ros.spin_until(lambda: bool(shots and infos), DEADLINE_S)
    assert infos[-1].k[0] == shots[0].camera_info.k[0] == before
    back = SetFieldOfView.Request(horizontal_fov_deg=CameraSettings(**SMALL).horizontal_fov_deg)
    assert operator.ask(SetFieldOfView, f'rav1/{set_fov}', back).success
    assert focal_px() == before


def test_a_stream_runs_at_its_rate_while_somebody_looks(
    operator: Operator, world: Any, rav: Any
) -> None:
    """At multiples of its period of simulated time; nobody looking, nothing is drawn."""
    world('rav1', speed=8.0)
    rav(cameras=({**SMALL, 'stream_rate_hz': 2.5},))
    infos = operator.listen(topics.CAMERA_INFO)
    fixes = operator.listen(topics.FIX)
    operator.ros.spin_until(lambda: len(fixes) > 12, DEADLINE_S)
    assert infos == []
    images: list[Any] = []
    eye = topics.create_subscription(operator.node, topics.CAMERA_IMAGE, images.append, 'rav1')
    operator.ros.spin_until(lambda: len(images) >= 6, DEADLINE_S)
    stamps = [ns_of_stamp(image.header.stamp) for image in images]
    assert set(np.diff(stamps)) == {400_000_000}
    assert stamps[0] % 400_000_000 == 0
    operator.ros.spin_until(
        lambda: set(stamps) <= {ns_of_stamp(info.header.stamp) for info in infos}, DEADLINE_S
    )
    assert pixels(images[0]).std() > 1.0
    operator.node.destroy_subscription(eye)
    said = len(fixes)
    operator.ros.spin_until(lambda: len(fixes) > said + 25, DEADLINE_S)
    count = len(infos)
    operator.ros.spin_until(lambda: len(fixes) > said + 50, DEADLINE_S)
    assert len(infos) == count


def test_for_a_recorder_alone_nothing_is_streamed(ros: Any, world: Any, rav: Any) -> None:
    """Nor for the collector of labels. It hears what is taken at viewpoints or for a viewer."""
    world('rav1', speed=5.0)
    rav(cameras=({**SMALL, 'stream_rate_hz': 5.0},))
    recorder, viewer = Operator(ros, 'recorder'), Operator(ros, 'viewer')
    collector = Operator(ros, 'collector')
    collector.listen(topics.CAMERA_LABELS)
    recorded = recorder.listen(topics.CAMERA_IMAGE_COMPRESSED)
    fixes = recorder.listen(topics.FIX)
    ros.spin_until(lambda: len(fixes) > 20, DEADLINE_S)
    assert recorded == []
    watched = viewer.listen(topics.CAMERA_IMAGE_COMPRESSED)
    ros.spin_until(lambda: len(watched) > 3 and len(recorded) > 3, DEADLINE_S)
    for node in (recorder.node, viewer.node, collector.node):
        node.destroy_node()


class KnowingCamera:
    """Draws six grey pixels and knows what they show."""

    lens = CameraSettings().lens
    truth = Truth(depth_m=DEPTH, numbers=NUMBERS)

    def label_table(self) -> str:
        """Return the table of its labels."""
        return TABLE

    def photograph(self, *_pose: Any, **_quality: Any) -> Any:
        """Return grey."""
        return np.full((2, 3, 3), 127, np.uint8)


def test_depth_and_labels_are_streamed_with_their_table(
    operator: Operator, world: Any, rav: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Floats in metres, numbers in 16 bits, and a latched table that says what they mean."""
    model = CameraModel(settings=CameraSettings(stream_rate_hz=5.0), camera=KnowingCamera())
    shared = SharedParts(cameras=(model,), surroundings=None)
    monkeypatch.setattr('rocsafe_sim.rav_node.make_shared', lambda _options: shared)
    world('rav1', speed=5.0)
    rav()
    depths, labels = operator.listen(topics.CAMERA_DEPTH), operator.listen(topics.CAMERA_LABELS)
    operator.ros.spin_until(lambda: depths and labels, DEADLINE_S)
    tables = operator.listen(topics.CAMERA_LABEL_TABLE)
    operator.ros.spin_until(lambda: bool(tables), DEADLINE_S)
    assert tables[0].data == TABLE
    assert (depths[0].encoding, depths[0].step) == ('32FC1', 12)
    assert np.array_equal(np.frombuffer(depths[0].data, '<f4').reshape(2, 3), DEPTH)
    assert (labels[0].encoding, labels[0].step) == ('mono16', 6)
    assert np.frombuffer(labels[0].data, '<u2').tolist() == [2, 0, 65_535, 65_535, 3, 1]
    assert depths[0].header.frame_id == labels[0].header.frame_id == 'rav1/camera_optical'
