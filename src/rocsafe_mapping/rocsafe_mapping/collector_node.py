# SPDX-License-Identifier: Apache-2.0
"""The node ``collector``: every photograph into the image store, and a receipt for it."""

from collections import deque
from functools import partial
from pathlib import Path
from threading import Thread
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from sensor_msgs.msg import Image
from std_msgs.msg import String

from rocsafe_interfaces.msg import GeotaggedImage
from rocsafe_mapping.conversions import numbers_of, receipt_of_answer, record_of_message
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.options import CollectorOptions
from rocsafe_mapping.photographs.label_images import LabelKeeper
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.repository.copying import Copier
from rocsafe_mapping.repository.server import Repository
from rocsafe_mapping.repository.sink import open_sink, token_of_file
from rocsafe_mapping.store.catalogue import read_store
from rocsafe_mapping.store.listings import write_listings
from rocsafe_mapping.store.store import Answer, ImageStore, Status
from rocsafe_mapping.store.store_index import write_index
from rocsafe_ros.background_job import BackgroundJob
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run

# The folder's lists are written when no photograph came for this time, seconds.
QUIET_S = 2.0
# Between two looks for photographs that other hosts have handed over.
ARRIVED_S = 0.1


class CollectorNode(Node):
    """Stores each photograph exactly once and tells its vehicle so.

    Subscribes: ``camera/shot`` of each vehicle, and ``camera/labels`` with ``camera/label_table``
    where label images are to be kept. Publishes: ``shots/receipts``.

    A photograph that the disk refuses gets no receipt: its vehicle keeps it and sends it again.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('collector', **node_options)
        options = declare_options(self, CollectorOptions)
        try:
            self._folder = Path(options.store_directory)
            self._store = ImageStore(
                self._folder, self.get_logger().warning, options.reserve_mb * 2**20
            )
        except StoreError as error:
            raise ParameterError(f'collector: store_directory: {error}') from error
        self._copier = None
        if options.copy_to:
            token = self._token('copy_token_file', options.copy_token_file)
            self._copier = Copier(
                self._folder, partial(open_sink, options.copy_to, token), self.get_logger().warning
            )
        self._arrived: deque[tuple[ShotRecord, Answer]] = deque()
        self._repository = self._serving(options) if options.serve_host else None
        self._failing = False
        self._is_listed, self._is_quiet = False, True
        self._listing: BackgroundJob[None, None] | None = None
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(QUIET_S, self._on_quiet, clock=steady)
        self._receipts = topics.create_publisher(self, topics.RECEIPTS)
        if self._repository is not None:
            self.create_timer(ARRIVED_S, self._on_arrived, clock=steady)
        self._labels = LabelKeeper(self._folder) if options.store_labels else None
        for vehicle in options.vehicles:
            topics.create_subscription(self, topics.SHOT, self._on_shot, vehicle)
            if self._labels is not None:
                self._listen_to_labels(vehicle)

    def destroy_node(self) -> None:
        """Release the store with the node."""
        if self._listing is not None:
            self._listing.result()
        if not self._is_listed:
            self._list()
        if self._copier is not None:
            self._copier.close()
        if self._repository is not None:
            self._repository.shutdown()
            self._repository.server_close()
        self._store.close()
        super().destroy_node()

    @staticmethod
    def _token(name: str, path: str) -> str:
        """Return the token of a repository. Raises ParameterError if its file has none."""
        try:
            return token_of_file(path)
        except StoreError as error:
            raise ParameterError(f'collector: {name}: {error}') from error

    def _serving(self, options: CollectorOptions) -> Repository:
        """Take photographs of other hosts into the store, in threads."""
        token = self._token('serve_token_file', options.serve_token_file)
        address = options.serve_host, options.serve_port

        def on_stored(record: ShotRecord, answer: Answer) -> None:
            self._arrived.append((record, answer))

        try:
            server = Repository(self._folder, address, token, self._store, on_stored)
        except (StoreError, ValueError, OSError) as error:
            where = f'{address[0]}:{address[1]}'
            raise ParameterError(f'collector: serve_host: {where}: {error}') from error
        Thread(target=server.serve_forever, name='repository', daemon=True).start()
        return server

    def _on_arrived(self) -> None:
        """Tell of photographs that other hosts have handed over."""
        while self._arrived:
            record, answer = self._arrived.popleft()
            self._is_listed = self._is_quiet = False
            self._tell(record.vehicle, record.shot_id, answer, record)

    def _tell(self, vehicle: str, shot_id: str, answer: Answer, record: ShotRecord | None) -> None:
        receipt = receipt_of_answer(vehicle, shot_id, answer, record)
        receipt.header.stamp = self.get_clock().now().to_msg()
        self._receipts.publish(receipt)

    def _listen_to_labels(self, vehicle: str) -> None:
        on_labels = partial(self._on_labels, vehicle)
        topics.create_subscription(self, topics.CAMERA_LABELS, on_labels, vehicle)
        topics.create_subscription(self, topics.CAMERA_LABEL_TABLE, self._on_label_table, vehicle)

    def _on_labels(self, vehicle: str, message: Image) -> None:
        keeper = self._labels
        assert keeper is not None  # noqa: S101 - nothing is subscribed without one
        try:
            keeper.add_image(vehicle, ns_of_stamp(message.header.stamp), numbers_of(message))
        except (StoreError, ValueError) as error:
            self.get_logger().warning(str(error), once=True)

    def _on_label_table(self, message: String) -> None:
        try:
            if self._labels is not None:
                self._labels.add_table(message.data)
        except StoreError as error:
            self.get_logger().warning(str(error), once=True)

    def _on_quiet(self) -> None:
        is_listing = self._listing is not None and not self._listing.is_done
        if self._is_quiet and not self._is_listed and not is_listing:
            # A photograph that comes while the lists are written makes them out of date again.
            self._is_listed = True
            self._listing = BackgroundJob(lambda _: self._list(), 'listing', None)
        self._is_quiet = True

    def _list(self) -> None:
        """Bring the lists of the folder up to date."""
        try:
            shots = read_store(self._folder, self.get_logger().warning)
            write_listings(self._folder, shots)
            write_index(self._folder, shots)
        except StoreError as error:
            self.get_logger().warning(str(error))

    def _on_shot(self, message: GeotaggedImage) -> None:
        try:
            record, answer = self._stored(message)
        except StoreError as error:
            self._note_failure(error)
            return
        if self._failing:
            self._failing = False
            self.get_logger().info('image store works again')
        if answer.status is Status.REJECTED:
            self.get_logger().error(f'{message.shot_id!r} rejected: {answer.reason}')
        if answer.status is Status.STORED:
            self._is_listed = self._is_quiet = False
            self._keep_labels_of(message)
            if self._copier is not None:
                self._copier.wake()
        self._tell(message.vehicle, message.shot_id, answer, record)

    def _keep_labels_of(self, message: GeotaggedImage) -> None:
        if self._labels is None:
            return
        try:
            time_ns = ns_of_stamp(message.header.stamp)
            self._labels.add_shot(message.vehicle, time_ns, message.shot_id)
        except StoreError as error:
            self.get_logger().warning(str(error), once=True)

    def _stored(self, message: GeotaggedImage) -> tuple[ShotRecord | None, Answer]:
        if self._repository is None:
            return self._put(message)
        with self._repository.lock:
            return self._put(message)

    def _put(self, message: GeotaggedImage) -> tuple[ShotRecord | None, Answer]:
        image = bytes(message.image.data)
        try:
            record = record_of_message(message)
        except ValueError as error:
            return None, self._store.reject(image, str(error))
        return record, self._store.put(record, image)

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
