# SPDX-License-Identifier: Apache-2.0
"""Routes that vehicles may be flying, as one of them knows it."""

from collections.abc import Mapping

from rocsafe_fleet.agreement.knowledge import Knowledge
from rocsafe_fleet.ledger.records import FIRST_EPOCH, Epoch


class PossibleRoutes:
    """Knows what each vehicle may fly, also one that is not heard.

    A vehicle flies the plan that it claims. It may also fly a newer plan of which it is a member:
    perhaps it received that plan and was cut off before it could claim it.

    Parameters
    ----------
    first
        Routes with which the survey begins, by vehicle.
    knowledge
        What is known of claims.
    """

    def __init__(self, first: Mapping[int, tuple[int, ...]], knowledge: Knowledge) -> None:
        self._knowledge = knowledge
        self._routes = {vehicle: {FIRST_EPOCH: route} for vehicle, route in first.items()}

    def note(self, epoch: Epoch, routes: Mapping[int, tuple[int, ...]]) -> None:
        """Note a plan of its members."""
        for vehicle, route in routes.items():
            self._routes[vehicle] = {**self._possible(vehicle), epoch: route}

    def points(self, vehicle: int) -> frozenset[int]:
        """Return the viewpoints of all routes that a vehicle may fly."""
        return frozenset().union(*self._possible(vehicle).values())

    def _possible(self, vehicle: int) -> dict[Epoch, tuple[int, ...]]:
        """Return the route that a vehicle claims, and newer ones."""
        claim = self._knowledge.claim(vehicle)
        claimed = FIRST_EPOCH if claim is None else claim.epoch
        routes = self._routes.get(vehicle, {})
        held = max((epoch for epoch in routes if epoch <= claimed), default=FIRST_EPOCH)
        return {epoch: route for epoch, route in routes.items() if epoch >= held}
