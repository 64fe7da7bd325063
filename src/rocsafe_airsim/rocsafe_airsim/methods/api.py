# SPDX-License-Identifier: Apache-2.0
"""AirSim's methods by name. What is not here is refused by name."""

from collections.abc import Callable
from typing import Any

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.access import Access, methods_of
from rocsafe_airsim.methods.control_methods import ControlMethods
from rocsafe_airsim.methods.detection_methods import DetectionMethods
from rocsafe_airsim.methods.given import call_with
from rocsafe_airsim.methods.sensing_methods import SensingMethods
from rocsafe_airsim.methods.weather_methods import WeatherMethods
from rocsafe_airsim.methods.world_methods import WorldMethods
from rocsafe_airsim.protocol.wire import Call
from rocsafe_airsim.vehicle import World


class Api:
    """Carries out the calls of all clients.

    Parameters
    ----------
    world
        The vehicles and their time.
    tell
        Takes a line for people.
    """

    def __init__(self, world: World, tell: Callable[[str], None]) -> None:
        at = Access(world, tell)
        parts = (
            ControlMethods(at),
            SensingMethods(at),
            DetectionMethods(at),
            WeatherMethods(at),
            WorldMethods(at),
        )
        self._methods = {name: f for part in parts for name, f in methods_of(part).items()}

    @property
    def served(self) -> frozenset[str]:
        """Names of the methods."""
        return frozenset(self._methods)

    async def handle(self, call: Call) -> Any:
        """Carry out a call; raises `AirsimError` to refuse it."""
        method = self._methods.get(call.method)
        if method is None:
            raise AirsimError('not served here: docs/airsim.md lists the methods that are')
        return await call_with(method, call.arguments)
