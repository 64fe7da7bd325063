# SPDX-License-Identifier: Apache-2.0
"""The bridge as a process, killed between the trigger of the camera and the stored photograph."""

import collections
import hashlib

import cv2
import numpy as np
import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from test.mavlink.airspace import Airspace
from test.system.test_bridge_kills import CLOSELY_WATCHED, COUNT, SLOW, Post

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import ShotReceipt
from rocsafe_ros.interfaces import topics

pytestmark = pytest.mark.system


class Store:
    """Stands in for the store of photographs: what it has acknowledged must never be lost."""

    def __init__(self, node):
        self.is_open = True
        self.came = collections.defaultdict(set)
        self.acknowledged = {}
        self._receipts = topics.create_publisher(node, topics.RECEIPTS)
        topics.create_subscription(node, topics.SHOT, self._on_shot, 'rav1')

    def _on_shot(self, shot):
        digest = hashlib.sha256(bytes(shot.image.data)).hexdigest()
        self.came[shot.shot_id].add((digest, shot.sequence, shot.viewpoint_id))
        if not self.is_open:
            return
        status = ShotReceipt.DUPLICATE if shot.shot_id in self.acknowledged else ShotReceipt.STORED
        self.acknowledged[shot.shot_id] = shot
        self._receipts.publish(
            ShotReceipt(vehicle='rav1', shot_id=shot.shot_id, sha256=digest, status=status)
        )


@pytest.fixture
def post(ros_domain_id, tmp_path):
    """Give a bridge to kill, whose copter has a camera."""
    images = tmp_path / 'camera'
    images.mkdir()
    grey = cv2.imencode('.jpg', np.full((120, 160, 3), 90, np.uint8))[1]
    (tmp_path / 'frame.jpg').write_bytes(grey.tobytes())
    air = Airspace(rate=3.0, images=images)
    made = Post(ros_domain_id, tmp_path, air, image_folder=str(images))
    yield made
    made.close()
    air.close()


@pytest.mark.all
def test_no_photograph_is_lost_by_a_kill_between_its_trigger_and_its_receipt(post):
    """Killed at the trigger, with the photograph on its way, and with its receipt on its way.

    Every trigger becomes one photograph, with one number and one content, and all are stored.
    """
    store, copter = Store(post.node), post.air.copters[1]
    post.fly()
    for number, is_open in ((1, True), (3, False), (5, True)):
        store.is_open = True
        with post.air.calm(CLOSELY_WATCHED):
            post.until(lambda number=number: copter.shot_count >= number)
        store.is_open = is_open
        with post.air.calm(SLOW):
            if number > 1:
                # The photograph has come once: its receipt is still out, or on its way.
                post.until(lambda number=number: len(store.came) >= number)
            post.start_again()
            post.until(lambda: post.state.plan_id == 'p1')
    store.is_open = True
    result = post.fly()
    post.until(result.done)
    answer = result.result().result
    assert (answer.outcome, answer.error_msg) == (FlyRoute.Result.COMPLETED, '')
    post.until(lambda: len(store.acknowledged) >= COUNT and not post.state.shots_pending)
    assert copter.shot_count == COUNT
    assert all(len(contents) == 1 for contents in store.came.values())
    kept = list(store.acknowledged.values())
    assert sorted(shot.sequence for shot in kept) == list(range(COUNT))
    assert len({shot.viewpoint_id for shot in kept}) == COUNT
    assert (post.state.shots_taken, answer.shots_taken) == (COUNT, COUNT)
