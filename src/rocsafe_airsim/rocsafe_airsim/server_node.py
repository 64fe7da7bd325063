# SPDX-License-Identifier: Apache-2.0
"""The node ``airsim``: AirSim's API on a TCP port, over the vehicles of the ROS domain."""

import asyncio
import threading
from contextlib import suppress
from typing import Any

from rclpy.clock import Clock, ClockType
from rclpy.node import Node
from std_srvs.srv import SetBool

from rocsafe_airsim.drawings_node import Drawings
from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.api import Api
from rocsafe_airsim.ned import Vector
from rocsafe_airsim.options import AirsimOptions
from rocsafe_airsim.protocol.server import AirsimServer
from rocsafe_airsim.vehicle_node import RENEW_S, RosVehicle
from rocsafe_geo.position import GeoPosition
from rocsafe_ros.interfaces import calls
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run

STATE_TYPE, LOOK_TYPE = 'rocsafe_interfaces/msg/VehicleState', 'rocsafe_interfaces/srv/Look'
LOOK_S = 0.5
START_S = 10.0


class AirsimNode(Node):
    """Hears all vehicles of the domain, and serves clients of AirSim.

    Subscribes, of each vehicle: state, odom, fix, ground_truth/fix, home, radiation, gas, and the
    label_table of its cameras. Publishes: drawings. Calls: lease, move, go_to, hold, land,
    return_home, set_home, set_wind, set_light, the look of its cameras, world/run. Parameters: see
    `AirsimOptions`.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('airsim', **node_options)
        options = declare_options(self, AirsimOptions)
        self._frame = options.frame()
        self._by_name: dict[str, RosVehicle] = {}
        self._is_paused = False
        self.drawings = Drawings(self)
        self._run = self.create_client(calls.WORLD_RUN.call_type, calls.WORLD_RUN.name)
        self._loop = asyncio.new_event_loop()
        self._thread = threading.Thread(target=self._loop.run_forever, daemon=True)
        self._thread.start()
        log = self.get_logger()
        self._server = AirsimServer(Api(self, log.info).handle, log.info)
        self._options = options
        self.port = 0
        if not options.vehicles:
            self._open()
        steady = Clock(clock_type=ClockType.STEADY_TIME)
        self.create_timer(LOOK_S, self._look, clock=steady)
        self.create_timer(RENEW_S, self._renew, clock=steady)

    @property
    def vehicles(self) -> dict[str, RosVehicle]:
        """The vehicles that are heard, in the order of their names."""
        known = self._by_name
        return {name: known[name] for name in sorted(known) if known[name].is_heard}

    def to_geodetic(self, place_enu: Vector) -> Vector:
        """Return latitude, longitude and altitude of a place."""
        latitude, longitude, altitude = self._frame.to_geodetic([place_enu])[0].tolist()
        return latitude, longitude, altitude

    def to_enu(self, position: Vector) -> Vector:
        """Return the place of a position."""
        place = GeoPosition(*position)
        east, north, up = self._frame.to_enu(
            place.latitude_deg, place.longitude_deg, place.altitude_m
        )[0].tolist()
        return east, north, up

    def time_ns(self) -> int:
        """Return mission time."""
        return int(self.get_clock().now().nanoseconds)

    def is_paused(self) -> bool:
        """Return whether a client has stopped time."""
        return self._is_paused

    async def pause(self, *, is_paused: bool) -> None:
        """Stop or start time."""
        if not self._run.service_is_ready():
            raise AirsimError('no simulated time here that could be paused')
        future = self._run.call_async(SetBool.Request(data=not is_paused))
        end_s = self._loop.time() + START_S
        while not future.done():
            if self._loop.time() > end_s:
                raise AirsimError(f'no answer of the world within {START_S:g} s')
            await asyncio.sleep(0.002)
        self._is_paused = is_paused

    def destroy_node(self) -> None:
        """Stop serving."""
        with suppress(TimeoutError, RuntimeError):
            stopping = asyncio.run_coroutine_threadsafe(self._server.stop(), self._loop)
            stopping.result(START_S)
        self._loop.call_soon_threadsafe(self._loop.stop)
        self._thread.join(START_S)
        super().destroy_node()

    def _open(self) -> None:
        """Listen for clients.

        Raises
        ------
        ParameterError
            If the address is none of this machine, or the port is taken.
        """
        host, port = self._options.host, self._options.port
        starting = self._server.start(host, port)
        try:
            self.port = asyncio.run_coroutine_threadsafe(starting, self._loop).result(START_S)
        except (OSError, TimeoutError) as error:
            why = getattr(error, 'strerror', None) or error
            raise ParameterError(f'airsim: {host}:{port}: {why}') from error
        self.get_logger().info(f'AirSim clients are served on {host}:{self.port}')

    def _is_complete(self) -> bool:
        """Return whether all vehicles that were named are heard, with a camera if simulated."""
        heard = self.vehicles
        return all(
            name in heard and (heard[name].cameras or not heard[name].is_simulated)
            for name in self._options.vehicles
        )

    def _look(self) -> None:
        """Use vehicles and cameras that are new in the domain."""
        for full, types in self.get_topic_names_and_types():
            name = full.strip('/').removesuffix('/state')
            if STATE_TYPE in types and '/' not in name and name not in self._by_name:
                self._by_name[name] = RosVehicle(self, name, self._frame)
        for full, types in self.get_service_names_and_types():
            vehicle, _, rest = full.strip('/').partition('/')
            camera, _, call = rest.partition('/')
            if LOOK_TYPE in types and call == 'look' and vehicle in self._by_name:
                self._by_name[vehicle].add_camera(camera)
        self.drawings.follow(lambda name: self._by_name[name].now().true_enu)
        if not self.port and self._is_complete():
            self._open()

    def _renew(self) -> None:
        # Leases are renewed only while a client is connected: without one they end.
        for vehicle in self._by_name.values() if self._server.clients else ():
            asyncio.run_coroutine_threadsafe(_renewed(vehicle), self._loop)


async def _renewed(vehicle: RosVehicle) -> None:
    # A lease that was taken over is told with the next order.
    with suppress(AirsimError):
        await vehicle.renew()


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(AirsimNode)


if __name__ == '__main__':
    raise SystemExit(main())
