# SPDX-License-Identifier: Apache-2.0
"""The node ``mosaic``: the stored photographs as one map, while they come in."""

from collections import deque
from pathlib import Path
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import Trigger

from rocsafe_interfaces.msg import ShotReceipt
from rocsafe_mapping.catalogue import read_shot, read_store
from rocsafe_mapping.conversions import mosaic_message
from rocsafe_mapping.errors import MappingError, PlacementError, StoreError
from rocsafe_mapping.geotiff import write_geotiff
from rocsafe_mapping.mosaic import Mosaic
from rocsafe_mapping.options import MosaicOptions
from rocsafe_ros import topics
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.run import run

# Between two photographs of a backlog: long enough to serve a request.
PAUSE_S = 0.001


class MosaicNode(Node):
    """Places each stored photograph on the map and writes the map when asked.

    Subscribes: ``shots/receipts``. Publishes: ``mosaic`` with a preview, as often as work was
    done that makes one worth its cost. Service: ``mosaic/save`` places all that is stored, writes
    the GeoTIFF and publishes it as final. A restarted node makes the map again from the store.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('mosaic', **node_options)
        options = declare_options(self, MosaicOptions)
        self._store = Path(options.store_directory)
        self._output = Path(options.output_path).absolute()
        self._mosaic = Mosaic(
            ground_resolution_m=options.ground_resolution_m,
            max_pixels=options.max_pixels,
            notice=self.get_logger().warning,
        )
        self._waiting: deque[str] = deque()
        self._refused: set[str] = set()
        self._maps = topics.create_publisher(self, topics.MOSAIC)
        topics.create_subscription(self, topics.RECEIPTS, self._on_receipt)
        self.create_service(topics.SAVE_MOSAIC.call_type, topics.SAVE_MOSAIC.name, self._on_save)
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._worker = self.create_timer(PAUSE_S, self._on_worker, clock=steady)
        self._find_stored()

    def _on_receipt(self, receipt: ShotReceipt) -> None:
        if receipt.status != ShotReceipt.REJECTED:
            self._waiting.append(receipt.shot_id)
            self._worker.reset()

    def _on_worker(self) -> None:
        if not self._waiting:
            self._worker.cancel()
            return
        self._place_next()
        if self._mosaic.is_preview_due:
            self._publish(is_final=False)

    def _on_save(self, _request: Trigger.Request, response: Trigger.Response) -> Trigger.Response:
        try:
            self._find_stored()
            while self._waiting:
                self._place_next()
            write_geotiff(self._mosaic, self._output)
        except MappingError as error:
            response.message = str(error)
            return response
        self._publish(is_final=True)
        response.success = True
        response.message = f'{len(self._mosaic)} photographs in {self._output}'
        if self._refused:
            response.message += f', {len(self._refused)} could not be placed'
        return response

    def _find_stored(self) -> None:
        """Queue what the store holds: after a restart, or where a receipt was lost."""
        try:
            shots = read_store(self._store, self.get_logger().warning)
        except StoreError as error:
            self.get_logger().error(str(error))
            return
        self._waiting.extend(shot.record.shot_id for shot in shots)

    def _place_next(self) -> None:
        shot_id = self._waiting.popleft()
        if shot_id in self._mosaic or shot_id in self._refused:
            return
        try:
            shot = read_shot(self._store, shot_id)
            self._mosaic.place(shot.record, shot.read_image)
        except PlacementError as error:
            self._refused.add(shot_id)
            self.get_logger().warning(f'not on the map: {error}')
        except StoreError as error:
            self.get_logger().error(str(error))

    def _publish(self, *, is_final: bool) -> None:
        message = mosaic_message(
            self._mosaic.extent, len(self._mosaic), self._mosaic.preview_png()
        )
        message.header.stamp = self.get_clock().now().to_msg()
        message.path = str(self._output) if self._output.exists() else ''
        message.is_final = is_final
        self._maps.publish(message)


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(MosaicNode)


if __name__ == '__main__':
    raise SystemExit(main())
