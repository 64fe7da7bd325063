# SPDX-License-Identifier: Apache-2.0
"""What the engine's camera adds to a vehicle: depth, labels, their table, and its refusals."""

import io
import json
import math

import numpy as np
import pytest
from PIL import Image

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from test.scene.scenes import small_environment
from test.sim.flights import ROUTE, START_NS, vehicle_on

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_scene.cameras.camera import Truth
from rocsafe_scene.mesh.classes import class_number
from rocsafe_sim.cameras.camera_settings import CameraSettings
from rocsafe_sim.cameras.mounted_camera import CameraModel, MountedCamera
from rocsafe_sim.messages.picture_conversions import depth_message, labels_message, picture_header
from rocsafe_sim.options import RavOptions
from rocsafe_sim.rav.rav import Rav, RavParts
from rocsafe_sim.sensors.sensing_noise import SensorNoise

DEPTH = np.array([[31.5, np.inf], [30.25, 2.0]], np.float32)
NUMBERS = np.array([[2, 0], [65_535, 70_000]], np.uint32)


class KnowingCamera:
    """A camera of four pixels that knows what it sees."""

    lens = PinholeCamera(math.radians(60.0), 16, 16)
    truth = Truth(depth_m=DEPTH, numbers=NUMBERS)
    remark = 'drawn for a test'

    def __init__(self) -> None:
        self.times_ns: list[int] = []

    def label_table(self) -> str:
        """Return no table."""
        return ''

    def photograph(self, _position, _rotation, time_ns=0, **_quality):
        """Return grey, and remember when."""
        self.times_ns.append(time_ns)
        return np.full((16, 16, 3), 127, np.uint8)


def photographed():
    """Return a vehicle after its first photograph, with it and the camera."""
    camera = KnowingCamera()
    noise = SensorNoise(
        seed=1, vehicle='rav1', gps_horizontal_std_m=0.0, gps_vertical_std_m=0.0,
        tilt_std_rad=0.0, attitude_std_rad=0.0,
    )  # fmt: skip
    frame = LocalFrame(GeoPosition(53.28, -9.06, 60.0))
    settings = CameraSettings(image_width_px=16, image_height_px=16)
    mounted = MountedCamera(CameraModel(settings=settings, camera=camera))
    parts = RavParts(name='rav1', frame=frame, noise=noise, cameras=(mounted,))
    rav = Rav(parts, vehicle_on(ROUTE))
    for time_ns in range(START_NS, START_NS + 600 * 10**9, 10**8):
        _, shots = rav.step(time_ns)
        if shots:
            return rav, shots[0], camera, time_ns
    raise AssertionError('no photograph in ten minutes')


def test_a_photograph_is_taken_at_its_time_and_its_truth_kept_for_the_step():
    """The scene is asked for the moment of the exposure; the next step forgets."""
    rav, shot, camera, time_ns = photographed()
    assert camera.times_ns == [shot.time_ns]
    assert [(p.time_ns, p.truth) for p in rav.pictures] == [(shot.time_ns, camera.truth)]
    rav.step(time_ns + 1)
    assert rav.pictures == []


def test_a_photograph_says_what_drew_it():
    """In a comment of the JPEG file, where that is less than it should be."""
    _, shot, _, _ = photographed()
    with Image.open(io.BytesIO(shot.jpeg)) as image:
        image.load()
        assert image.info['comment'] == b'drawn for a test'


def test_depth_and_labels_as_messages():
    """Floats as they are; instances in 16 bits, the many beyond them as the last."""
    rav, _, camera, _ = photographed()
    header = picture_header('rav1', rav.pictures[0])
    assert header.frame_id == 'rav1/camera_optical'
    depth = depth_message(camera.truth, header)
    assert (depth.encoding, depth.width, depth.height, depth.step) == ('32FC1', 2, 2, 8)
    assert np.array_equal(np.frombuffer(depth.data, '<f4').reshape(2, 2), DEPTH)
    labels = labels_message(camera.truth, header)
    assert (labels.encoding, labels.step) == ('mono16', 4)
    assert np.frombuffer(labels.data, '<u2').tolist() == [2, 0, 65_535, 65_535]


@pytest.mark.slow
def test_the_label_table_names_every_instance():
    """The sky first, then the things in the order of their numbers, then ground by its class."""
    pytest.importorskip('panda3d', reason='panda3d is not installed')
    from rocsafe_scene.cameras.engine_camera import GROUND_NUMBERS, label_table

    rows = json.loads(label_table(small_environment().objects))
    things = [row['number'] for row in rows if row['name'] != 'ground']
    assert things == [0, *range(2, len(things) + 1)]
    objects = small_environment().objects
    tank = rows[1]
    assert np.allclose(tank.pop('place'), objects[0].bounds.mean(axis=0), atol=1e-3)
    assert math.isfinite(tank.pop('yaw'))
    assert tank == {'number': 2, 'name': 'tank', 'class': 'tank_car', 'colour': [222, 226, 230]}
    ground = {row['class']: row['number'] for row in rows if row['name'] == 'ground'}
    assert ground['asphalt'] == GROUND_NUMBERS + class_number('asphalt')
    assert max(ground.values()) < 65_535


def test_ground_is_told_by_what_it_is():
    """Road and grass have different numbers, things keep theirs."""
    pytest.importorskip('panda3d', reason='panda3d is not installed')
    from rocsafe_scene.cameras.engine_camera import GROUND_NUMBERS, reported_numbers
    from rocsafe_scene.graphics.rendering import Rendering

    road, grass, tank = (class_number(name) for name in ('asphalt', 'grass', 'tank_car'))
    shape = (1, 3)
    frame = Rendering(
        image=np.zeros((*shape, 3), np.uint8),
        depth_m=np.ones(shape, np.float32),
        numbers=np.array([[1, 1, 7]], np.uint32),
        classes=np.array([[road, grass, tank]], np.uint8),
        normals=np.zeros((*shape, 3), np.uint8),
    )
    assert reported_numbers(frame).tolist() == [[GROUND_NUMBERS + road, GROUND_NUMBERS + grass, 7]]


@pytest.mark.parametrize(
    ('values', 'text'),
    [
        ({'camera_backend': 'unreal'}, "camera_backend is 'unreal': must be flat or engine"),
        ({'camera_backend': 'engine'}, "scene_file is ''"),
    ],
)
def test_backends_that_cannot_be_are_refused(values, text):
    """One line that names the option."""
    with pytest.raises(ValueError, match=text):
        RavOptions(**values)
