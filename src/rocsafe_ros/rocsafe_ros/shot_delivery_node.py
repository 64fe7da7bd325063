# SPDX-License-Identifier: Apache-2.0
"""Sends the photographs of a vehicle, real or simulated, until each has a receipt."""

import time
from collections.abc import Callable

from rclpy.clock import Clock, ClockType

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.evidence.shot_store import RESEND_S, ShotStore
from rocsafe_interfaces.msg import GeotaggedImage, ShotReceipt
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode


class ShotDelivery:
    """Publishes camera/shot at once and repeats it until its receipt on shots/receipts.

    Parameters
    ----------
    node
        Node in the vehicle's namespace.
    store
        Store of the photographs that have no receipt yet.
    message_of
        Converts a photograph to its message.
    on_receipt
        Called after each receipt of a photograph of this vehicle.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        store: ShotStore,
        message_of: Callable[[Shot], GeotaggedImage],
        on_receipt: Callable[[], None] = lambda: None,
    ) -> None:
        self._log = node.get_logger()
        self._vehicle = node.vehicle_name
        self._store = store
        self._message_of = message_of
        self._on_receipt = on_receipt
        self._shot = topics.create_publisher(node, topics.SHOT)
        topics.create_subscription(node, topics.RECEIPTS, self._on_receipt_message)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        node.create_timer(0.5 * RESEND_S, self._resend, clock=steady)

    def send(self, shot: Shot) -> None:
        """Publish a photograph that is in the store."""
        self._shot.publish(self._message_of(shot))
        self._store.mark_sent(shot.shot_id, time.monotonic())

    def _resend(self) -> None:
        if self._shot.get_subscription_count() == 0:
            return
        for shot in self._store.overdue(time.monotonic()):
            self.send(shot)

    def _on_receipt_message(self, receipt: ShotReceipt) -> None:
        if receipt.vehicle != self._vehicle:
            return
        if not self._store.take_receipt(receipt.shot_id, receipt.sha256):
            return
        if receipt.status == ShotReceipt.REJECTED:
            self._log.error(f'{receipt.shot_id} was rejected, it is lost: {receipt.reason}')
        self._on_receipt()
