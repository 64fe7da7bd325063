# SPDX-License-Identifier: Apache-2.0
"""The service `set_light` of a simulated vehicle: sun and air of the scene that it sees."""

from rocsafe_interfaces.srv import SetLight
from rocsafe_ros import topics
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.vehicle_scope import VehicleScopeNode
from rocsafe_scene.errors import ViewError
from rocsafe_scene.scene.moving_sun import LightOrder, MovingSun
from rocsafe_scene.scene.sunlight import Air
from rocsafe_sim.rav.rav import Rav


class LightService:
    """Changes the light of the scene; a restart of the process brings back the scenario's.

    Parameters
    ----------
    node
        Node in the namespace of the vehicle.
    rav
        The vehicle.
    """

    def __init__(self, node: VehicleScopeNode, rav: Rav) -> None:
        self._rav = rav
        node.create_service(SetLight, topics.SET_LIGHT.name, self._on_light)

    def _on_light(
        self, request: SetLight.Request, response: SetLight.Response
    ) -> SetLight.Response:
        try:
            order = self._order_of(request)
            for camera in self._rav.parts.cameras:
                camera.model.camera.set_light(order)
        except (ViewError, ValueError) as refusal:
            response.message = f'{self._rav.parts.name}: {refusal}'
            return response
        response.success = True
        return response

    def _order_of(self, request: SetLight.Request) -> LightOrder:
        air = Air(fog=request.fog, wetness=request.wetness)
        if request.sun_as_scenario:
            return LightOrder(air=air)
        sun = MovingSun(
            sun_ns=ns_of_stamp(request.sun_time),
            from_ns=self._rav.vehicle.time_ns,
            speed=request.sun_speed,
            step_s=request.sun_step_s,
        )
        return LightOrder(sun=sun, air=air)
