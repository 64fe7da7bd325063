# SPDX-License-Identifier: Apache-2.0
"""The map grows with the receipts, is written when asked, and survives a restart."""

import importlib.util
import json
import math
import pathlib
import threading

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

import cv2
import numpy as np
import rasterio
from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_interfaces.msg import ShotReceipt
from rocsafe_mapping.live import map_worker
from rocsafe_mapping.mosaic_node import MosaicNode
from rocsafe_mapping.store.store import ImageStore
from rocsafe_ros.conversions import region_of_area
from rocsafe_ros.interfaces import calls, topics

_spec = importlib.util.spec_from_file_location(
    'ground', pathlib.Path(__file__).with_name('ground.py')
)
ground_truth = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(ground_truth)

DEADLINE_S = 60.0
GALWAY = ground_truth.Ground(LocalFrame(GeoPosition(53.28, -9.06, 57.0)), ())


class Bench:
    """A store, a mosaic node, and somebody who sends receipts and looks at maps."""

    def __init__(self, ros, directory):
        self.ros = ros
        self.directory = directory
        self.output = directory / 'mosaic.tif'
        self.store = ImageStore(directory / 'images')
        self.maps = []
        self.node = None
        self.operator = Node('operator', context=ros.context)
        self.receipts = topics.create_publisher(self.operator, topics.RECEIPTS)
        topics.create_subscription(self.operator, topics.MOSAIC, self.maps.append)
        self.save_client = self.operator.create_client(
            calls.SAVE_MOSAIC.call_type, calls.SAVE_MOSAIC.name
        )
        ros.executor.add_node(self.operator)

    def start(self, **changes):
        """Start the mosaic node."""
        values = {
            'store_directory': str(self.directory / 'images'),
            'output_path': str(self.output),
            **changes,
        }
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        self.node = MosaicNode(context=self.ros.context, parameter_overrides=overrides)
        self.ros.executor.add_node(self.node)
        self.ros.spin_until(self.is_connected, DEADLINE_S)

    def is_connected(self):
        """Whether everything that is published is also heard."""
        return (
            self.receipts.get_subscription_count() == 1
            and self.operator.count_publishers(topics.MOSAIC.name) == 1
            and self.save_client.service_is_ready()
        )

    def put(self, number, **changes):
        """Store a photograph and return its receipt."""
        record, jpeg = ground_truth.plain_photograph(GALWAY, number, 15.0 * number, 0.0)
        record = ground_truth.dataclasses.replace(record, **changes)
        answer = self.store.put(record, jpeg)
        return ShotReceipt(
            shot_id=record.shot_id, status=ShotReceipt.STORED, path=str(answer.path)
        )

    def save(self):
        """Return the answer of the service."""
        future = self.save_client.call_async(calls.SAVE_MOSAIC.call_type.Request())
        self.ros.spin_until(future.done, DEADLINE_S)
        return future.result()

    def wait_for_final(self):
        """Return the map published as final."""
        self.ros.spin_until(lambda: any(m.is_final for m in self.maps), DEADLINE_S)
        return next(message for message in self.maps if message.is_final)

    def stop(self):
        """Take the mosaic node down."""
        self.ros.executor.remove_node(self.node)
        self.node.destroy_node()

    def close(self):
        """Take everything down."""
        if self.node is not None:
            self.stop()
        self.ros.executor.remove_node(self.operator)
        self.operator.destroy_node()
        self.store.close()


@pytest.fixture
def bench(ros, tmp_path):
    """An empty store and no mosaic node yet."""
    bench = Bench(ros, tmp_path)
    yield bench
    bench.close()


def test_a_receipt_puts_its_photograph_on_the_map(bench):
    """Seen at once as a preview, before any file is written."""
    bench.start()
    bench.receipts.publish(bench.put(0))
    bench.ros.spin_until(lambda: bench.maps, DEADLINE_S)
    (message,) = bench.maps
    assert (message.images_placed, message.is_final, message.path) == (1, False, '')
    assert message.preview.format == 'png'
    assert bytes(message.preview.data[:4]) == b'\x89PNG'
    assert message.south_west.latitude < 53.28 < message.north_east.latitude


def test_the_tiles_of_a_saved_map_are_complete(bench):
    """When the answer comes: the mission ends its nodes then, and the tiles are its product."""
    bench.start()
    for number in range(3):
        bench.put(number)
    assert bench.save().success
    bench.stop()
    bench.node = None
    seen = {}
    for path in (bench.directory / 'map/tiles').rglob('*.png'):
        tile = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        zoom = int(path.parts[-3])
        seen[zoom] = seen.get(zoom, 0) + np.count_nonzero(tile[..., 3] > 127)
    finest = max(seen)
    with rasterio.open(bench.output) as file:
        area_m2 = np.count_nonzero(file.dataset_mask()) * file.res[0] ** 2
    pixel_m = 40_075_017 * math.cos(math.radians(53.28)) / 256 / 2**finest
    assert seen[finest] * pixel_m**2 == pytest.approx(area_m2, rel=0.05)
    assert seen[finest - 2] == pytest.approx(seen[finest] / 16, rel=0.2)


def test_saving_places_all_that_is_stored_and_writes_the_file(bench):
    """Whether a receipt came or not."""
    bench.start()
    for number in range(3):
        bench.put(number)
    answer = bench.save()
    assert (answer.success, answer.message) == (True, f'3 photographs in {bench.output}')
    message = bench.wait_for_final()
    assert (message.images_placed, message.path) == (3, str(bench.output))
    with rasterio.open(bench.output) as file:
        assert file.crs.to_epsg() == message.epsg_code == 32629


def test_a_restarted_node_makes_the_same_map(bench):
    """Byte for byte, from the store alone."""
    for number in range(3):
        bench.put(number)
    bench.start()
    bench.save()
    first = bench.output.read_bytes()
    bench.stop()
    bench.output.unlink()
    bench.start()
    bench.save()
    assert bench.output.read_bytes() == first


def test_a_photograph_that_cannot_be_placed_is_left_out_and_told(bench):
    """It is stored all the same."""
    bench.start()
    bench.put(0)
    bench.put(1, height_agl_m=float('nan'))
    answer = bench.save()
    assert answer.success
    assert answer.message.endswith(', 1 could not be placed')
    assert bench.wait_for_final().images_placed == 1


def test_saving_an_empty_map_fails_with_its_reason(bench):
    """No empty file pretends to be a map."""
    bench.start()
    answer = bench.save()
    assert (answer.success, answer.message) == (False, 'no photograph is placed yet')
    assert not bench.output.exists()


def test_a_rejected_photograph_and_an_unknown_one_are_not_placed(bench):
    """Receipts of other stores do no harm."""
    bench.start()
    bench.receipts.publish(ShotReceipt(shot_id='rav1-00009', status=ShotReceipt.REJECTED))
    bench.receipts.publish(ShotReceipt(shot_id='rav1-00010', status=ShotReceipt.STORED))
    bench.put(0)
    assert bench.save().message.startswith('1 photographs')


def test_saving_again_answers_at_once(bench):
    """A client that repeats its request does not have the same map made twice."""
    bench.start()
    bench.put(0)
    first = bench.save()
    written = bench.output.stat().st_mtime_ns
    again = bench.save()
    assert (again.success, again.message) == (True, first.message)
    assert bench.output.stat().st_mtime_ns == written
    bench.put(1)
    assert bench.save().message.startswith('2 photographs')
    assert bench.output.stat().st_mtime_ns > written


def test_the_final_map_tells_its_quality_and_tiles(bench):
    """Paths of both, and that a map of three lonely photographs is not georeferenced."""
    bench.start()
    for number in range(3):
        bench.put(number)
    bench.save()
    message = bench.wait_for_final()
    assert pathlib.Path(message.quality_path).exists()
    assert message.tiles_path == str(bench.directory / 'map' / 'tiles')
    assert (message.images_by_features, message.is_georeferenced) == (0, False)
    assert message.stated_error_m > 0.0


def test_coverage_is_that_of_the_region_that_was_drawn(bench):
    """The share of the mission's region and its largest hole stand in the quality."""
    place = GALWAY.frame
    corners = [(-5.0, -5.0), (5.0, -5.0), (5.0, 205.0), (-5.0, 205.0)]
    boundary = tuple(place.position_of((east, north, 0.0)) for east, north in corners)
    bench.start()
    regions = topics.create_publisher(bench.operator, topics.REGION)
    regions.publish(region_of_area(SurveyArea(boundary=boundary)))
    bench.ros.spin_until(lambda: bench.node._region is not None, DEADLINE_S)
    bench.put(0)
    bench.save()
    cover = json.loads(pathlib.Path(bench.wait_for_final().quality_path).read_text())['coverage']
    assert cover['of'] == 'region'
    assert 0.0 < cover['share'] < 0.3


def test_the_node_receives_while_the_map_is_written(bench, monkeypatch):
    """A receipt and a region are taken in, and the photograph is on the next map."""
    is_drawing, may_go_on = threading.Event(), threading.Event()

    def slow(*arguments):
        is_drawing.set()
        assert may_go_on.wait(DEADLINE_S)
        return write_products(*arguments)

    write_products = map_worker.write_products
    monkeypatch.setattr(map_worker, 'write_products', slow)
    bench.start()
    bench.put(0)
    regions = topics.create_publisher(bench.operator, topics.REGION)
    future = bench.save_client.call_async(calls.SAVE_MOSAIC.call_type.Request())
    bench.ros.spin_until(is_drawing.is_set, DEADLINE_S)
    boundary = tuple(GALWAY.frame.position_of(at) for at in ((0, 0, 0), (9, 0, 0), (0, 9, 0)))
    regions.publish(region_of_area(SurveyArea(boundary=boundary)))
    bench.receipts.publish(bench.put(1))
    bench.ros.spin_until(lambda: bench.node._region is not None, DEADLINE_S)
    assert not future.done()
    may_go_on.set()
    bench.ros.spin_until(future.done, DEADLINE_S)
    assert future.result().message.startswith('1 photographs')
    bench.ros.spin_until(lambda: bench.maps[-1].images_placed == 2, DEADLINE_S)


def test_a_fault_of_the_map_ends_the_node(bench, monkeypatch):
    """It is not lost with the thread in which it happened: the supervisor decides."""

    def broken(*_arguments):
        raise ZeroDivisionError

    bench.start()
    monkeypatch.setattr(map_worker, 'read_shot', broken)
    bench.receipts.publish(bench.put(0))
    with pytest.raises(ZeroDivisionError):
        bench.ros.spin_until(lambda: False, DEADLINE_S)
