# SPDX-License-Identifier: Apache-2.0
"""The node ``collector``: every photograph into the image store, and a receipt for it."""

from pathlib import Path
from typing import Any

from rclpy.node import Node

from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_mapping.conversions import receipt_of_answer, record_of_message
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.options import CollectorOptions
from rocsafe_mapping.store import Answer, ImageStore, Status
from rocsafe_ros import topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.run import run


class CollectorNode(Node):
    """Stores each photograph exactly once and tells its vehicle so.

    Subscribes: ``camera/shot`` of each vehicle. Publishes: ``shots/receipts``.

    A photograph that the disk refuses gets no receipt: its vehicle keeps it and sends it again.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('collector', **node_options)
        options = declare_options(self, CollectorOptions)
        try:
            self._store = ImageStore(Path(options.store_directory), self.get_logger().warning)
        except StoreError as error:
            raise ParameterError(f'collector: store_directory: {error}') from error
        self._failing = False
        self._receipts = topics.create_publisher(self, topics.RECEIPTS)
        for vehicle in options.vehicles:
            topics.create_subscription(self, topics.SHOT, self._on_shot, vehicle)

    def destroy_node(self) -> None:
        """Release the store with the node."""
        self._store.close()
        super().destroy_node()

    def _on_shot(self, message: GeotaggedImage) -> None:
        try:
            answer = self._stored(message)
        except StoreError as error:
            self._note_failure(error)
            return
        if self._failing:
            self._failing = False
            self.get_logger().info('image store works again')
        if answer.status is Status.REJECTED:
            self.get_logger().error(f'{message.shot_id!r} rejected: {answer.reason}')
        receipt = receipt_of_answer(message, answer)
        receipt.header.stamp = self.get_clock().now().to_msg()
        self._receipts.publish(receipt)

    def _stored(self, message: GeotaggedImage) -> Answer:
        image = bytes(message.image.data)
        try:
            record = record_of_message(message)
        except ValueError as error:
            return self._store.reject(image, str(error))
        return self._store.put(record, image)

    def _note_failure(self, error: StoreError) -> None:
        """Say so once, not with every photograph that comes again."""
        if not self._failing:
            self._failing = True
            self.get_logger().error(f'{error}; photographs stay with their vehicles')


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(CollectorNode)


if __name__ == '__main__':
    raise SystemExit(main())
