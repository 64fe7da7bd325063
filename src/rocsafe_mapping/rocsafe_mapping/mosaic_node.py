# SPDX-License-Identifier: Apache-2.0
"""The node ``mosaic``: the stored photographs as one map, while they come in."""

import dataclasses
from collections import deque
from pathlib import Path
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_interfaces.msg import Region, ShotReceipt
from rocsafe_mapping.allocation import keep_freed_memory
from rocsafe_mapping.errors import MappingError, PlacementError, StoreError
from rocsafe_mapping.map_conversions import mosaic_message
from rocsafe_mapping.mosaic.live import TILES_S, LiveMap
from rocsafe_mapping.mosaic.mapmaker import MapOptions
from rocsafe_mapping.options import MosaicOptions
from rocsafe_mapping.products.handover import hand_over
from rocsafe_mapping.products.map_files import TILES, files_after, files_before, handover_of
from rocsafe_mapping.store.catalogue import read_shot, read_store
from rocsafe_ros import topics
from rocsafe_ros.conversions import area_of_region
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.run import run

# Between two pieces of work: long enough to serve a request.
PAUSE_S = 0.001
# Between two previews while photographs come.
PREVIEW_S = 0.5


class MosaicNode(Node):
    """Shows each stored photograph on the map at once, then where it fits, and writes the map.

    Subscribes: ``shots/receipts``, ``region``. Publishes: ``mosaic`` with a preview, at most twice
    a second; draws tiles on disk every four seconds. Service: ``mosaic/save`` places all that is
    stored, writes the GeoTIFF with its quality and publishes it as final. A restarted node makes
    the map again from the store.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('mosaic', **node_options)
        self._options = declare_options(self, MosaicOptions)
        self._store = Path(self._options.store_directory)
        self._files = files_before(self._options)
        self._live = LiveMap(
            MapOptions(
                ground_resolution_m=self._options.ground_resolution_m,
                max_pixels=self._options.max_pixels,
            ),
            self._options.products / TILES if self._options.live_tiles else None,
            self.get_logger().warning,
        )
        self._waiting: deque[str] = deque()
        self._refused: set[str] = set()
        self._region: SurveyArea | None = None
        self._maps = topics.create_publisher(self, topics.MOSAIC)
        topics.create_subscription(self, topics.RECEIPTS, self._on_receipt)
        topics.create_subscription(self, topics.REGION, self._on_region)
        self.create_service(topics.SAVE_MOSAIC.call_type, topics.SAVE_MOSAIC.name, self._on_save)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._worker = self.create_timer(PAUSE_S, self._on_worker, clock=steady)
        self.create_timer(PREVIEW_S, self._on_preview, clock=steady)
        self.create_timer(TILES_S, self._on_tiles, clock=steady)
        self._find_stored()

    def destroy_node(self) -> None:
        """End the thread of the map with the node."""
        self._live.close()
        super().destroy_node()

    def _on_receipt(self, receipt: ShotReceipt) -> None:
        if receipt.status != ShotReceipt.REJECTED:
            self._waiting.append(receipt.shot_id)
            self._worker.reset()

    def _on_region(self, message: Region) -> None:
        try:
            self._region = area_of_region(message)
        except ValueError as error:
            self.get_logger().warning(f'coverage is not of the region: {error}')

    def _on_worker(self) -> None:
        if self._waiting:
            self._receive_next()
        elif not self._work() and not self._live.is_busy:
            self._worker.cancel()

    def _on_preview(self) -> None:
        if self._live.preview.is_due:
            self._publish()

    def _on_tiles(self) -> None:
        if self._live.has_stale_tiles:
            self._live.release_tiles()
            self._worker.reset()

    def _on_save(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._save()
        except MappingError as error:
            response.message = str(error)
            return response
        response.success = True
        response.message = f'{len(self._live)} photographs in {self._files.geotiff}'
        if self._refused:
            response.message += f', {len(self._refused)} could not be placed'
        return response

    def _save(self) -> None:
        """Place all that is stored, write the map and publish it, unless that is done."""
        self._find_stored()
        while self._waiting:
            self._receive_next()
        # An impatient client asks again while the first request is carried out.
        if self._files.is_final and Path(self._files.geotiff).exists():
            return
        self._live.finish()
        alignment = self._live.maker.align()
        wanted = handover_of(self._options, self._live.maker, self._region)
        quality = hand_over(self._live.maker, alignment, wanted)
        self._live.mark_all()
        self._worker.reset()
        self._files = files_after(self._files, self._options, quality)
        self._publish()

    def _find_stored(self) -> None:
        """Queue what the store holds: after a restart, or where a receipt was lost."""
        try:
            shots = read_store(self._store, self.get_logger().warning)
        except StoreError as error:
            self.get_logger().error(str(error))
            return
        self._waiting.extend(shot.record.shot_id for shot in shots)

    def _receive_next(self) -> None:
        shot_id = self._waiting.popleft()
        if shot_id in self._live or shot_id in self._refused:
            return
        try:
            shot = read_shot(self._store, shot_id)
            self._live.receive(shot.record, shot.read_image)
        except PlacementError as error:
            self._refused.add(shot_id)
            self.get_logger().warning(f'not on the map: {error}')
        except StoreError as error:
            self.get_logger().error(str(error))
        else:
            self._files = dataclasses.replace(self._files, is_final=False)

    def _work(self) -> bool:
        try:
            return self._live.work()
        except MappingError as error:
            self.get_logger().error(str(error))
            return False

    def _publish(self) -> None:
        message = mosaic_message(self._live, self._files)
        message.header.stamp = self.get_clock().now().to_msg()
        self._maps.publish(message)


def main() -> int:
    """Run the node until it is asked to stop."""
    keep_freed_memory()
    return run(MosaicNode)


if __name__ == '__main__':
    raise SystemExit(main())
