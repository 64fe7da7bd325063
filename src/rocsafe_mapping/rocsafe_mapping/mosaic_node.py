# SPDX-License-Identifier: Apache-2.0
"""The node ``mosaic``: the stored photographs as one map, while they come in."""

from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_interfaces.msg import Region, ShotReceipt
from rocsafe_mapping.allocation import keep_freed_memory
from rocsafe_mapping.live.live_map import TILES_S, LiveMap
from rocsafe_mapping.live.map_worker import MapWorker
from rocsafe_mapping.map_conversions import mosaic_message
from rocsafe_mapping.options import MosaicOptions
from rocsafe_mapping.products.map_files import MapFiles
from rocsafe_ros.conversions import area_of_region
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import run

# Between two previews while photographs come.
PREVIEW_S = 0.5


class MosaicNode(Node):
    """Shows each stored photograph on the map at once, then where it fits, and writes the map.

    Subscribes: ``shots/receipts``, ``region``. Publishes: ``mosaic`` with a preview, at most twice
    a second; draws tiles on disk every four seconds. Service: ``mosaic/save`` places all that is
    stored, writes the GeoTIFF with its quality and publishes it as final. A restarted node makes
    the map again from the store. The work is done in another thread: the node goes on receiving
    while the map is written.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('mosaic', **node_options)
        self._region: SurveyArea | None = None
        self._maps = topics.create_publisher(self, topics.MOSAIC)
        self._worker = MapWorker(
            declare_options(self, MosaicOptions), self._publish, self.get_logger().warning
        )
        topics.create_subscription(self, topics.RECEIPTS, self._on_receipt)
        topics.create_subscription(self, topics.REGION, self._on_region)
        service = self.create_service(
            calls.SAVE_MOSAIC.call_type, calls.SAVE_MOSAIC.name, lambda _, response: response
        )
        # rclpy has no deferred answers, and its events executor no services that are coroutines:
        # what the executor would send at once is sent when the map is written.
        self._send_saved = service.send_response
        service.send_response = self._on_save
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(PREVIEW_S, self._on_preview, clock=steady)
        self.create_timer(TILES_S, self._worker.update_tiles, clock=steady)
        self._worker.receive_stored()

    def destroy_node(self) -> None:
        """End the map's thread with the node."""
        self._worker.close()
        super().destroy_node()

    def _on_receipt(self, receipt: ShotReceipt) -> None:
        if receipt.status != ShotReceipt.REJECTED:
            self._worker.receive(receipt.shot_id)

    def _on_region(self, message: Region) -> None:
        try:
            self._region = area_of_region(message)
        except ValueError as error:
            self.get_logger().warning(f'coverage is not of the region: {error}')

    def _on_preview(self) -> None:
        self._worker.check()
        self._worker.show_changes()

    def _on_save(self, response: Trigger.Response, header: Any) -> None:
        """Have the map written; the request is answered when that is done."""

        def answer(has_written: bool, message: str) -> None:
            response.success, response.message = has_written, message
            self._send_saved(response, header)

        self._worker.save(self._region, answer)

    def _publish(self, live: LiveMap, files: MapFiles) -> None:
        """Publish the map; runs in the map's thread."""
        message = mosaic_message(live, files)
        message.header.stamp = self.get_clock().now().to_msg()
        self._maps.publish(message)


def main() -> int:
    """Run the node until it is asked to stop."""
    keep_freed_memory()
    return run(MosaicNode)


if __name__ == '__main__':
    raise SystemExit(main())
