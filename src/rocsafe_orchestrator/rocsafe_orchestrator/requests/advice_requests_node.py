# SPDX-License-Identifier: Apache-2.0
"""Requests for places to measure at next, to the localizer and the estimator."""

from collections.abc import Mapping
from functools import partial
from typing import Any

from rclpy.client import Client

from rocsafe_interfaces.msg import GeoPoint
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_orchestrator.mission.advice import Advice, Search
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission_state.request import Order
from rocsafe_ros.interfaces import calls
from rocsafe_scenario.scenario import Scenario


def searches_of(scenario: Scenario) -> dict[str, Search]:
    """Return the searches of a scenario by the name of the service that says where to go."""
    gamma, gas = scenario.radiation.search, scenario.air.search
    return {
        calls.SUGGEST_VIEWPOINTS.name: Search(
            extra_rounds=gamma.extra_rounds, viewpoints_a_round=gamma.viewpoints_a_round
        ),
        calls.SUGGEST_GAS_VIEWPOINTS.name: Search(
            extra_rounds=gas.extra_rounds, viewpoints_a_round=gas.viewpoints_a_round
        ),
    }


class AdviceRequests:
    """Asks where to measure next, and joins the answers.

    Services: ``hazard/suggest_viewpoints``, ``hazard/suggest_gas_viewpoints``.

    Parameters
    ----------
    services
        Clients by the names of their services.
    scenario
        Whose searches are flown.

    Attributes
    ----------
    viewpoints
        Places of the newest advice.
    """

    def __init__(self, services: Mapping[str, Client], scenario: Scenario) -> None:
        self.viewpoints: list[GeoPoint] = []
        self._services = services
        self._advice: Advice[GeoPoint] = Advice(searches_of(scenario))
        self._mission: Mission | None = None

    def begin(self, mission: Mission) -> None:
        """Report advice to `mission` from now on."""
        self._mission = mission

    def send(self, _order: Order) -> None:
        """Ask all questions that are open."""
        for name, count in self._advice.open_questions:
            answer = self._services[name].call_async(SuggestViewpoints.Request(count=count))
            answer.add_done_callback(partial(self._on_advice, name))

    def _on_advice(self, name: str, future: Any) -> None:
        answer = future.result()
        # It is still working: the request is repeated.
        if self._mission is None or answer is None or answer.status == answer.NOT_YET:
            return
        joined = self._advice.add(name, list(answer.viewpoints), answer.reason)
        if joined is not None:
            self.viewpoints, reason = joined
            self._mission.rounds.advised(len(self.viewpoints), reason)
