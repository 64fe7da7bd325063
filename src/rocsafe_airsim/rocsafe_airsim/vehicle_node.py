# SPDX-License-Identifier: Apache-2.0
"""A vehicle of the ROS domain: heard on its topics, ordered by its services."""

import asyncio
import json
import threading
from collections.abc import Mapping, Sequence
from functools import partial
from typing import Any

from rclpy.node import Node
from std_msgs.msg import String
from std_srvs.srv import Trigger

from rocsafe_airsim import conversions
from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.gimbals_node import Gimbals
from rocsafe_airsim.ned import Origin, Vector
from rocsafe_airsim.vehicle import Light, Picture, Turn, VehicleNow
from rocsafe_geo.frame import LocalFrame
from rocsafe_interfaces.msg import GeoPoint, VehicleState
from rocsafe_interfaces.srv import (
    GoTo,
    Lease,
    Look,
    Move,
    SetFieldOfView,
    SetHome,
    SetLight,
    SetWind,
)
from rocsafe_ros.conversions import ns_of_stamp, stamp_of_ns
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import CallSpec, name_of, of_camera

HOLDER = 'airsim'
# A client whose script ends without a word leads for no longer.
LEASE_S = 60.0
RENEW_S = 15.0
# A vehicle answers orders at once; a picture is drawn first.
ANSWER_S, PICTURE_S = 5.0, 30.0
# A home is heard by its topic.
HEARD_S, SAME_PLACE_M = 0.02, 0.5
_PLAIN = {'hold': calls.HOLD, 'land': calls.LAND, 'return_home': calls.RETURN_HOME}
_NAN3 = (float('nan'),) * 3


class RosVehicle:
    """One vehicle; messages arrive in the thread of ROS, orders come from that of the server.

    Parameters
    ----------
    node
        Node that listens and calls.
    name
        Name, also of its namespace.
    frame
        Frame of the mission.
    """

    def __init__(self, node: Node, name: str, frame: LocalFrame) -> None:
        self.name = name
        self.is_simulated = False
        self.origin = Origin((0.0, 0.0, 0.0))
        self.home: Vector = _NAN3
        self.cameras: list[str] = []
        self._node, self._frame = node, frame
        self._lock = threading.Lock()
        self._heard: dict[str, Any] = {}
        self._gimbals = Gimbals(node, name)
        self._tables: dict[str, Sequence[Mapping[str, Any]]] = {}
        self._lease = ''
        own = (topics.STATE, topics.ODOM, topics.FIX, topics.GROUND_TRUTH_FIX)
        sensors = (topics.IMU, topics.BAROMETER, topics.MAGNETOMETER, topics.RANGE)
        for spec in (*own, topics.CONTROL, topics.RADIATION, topics.GAS, *sensors):
            topics.create_subscription(node, spec, partial(self._on_message, spec.name), name)
        topics.create_subscription(node, topics.HOME, self._on_home, name)
        moves = (calls.MOVE, calls.GO_TO, calls.SET_HOME, calls.SET_WIND, calls.SET_LIGHT)
        services = (*_PLAIN.values(), calls.LEASE, *moves)
        self._clients = {spec.name: self._client(spec) for spec in services}

    def add_camera(self, camera: str) -> None:
        """Use a camera, named as its topics are; the first of a vehicle comes first."""
        if camera in self.cameras:
            return
        for spec in (of_camera(each, camera) for each in (calls.LOOK, calls.SET_FOV)):
            self._clients[spec.name] = self._client(spec)
        table = of_camera(topics.CAMERA_LABEL_TABLE, camera)
        topics.create_subscription(self._node, table, partial(self._on_table, camera), self.name)
        self._gimbals.add(camera)
        self.cameras = sorted([*self.cameras, camera], key=lambda c: (c != 'camera', c))

    @property
    def is_heard(self) -> bool:
        """Whether its state and its place are known."""
        return {'state', 'odom', 'fix'} <= self._heard.keys()

    @property
    def smells(self) -> bool:
        """Whether it has told of gas."""
        return 'gas' in self._heard

    @property
    def is_led(self) -> bool:
        """Whether the lease that was taken is still the one that its orders need."""
        return bool(self._lease) and self._heard['control'].lease == self._lease

    def now(self) -> VehicleNow:
        """Return what was last heard; raises `AirsimError` before anything was."""
        with self._lock:
            heard = dict(self._heard)
        if not self.is_heard:
            raise AirsimError(f'{self.name}: nothing was heard of its place yet')
        state: VehicleState = heard['state']
        odom, fix = heard['odom'], heard['fix']
        place = conversions.vector_of(odom.pose.pose.position)
        true_enu = place
        if (true_fix := heard.get('ground_truth/fix')) is not None:
            true_enu = self.to_enu(conversions.position_of(true_fix))
        return VehicleNow(
            stamp_ns=ns_of_stamp(odom.header.stamp),
            state=state.state,
            text=state.text,
            place_enu=place,
            velocity_enu=conversions.vector_of(odom.twist.twist.linear),
            true_enu=true_enu,
            attitude=conversions.quaternion_of(odom.pose.pose.orientation),
            position=conversions.position_of(fix),
            std_m=conversions.std_of(fix),
        )

    def to_enu(self, position: Vector) -> Vector:
        """Return the place of a position in the mission's frame."""
        east, north, up = self._frame.to_enu(*position)[0].tolist()
        return east, north, up

    def label_table(self, camera: str) -> Sequence[Mapping[str, Any]]:
        """Return the instances that a camera can see."""
        return self._tables.get(camera, ())

    def reading(self, kind: str) -> Mapping[str, Any]:
        """Return the newest reading."""
        message = self._heard.get(kind)
        if message is None:
            raise AirsimError(f'{self.name} has no {kind} reading')
        return conversions.READINGS[kind](message)

    # Orders.

    async def take(self) -> None:
        """Take the control lease, or renew it."""
        request = Lease.Request(request=Lease.Request.TAKE, holder=HOLDER, duration_s=LEASE_S)
        answer = await self._order('lease', request)
        with self._lock:
            self._heard['control'] = answer.control
            self._lease = answer.control.lease

    async def release(self) -> None:
        """Give the control lease back."""
        request = Lease.Request(request=Lease.Request.RELEASE, lease=self._lease)
        self._lease = ''
        await self._order('lease', request)

    async def renew(self) -> None:
        """Keep the control lease while it is held."""
        if self._lease:
            request = Lease.Request(
                request=Lease.Request.RENEW, lease=self._lease, duration_s=LEASE_S
            )
            await self._order('lease', request)

    async def along(self, places: Sequence[Vector], speed_mps: float) -> None:
        """Fly along places; a real vehicle goes to one, at its own speed."""
        if not self.is_simulated:
            if len(places) != 1:
                raise AirsimError(f'{self.name} is a real vehicle: send one place at a time')
            ((latitude, longitude, height_m),) = places
            position = GeoPoint(latitude=latitude, longitude=longitude)
            request = GoTo.Request(lease=self._lease, position=position, height_m=height_m)
            await self._order('go_to', request)
            return
        points = [GeoPoint(latitude=p[0], longitude=p[1], altitude=0.0) for p in places]
        await self._move(
            Move.Request.ALONG, places=points, heights_m=[p[2] for p in places],
            speed_mps=speed_mps,
        )  # fmt: skip

    async def at_velocity(self, velocity_enu: Vector, duration_s: float, turn: Turn) -> None:
        """Fly at a velocity."""
        request: dict[str, Any] = {'duration_s': duration_s, 'turn_rate_radps': turn.rate_radps}
        if turn.yaw_enu_rad is not None:
            request |= {'to_yaw': True, 'yaw_rad': turn.yaw_enu_rad}
        move = Move.Request(kind=Move.Request.AT_VELOCITY, lease=self._lease, **request)
        move.velocity.x, move.velocity.y, move.velocity.z = velocity_enu
        await self._order_move(move)

    async def turn(self, yaw_enu_rad: float) -> None:
        """Turn at its place."""
        await self._move(Move.Request.TURN, yaw_rad=yaw_enu_rad)

    async def plain(self, verb: str) -> None:
        """Give an order that every holder may give."""
        await self._order(verb, Trigger.Request())

    async def set_wind(self, east_mps: float, north_mps: float) -> None:
        """Fly in another wind."""
        await self._order('set_wind', SetWind.Request(east_mps=east_mps, north_mps=north_mps))

    async def set_light(self, light: Light) -> None:
        """Let its cameras see the scene in another light."""
        request = SetLight.Request(
            sun_as_scenario=light.sun_ns is None,
            sun_time=stamp_of_ns(light.sun_ns or 0),
            sun_speed=light.sun_speed,
            sun_step_s=light.sun_step_s,
            fog=light.fog,
            wetness=light.wetness,
        )
        await self._order('set_light', request)

    async def set_home(self, position: Vector) -> None:
        """Stand on the ground elsewhere, and hear that home and origin are there."""
        latitude, longitude, altitude = position
        point = GeoPoint(latitude=latitude, longitude=longitude, altitude=altitude)
        await self._order('set_home', SetHome.Request(lease=self._lease, position=point))
        wanted = self.to_enu(position)
        end_s = asyncio.get_running_loop().time() + ANSWER_S
        while not self.origin.is_over(wanted, SAME_PLACE_M):
            if asyncio.get_running_loop().time() > end_s:
                raise AirsimError(f'{self.name}: was not heard at its new home')
            await asyncio.sleep(HEARD_S)

    async def point(self, camera: str, pitch_rad: float, yaw_rad: float) -> None:
        """Turn the gimbal of a camera."""
        await self._gimbals.point(camera, pitch_rad, yaw_rad)

    async def set_fov(self, camera: str, fov_deg: float) -> None:
        """Let a camera look with another field of view."""
        name = of_camera(calls.SET_FOV, camera).name
        await self._order(name, SetFieldOfView.Request(horizontal_fov_deg=fov_deg))

    async def look(self, camera: str, *, with_truth: bool) -> Picture:
        """Return the image of a camera now."""
        name = of_camera(calls.LOOK, camera).name
        request = Look.Request(with_truth=with_truth)
        return conversions.picture_of(await self._order(name, request, PICTURE_S))

    async def _move(self, kind: int, **fields: Any) -> None:
        await self._order_move(Move.Request(kind=kind, lease=self._lease, **fields))

    async def _order_move(self, move: Move.Request) -> None:
        if not self.is_simulated:
            raise AirsimError(f'{self.name} is a real vehicle: flies routes and to single places')
        await self._order('move', move)

    async def _order(self, name: str, request: Any, limit_s: float = ANSWER_S) -> Any:
        client = self._clients[name]
        if not client.service_is_ready():
            raise AirsimError(f'{self.name} has no {name}')
        loop = asyncio.get_running_loop()
        answered: asyncio.Future[Any] = loop.create_future()
        future = client.call_async(request)
        future.add_done_callback(
            lambda done: loop.call_soon_threadsafe(_settle, answered, done.result())
        )
        try:
            answer = await asyncio.wait_for(answered, limit_s)
        except TimeoutError as error:
            client.remove_pending_request(future)
            raise AirsimError(f'{self.name}: no answer to {name} within {limit_s:g} s') from error
        if not answer.success:
            raise AirsimError(answer.message)
        return answer

    # Messages.

    def _on_message(self, name: str, message: Any) -> None:
        with self._lock:
            self._heard[name] = message
        if name == 'state':
            self.is_simulated = message.is_simulated

    def _on_home(self, message: GeoPoint) -> None:
        self.home = (message.latitude, message.longitude, message.altitude)
        self.origin = Origin(self.to_enu(self.home))

    def _on_table(self, camera: str, message: String) -> None:
        rows = json.loads(message.data)
        self._tables[camera] = rows if isinstance(rows, list) else rows.get('instances', ())

    def _client(self, spec: CallSpec) -> Any:
        return self._node.create_client(spec.call_type, name_of(spec, self.name))


def _settle(future: 'asyncio.Future[Any]', result: Any) -> None:
    if not future.done():
        future.set_result(result)
