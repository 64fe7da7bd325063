# SPDX-License-Identifier: Apache-2.0
"""The command services of a simulated vehicle."""

from collections.abc import Callable

from rocsafe_geo.limits import require_positive
from rocsafe_geo.motion.state import Enu
from rocsafe_interfaces.msg import GeoPoint
from rocsafe_interfaces.srv import GoTo, Move, PushRally
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_sim.messages.conversions import fence_of, places_of
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.vehicle_interface.order_answers_node import OrderAnswers
from rocsafe_sim.vehicle_interface.velocity_stream_node import VelocityStream


class CommandServices:
    """Services: hold, return_home and land, always taken; with the lease all others.

    These are resume, go_to, move, set_speed, set_home, fence and rally; and set_wind, which is
    not the vehicle's. `cmd_vel` is followed as `VelocityStream` says.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rav
        The vehicle.
    lease
        Judges who may give orders.
    answers
        Makes the callbacks.
    on_command
        Called after the vehicle got a command by a topic.
    """

    def __init__(
        self,
        node: VehicleScopeNode,
        rav: Rav,
        lease: LeaseServer,
        answers: OrderAnswers,
        on_command: Callable[[], None],
    ) -> None:
        self._rav = rav
        self._frame = rav.parts.frame
        vehicle = rav.vehicle
        for spec, command in (
            (calls.HOLD, vehicle.hold),
            (calls.RETURN_HOME, vehicle.return_home),
            (calls.LAND, vehicle.land),
        ):
            node.create_service(spec.call_type, spec.name, answers.to_end(command))
        lease.serve(calls.RESUME, answers.to(lambda _request: vehicle.resume()))
        lease.serve(calls.GO_TO, answers.to(self._go_to))
        lease.serve(
            calls.SET_SPEED, answers.to(lambda request: vehicle.set_speed(request.speed_mps))
        )
        lease.serve(
            calls.SET_HOME,
            answers.to(lambda request: vehicle.set_home(*self._places([request.position]))),
        )
        lease.serve(
            calls.PUSH_FENCE,
            answers.to(lambda request: vehicle.push_fence(fence_of(request, self._frame))),
        )
        self._stream = VelocityStream(node, rav, lease, on_command)
        lease.serve(calls.MOVE, answers.to(self._move))
        wind = answers.to(lambda told: vehicle.set_wind((told.east_mps, told.north_mps)))
        node.create_service(calls.SET_WIND.call_type, calls.SET_WIND.name, wind)
        lease.serve(calls.PUSH_RALLY, answers.to(self._push_rally))

    def _go_to(self, request: GoTo.Request) -> None:
        vehicle = self._rav.vehicle
        (place,) = self._places([request.position])
        vehicle.go_to((*place[:2], vehicle.home_enu[2] + request.height_m))

    def _move(self, request: Move.Request) -> None:
        vehicle = self._rav.vehicle
        if request.kind == Move.Request.ALONG:
            if len(request.places) != len(request.heights_m):
                raise ValueError(
                    f'heights_m has {len(request.heights_m)} values: must be '
                    f'{len(request.places)}, as many as places'
                )
            home_up_m = vehicle.home_enu[2]
            places = [
                (*place[:2], home_up_m + height_m)
                for place, height_m in zip(
                    self._places(request.places), request.heights_m, strict=True
                )
            ]
            vehicle.fly_along(places, request.speed_mps)
        elif request.kind == Move.Request.AT_VELOCITY:
            velocity = (request.velocity.x, request.velocity.y, request.velocity.z)
            yaw_rad = request.yaw_rad if request.to_yaw else None
            vehicle.fly_at(velocity, request.duration_s, request.turn_rate_radps, yaw_rad)
        elif request.kind == Move.Request.TURN:
            vehicle.turn_to(request.yaw_rad)
        elif request.kind == Move.Request.FOLLOW:
            self._stream.begin(request.lease, request.duration_s)
        else:
            raise ValueError(f'kind is {request.kind}: must be ALONG, AT_VELOCITY, TURN or FOLLOW')

    def _push_rally(self, request: PushRally.Request) -> None:
        # It returns at the height at which it is.
        require_positive('height_m', request.height_m, 'm')
        self._rav.vehicle.push_rally(self._places(request.points))

    def _places(self, points: list[GeoPoint]) -> tuple[Enu, ...]:
        return places_of(points, self._frame)
