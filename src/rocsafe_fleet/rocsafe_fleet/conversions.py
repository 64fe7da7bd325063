# SPDX-License-Identifier: Apache-2.0
"""Messages of vehicles <-> what agents know."""

import math
from collections.abc import Sequence

from rocsafe_fleet.agreement.agent import Agent
from rocsafe_fleet.ledger.readings import DoseReading
from rocsafe_fleet.ledger.records import FIRST_EPOCH, Place, place_of
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import AgentState, Control, RadiationReading, Route, VehicleState
from rocsafe_planner.conversions import message_of_plan
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_ros.conversions import ns_of_stamp, position_of_point

_ALOFT = (
    VehicleState.TAKING_OFF,
    VehicleState.FLYING,
    VehicleState.HOLDING,
    VehicleState.RETURNING,
    VehicleState.LANDING,
)


def is_aloft(state: VehicleState) -> bool:
    """Return whether a vehicle is in the air."""
    return state.state in _ALOFT


def has_flown(state: VehicleState) -> bool:
    """Return whether a vehicle has taken off, wherever it is now."""
    return is_aloft(state) or state.state in (VehicleState.LANDED, VehicleState.CRASHED)


def place_of_state(state: VehicleState, endurance_s: float) -> Place | None:
    """Return where a vehicle is, None if it does not know that itself."""
    here = state.position
    if math.isnan(here.latitude) or math.isnan(here.longitude):
        return None
    charge = state.battery_fraction
    used_s = 0.0 if math.isnan(charge) else (1.0 - charge) * endurance_s
    return place_of(
        position_of_point(here),
        used_s,
        is_aloft=is_aloft(state),
        is_landing=state.state == VehicleState.LANDING,
    )


def dose_reading_of_message(message: RadiationReading) -> DoseReading | None:
    """Return a reading as agents share it, None without a place or if it is only a limit."""
    if message.saturated or math.isnan(message.position.latitude):
        return None
    counted = math.isfinite(message.live_time_s)
    return DoseReading(
        position=position_of_point(message.position),
        dose_rate_usvh=message.dose_rate_usvh,
        std_usvh=message.dose_rate_std_usvh,
        counts=message.counts if counted else 0,
        live_time_s=message.live_time_s if counted else 0.0,
        time_s=1e-9 * ns_of_stamp(message.header.stamp),
    )


def visited_of(state: VehicleState, route: Sequence[int]) -> tuple[int, ...]:
    """Return the viewpoints of its route whose photographs a vehicle has handed over."""
    count = max(0, state.viewpoints_visited - state.shots_pending)
    return tuple(route[:count])


def inability(state: VehicleState, control: Control | None, mission: str, is_real: bool) -> str:
    """Return why a vehicle takes no more work, empty if it does."""
    if state.taken_by:
        return f'its {state.taken_by} has it'
    if state.ending not in (FlyRoute.Result.COMPLETED, FlyRoute.Result.ABORTED):
        return state.text or 'its flight ends early'
    if state.ending == FlyRoute.Result.ABORTED:
        return state.text or 'aborted its flight'
    if state.state in (VehicleState.CRASHED, VehicleState.LOST):
        return 'it is lost'
    if is_real and state.state in (VehicleState.LANDING, VehicleState.LANDED):
        return 'it lands' if state.state == VehicleState.LANDING else 'it has landed'
    if control is not None and control.lease and control.mission != mission:
        return f'{control.holder} leads it'
    return ''


def route_of(plan: SurveyPlan, vehicle: str, visited: frozenset[int]) -> Route | None:
    """Return what a vehicle flies by a plan, without the first viewpoints that are done already.

    None if the plan has no viewpoint left for it.
    """
    found = [route for route in message_of_plan(plan).routes if route.vehicle == vehicle]
    if not found or not found[0].flights:
        return None
    route, flight = found[0], found[0].flights[0]
    while flight.viewpoints and flight.viewpoints[0].id in visited:
        flight.viewpoints = flight.viewpoints[1:]
        route.viewpoints = route.viewpoints[1:]
    return route if route.viewpoints else None


def numbers_of(route: Route) -> tuple[int, ...]:
    """Return the ids of the viewpoints of a route."""
    return tuple(int(view.id) for view in route.viewpoints)


def state_of(
    agent: Agent, names: Sequence[str], bytes_sent: int, *, is_done: bool, is_planning: bool
) -> AgentState:
    """Return what an agent knows, without a stamp."""
    number, coordinator, _ = agent.epoch
    members = agent.proposal.names if number else frozenset(range(len(names)))
    rounds = agent.knowledge.rounds
    newest = max(rounds, key=lambda key: (key[2], *key), default=None)
    return AgentState(
        vehicle=names[agent.own],
        epoch=number,
        coordinator='' if agent.epoch == FIRST_EPOCH else names[coordinator],
        plan_hash=agent.plan.digest.hex(),
        heard=[names[k] for k in sorted(agent.live)],
        members=[names[k] for k in sorted(members)],
        unable=[names[k] for k in sorted(agent.knowledge.unable)],
        viewpoints_visited=len(agent.visited),
        viewpoints_left=len(agent.left),
        duplicates=agent.knowledge.duplicates,
        bytes_sent=bytes_sent,
        packets_refused=agent.refused,
        alarms=len(agent.alarms),
        search_round=newest[2] if newest else 0,
        search_by=names[newest[0]] if newest else '',
        search_places=len(rounds[newest].places) if newest else 0,
        search_text=rounds[newest].reason if newest else '',
        is_planning=is_planning,
        is_done=is_done,
        text=agent.plan.error,
    )
