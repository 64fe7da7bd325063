# SPDX-License-Identifier: Apache-2.0
"""The service `set_light` of a simulated vehicle: sun and air of the scene that it sees."""

from rocsafe_interfaces.srv import SetLight
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_scene.errors import ViewError
from rocsafe_sim.messages.light_conversions import light_of
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
        node.create_service(SetLight, calls.SET_LIGHT.name, self._on_light)

    def _on_light(
        self, request: SetLight.Request, response: SetLight.Response
    ) -> SetLight.Response:
        try:
            order = light_of(request, self._rav.vehicle.time_ns)
            for camera in self._rav.parts.cameras:
                camera.model.camera.set_light(order)
        except (ViewError, ValueError) as refusal:
            response.message = f'{self._rav.parts.name}: {refusal}'
            return response
        response.success = True
        return response
