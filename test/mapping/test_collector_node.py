# SPDX-License-Identifier: Apache-2.0
"""The collector answers every photograph, and only with the truth."""

import hashlib

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import NavSatStatus

from rocsafe_interfaces.msg import GeotaggedImage, ShotReceipt
from rocsafe_mapping import store
from rocsafe_mapping.catalogue import read_shot
from rocsafe_mapping.collector_node import CollectorNode
from rocsafe_ros import topics
from rocsafe_ros.conversions import quaternion_message, stamp_of_ns
from rocsafe_ros.parameters import ParameterError

DEADLINE_S = 5.0


def message_of(record, image):
    """Return a photograph as its vehicle sends it."""
    message = GeotaggedImage(
        shot_id=record.shot_id,
        vehicle=record.vehicle,
        sequence=record.sequence,
        viewpoint_id=record.viewpoint_id,
        height_agl_m=record.height_agl_m,
        orientation=quaternion_message(record.orientation_xyzw),
        sha256=record.sha256,
    )
    message.header.stamp = stamp_of_ns(record.time_ns)
    message.fix.latitude, message.fix.longitude = record.latitude_deg, record.longitude_deg
    message.fix.altitude = record.altitude_m
    message.fix.status.status = NavSatStatus.STATUS_FIX
    message.fix.position_covariance = record.position_covariance_m2
    camera = record.camera
    message.camera_info.width, message.camera_info.height = camera.width_px, camera.height_px
    message.camera_info.k[0], message.camera_info.k[4] = camera.fx_px, camera.fy_px
    message.camera_info.k[2], message.camera_info.k[5] = camera.cx_px, camera.cy_px
    message.image.data = image
    return message


def parameters(directory):
    """Return the parameters of a collector."""
    values = {'vehicles': ['rav1'], 'store_directory': str(directory)}
    return [Parameter(name, value=value) for name, value in values.items()]


class Bench:
    """A collector and a vehicle."""

    def __init__(self, ros, directory):
        self.ros = ros
        self.directory = directory
        self.receipts = []
        self.node = CollectorNode(
            context=ros.context, parameter_overrides=parameters(self.directory)
        )
        self.drone = Node('drone', context=ros.context)
        self.shots = topics.create_publisher(self.drone, topics.SHOT, 'rav1')
        topics.create_subscription(self.drone, topics.RECEIPTS, self.receipts.append)
        for node in (self.node, self.drone):
            ros.executor.add_node(node)
        ros.spin_until(
            lambda: (
                self.shots.get_subscription_count() == 1
                and self.node.count_subscribers(topics.RECEIPTS.name) == 1
            ),
            DEADLINE_S,
        )

    def send(self, message):
        """Return the receipt for `message`."""
        count = len(self.receipts)
        self.shots.publish(message)
        self.ros.spin_until(lambda: len(self.receipts) > count, DEADLINE_S)
        return self.receipts[-1]

    def close(self):
        """Take the nodes down."""
        for node in (self.node, self.drone):
            self.ros.executor.remove_node(node)
            node.destroy_node()


@pytest.fixture
def bench(ros, tmp_path):
    """A collector with an empty store."""
    bench = Bench(ros, tmp_path / 'images')
    yield bench
    bench.close()


def test_a_photograph_is_stored_and_acknowledged(bench, shot):
    """What is acknowledged is on disk with the record of the message."""
    record, image = shot(5)
    receipt = bench.send(message_of(record, image))
    assert (receipt.status, receipt.shot_id) == (ShotReceipt.STORED, 'rav1-00005')
    assert receipt.sha256 == record.sha256
    assert receipt.path == str(bench.directory / 'rav1-00005.jpg')
    assert read_shot(bench.directory, 'rav1-00005').record == record


def test_a_photograph_sent_again_is_acknowledged_as_a_duplicate(bench, shot):
    """The first receipt may have been lost."""
    bench.send(message_of(*shot()))
    receipt = bench.send(message_of(*shot()))
    assert receipt.status == ShotReceipt.DUPLICATE
    assert receipt.path.endswith('rav1-00000.jpg')


def test_a_photograph_that_makes_no_sense_is_rejected_and_kept_apart(bench, shot):
    """With the reason, and the pixels are not lost."""
    record, image = shot()
    message = message_of(record, image)
    message.shot_id = '../../rav1-00000'
    receipt = bench.send(message)
    assert receipt.status == ShotReceipt.REJECTED
    assert "must be 'rav1-00000'" in receipt.reason
    kept = bench.directory / 'rejected' / hashlib.sha256(image).hexdigest()
    assert kept.read_bytes() == image


def test_a_full_disk_gives_no_receipt_and_the_collector_goes_on(bench, shot, monkeypatch):
    """The vehicle keeps what is not acknowledged."""

    def refuse(*_arguments):
        raise OSError(28, 'No space left on device')

    with monkeypatch.context() as patch:
        patch.setattr(store, 'write_part', refuse)
        bench.shots.publish(message_of(*shot(0)))
        bench.ros.spin_until(lambda: bench.node._failing, DEADLINE_S)
    receipt = bench.send(message_of(*shot(0)))
    assert receipt.status == ShotReceipt.STORED
    assert len(bench.receipts) == 1


def test_a_store_in_use_is_a_wrong_parameter(ros, bench):
    """One line and exit code 2, no traceback."""
    with pytest.raises(ParameterError, match=r'store_directory: image store .* is in use'):
        CollectorNode(context=ros.context, parameter_overrides=parameters(bench.directory))
