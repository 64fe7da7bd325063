# SPDX-License-Identifier: Apache-2.0
"""The collector answers every photograph, and only with the truth."""

import hashlib
import math
import secrets
import threading

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter
from sensor_msgs.msg import Image, NavSatFix, NavSatStatus
from std_msgs.msg import String

from rocsafe_interfaces.msg import GeotaggedImage, ShotReceipt
from rocsafe_mapping.collector_node import CollectorNode
from rocsafe_mapping.photographs.label_images import LabelImages
from rocsafe_mapping.repository.server import Repository
from rocsafe_mapping.store import store
from rocsafe_mapping.store.catalogue import read_shot
from rocsafe_ros.conversions import ns_of_stamp, quaternion_message, stamp_of_ns
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import ParameterError

DEADLINE_S = 60.0


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


def parameters(directory, **changes):
    """Return the parameters of a collector."""
    values = {'vehicles': ['rav1'], 'store_directory': str(directory), **changes}
    return [Parameter(name, value=value) for name, value in values.items()]


class Bench:
    """A collector and a vehicle."""

    def __init__(self, ros, directory, **changes):
        self.ros = ros
        self.directory = directory
        self.receipts = []
        self.node = CollectorNode(
            context=ros.context, parameter_overrides=parameters(self.directory, **changes)
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
    # A line of the evidence log stands by itself: when, where and how surely.
    fix = receipt.fix
    assert (fix.latitude, fix.longitude, fix.altitude) == (
        record.latitude_deg, record.longitude_deg, record.altitude_m,
    )  # fmt: skip
    assert fix.position_covariance_type == NavSatFix.COVARIANCE_TYPE_KNOWN
    assert tuple(fix.position_covariance) == record.position_covariance_m2
    assert tuple(receipt.orientation_covariance) == record.orientation_covariance_rad2
    assert (ns_of_stamp(receipt.taken), receipt.viewpoint_id) == (
        record.time_ns, record.viewpoint_id,
    )  # fmt: skip
    assert receipt.height_agl_m == record.height_agl_m


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
    assert (receipt.fix.latitude, receipt.fix.status.status) != (0.0, NavSatStatus.STATUS_FIX)
    assert math.isnan(receipt.fix.latitude + receipt.height_agl_m)
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


def test_label_images_are_kept_beside_the_photographs(ros, tmp_path, shot):
    """As an engine's camera sends them, with their table."""
    bench = Bench(ros, tmp_path / 'images', store_labels=True)
    labels = topics.create_publisher(bench.drone, topics.CAMERA_LABELS, 'rav1')
    table = topics.create_publisher(bench.drone, topics.CAMERA_LABEL_TABLE, 'rav1')
    ros.spin_until(
        lambda: (
            labels.get_subscription_count() == 1
            and bench.node.count_publishers(labels.topic_name) == 1
        ),
        DEADLINE_S,
    )
    table.publish(String(data='[{"number": 513, "class": "tree"}]'))
    record, image = shot()
    message = Image(encoding='mono16', width=2, height=1, step=4, data=[1, 2, 0, 0])
    message.header.stamp = stamp_of_ns(record.time_ns)
    labels.publish(message)
    bench.send(message_of(record, image))
    folder = bench.directory / 'labels'
    wanted = {'rav1-00000.png', 'table.json'}
    try:
        ros.spin_until(
            lambda: folder.is_dir() and wanted == {path.name for path in folder.iterdir()},
            DEADLINE_S,
        )
        assert LabelImages(folder).of('rav1-00000').tolist() == [[1, 0]]
    finally:
        bench.close()


def test_copies_bring_the_token_of_a_file(ros, tmp_path, shot):
    """A repository that asks for a token gets it from the collector."""
    token = secrets.token_hex(32)
    (tmp_path / 'token').write_text(f'{token}\n')
    (tmp_path / 'token').chmod(0o600)
    server = Repository(tmp_path / 'far', ('127.0.0.1', 0), token=token)
    thread = threading.Thread(target=server.serve_forever, kwargs={'poll_interval': 0.01})
    thread.start()
    bench = Bench(
        ros, tmp_path / 'images', copy_to=f'http://127.0.0.1:{server.server_address[1]}',
        copy_token_file=str(tmp_path / 'token'),
    )  # fmt: skip
    try:
        bench.send(message_of(*shot()))
        ros.spin_until(lambda: (tmp_path / 'far' / 'rav1-00000.jpg').exists(), DEADLINE_S)
    finally:
        bench.close()
        server.shutdown()
        thread.join(DEADLINE_S)
        server.server_close()


@pytest.mark.parametrize('content', [None, ' \n', 'secret'])
def test_a_token_file_without_a_token_is_a_wrong_parameter(ros, tmp_path, content):
    """Missing, empty or weak: said at the start, not with every copy."""
    if content is not None:
        (tmp_path / 'token').write_text(content)
        (tmp_path / 'token').chmod(0o600)
    changes = {'copy_to': 'http://127.0.0.1:9', 'copy_token_file': str(tmp_path / 'token')}
    with pytest.raises(ParameterError, match=r'copy_token_file: .*token'):
        CollectorNode(
            context=ros.context, parameter_overrides=parameters(tmp_path / 'images', **changes)
        )
