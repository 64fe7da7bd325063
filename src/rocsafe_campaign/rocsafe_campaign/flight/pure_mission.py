# SPDX-License-Identifier: Apache-2.0
"""A whole mission of a scenario in one function: plan, fly, measure, localise. No ROS."""

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from itertools import pairwise

from rocsafe_campaign.errors import NotPureError
from rocsafe_campaign.flight.fleet_flight import FleetFlight, fly
from rocsafe_campaign.flight.fleet_readings import NOWHERE, readings_along
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.parameters.node_parameters import localizer_parameters
from rocsafe_orchestrator.planning_commands.plan_command import survey_request
from rocsafe_planner.checked_planning import checked_plan
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_radiation.errors import TooFewReadingsError
from rocsafe_radiation.localizer_options import LocalizerOptions
from rocsafe_radiation.products.assessment import Assessment, assess
from rocsafe_radiation.readings.reading_log import FlightReading, ReadingLog
from rocsafe_scenario.scenario import Scenario

S_PER_H = 3600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class PureMission:
    """A mission flown without processes.

    Attributes
    ----------
    log
        The usable readings, in the local frame of the mission.
    assessment
        What the readings show; None if there are too few.
    """

    scenario: Scenario
    plan: SurveyPlan
    flight: FleetFlight
    readings: tuple[FlightReading, ...]
    log: ReadingLog
    assessment: Assessment | None


def run_purely(scenario: Scenario) -> PureMission:
    """Plan, fly, measure and localise a scenario in this process.

    The plan, the flight and the readings are those of `rocsafe run` with the same seed. No
    photograph is taken and nothing is written.

    Raises
    ------
    NotPureError
        If the scenario has what only whole processes can do, naming the key.
    ValueError, PlannerError, RadiationError, SimError
        As the parts of the mission do.
    """
    if reasons := list(impure_keys(scenario)):
        raise NotPureError('; '.join(reasons))
    plan = checked_plan(survey_request(scenario))
    flight = fly(scenario, plan)
    readings = readings_along(scenario, flight.fixes)
    _require_nobody_turns_back(scenario, readings)
    options = localizer_options(scenario)
    log = options.log()
    for reading in readings:
        log.add(reading)
    return PureMission(
        scenario=scenario,
        plan=plan,
        flight=flight,
        readings=readings,
        log=log,
        assessment=_assessed(log, options),
    )


def impure_keys(scenario: Scenario) -> Iterator[str]:
    """Yield a line for each key of a scenario that only whole processes obey."""
    radiation, only = scenario.radiation, 'only whole processes do that: --full'
    for vehicle in scenario.vehicles:
        if vehicle.link:
            yield f'{vehicle.name}: link = {vehicle.link!r}: campaigns fly simulated vehicles only'
        if vehicle.fails_after_s:
            yield f'{vehicle.name}: fails_after_s = {vehicle.fails_after_s:g}: {only}'
    if scenario.camera.backend == 'engine':
        yield f"camera.backend = 'engine': {only}"
    if radiation.scene_file:
        yield f'radiation.scene_file = {radiation.scene_file!r}: {only}'
    if scenario.extra_rounds:
        yield f'search.extra_rounds = {scenario.extra_rounds}: {only}'
    if scenario.air.is_used or not scenario.air.wind.is_steady:
        yield f'air: {only}'


def localizer_options(scenario: Scenario) -> LocalizerOptions:
    """Return the options of the localizer of a scenario, which keeps nothing on disk."""
    parameters = localizer_parameters(scenario, NOWHERE)
    lists = {key: tuple(value) for key, value in parameters.items() if isinstance(value, list)}
    return LocalizerOptions(**{**parameters, **lists, 'spool_directory': ''})


def _assessed(log: ReadingLog, options: LocalizerOptions) -> Assessment | None:
    try:
        return assess(log.survey(), options.assessment(log.models), log.vehicles)
    except TooFewReadingsError:
        return None


def _require_nobody_turns_back(scenario: Scenario, readings: tuple[FlightReading, ...]) -> None:
    """Refuse a flight that a mission would have cut short because of the dose."""
    levels = scenario.radiation.levels
    for vehicle, (highest_usvh, dose_usv) in exposures(readings).items():
        for name, value, limit, unit in (
            ('turn_back_usvh', highest_usvh, levels.turn_back_usvh, 'uSv/h'),
            ('vehicle_budget_usv', dose_usv, levels.vehicle_budget_usv, 'uSv'),
        ):
            if limit and value >= limit:
                raise NotPureError(
                    f'{vehicle}: {value:.4g} {unit}: would turn back at radiation.levels.{name} '
                    f'= {limit:g}; only whole processes do that: --full'
                )


def exposures(readings: tuple[FlightReading, ...]) -> Mapping[str, tuple[float, float]]:
    """Return the highest dose rate (uSv/h) and the dose (uSv, trapezoidal) of each vehicle."""
    by_vehicle: dict[str, list[FlightReading]] = {}
    for reading in readings:
        by_vehicle.setdefault(reading.vehicle, []).append(reading)
    return {
        vehicle: (max(one.dose_rate_usvh for one in track), _dose_usv(track))
        for vehicle, track in by_vehicle.items()
    }


def _dose_usv(track: list[FlightReading]) -> float:
    return math.fsum(
        (b.time_ns - a.time_ns) / NS_PER_S * (a.dose_rate_usvh + b.dose_rate_usvh) / 2.0 / S_PER_H
        for a, b in pairwise(track)
    )
