# SPDX-License-Identifier: Apache-2.0
"""Watches the expected doses of the people of a scenario."""

from rocsafe_geo.position import distance_m
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.watches.crew_dose import CrewDose, CrewMember, dose_rate_usvh
from rocsafe_scenario.scenario import Scenario


class CrewWatch:
    """Adds up the doses of the scenario's crew while vehicles find sources.

    Parameters
    ----------
    scenario
        Names places and budgets.
    monitor
        Knows the time and the estimated sources.
    """

    def __init__(self, scenario: Scenario, monitor: Monitor) -> None:
        self._monitor = monitor
        self._crew = [
            (
                scenario.ground_position(block.position),
                CrewDose(CrewMember(name=block.name, budget_usv=block.budget_usv)),
            )
            for block in scenario.radiation.crew
        ]

    @property
    def doses_usv(self) -> dict[str, float]:
        """Expected dose of each person so far, microsievert."""
        return {dose.member.name: round(dose.dose_usv, 3) for _, dose in self._crew}

    def advance(self) -> list[str]:
        """Add the estimates since the last call, and return new warnings."""
        said = [
            dose.advance(
                self._monitor.flight_time_s,
                dose_rate_usvh(
                    (distance_m(place, source), rate) for source, rate in self._monitor.sources
                ),
            )
            for place, dose in self._crew
        ]
        return [text for text in said if text]
