# SPDX-License-Identifier: Apache-2.0
"""Conversions between values of the simulated ground vehicle and messages."""

import math

from builtin_interfaces.msg import Time
from sensor_msgs.msg import BatteryState
from std_msgs.msg import Header

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.battery import VOLTAGE_V
from rocsafe_geo.motion.ground_motion import Place
from rocsafe_interfaces.action import DriveRoute
from rocsafe_interfaces.msg import GasReading, GeoPoint, GroundRoute, VehicleState
from rocsafe_ros.conversions import enu_of_point, point_of_position
from rocsafe_sim.driving.drive_route import DrivenRoute, RouteStop
from rocsafe_sim.driving.drive_state import DriveMode, DriveOutcome
from rocsafe_sim.driving.rgv import Rgv

STATES = {
    DriveMode.PARKED: VehicleState.DISARMED,
    DriveMode.DRIVING: VehicleState.FLYING,
    DriveMode.HOLDING: VehicleState.HOLDING,
    DriveMode.RETURNING: VehicleState.RETURNING,
    DriveMode.ARRIVED: VehicleState.LANDED,
    DriveMode.CRASHED: VehicleState.CRASHED,
}
OUTCOMES = {
    DriveOutcome.COMPLETED: DriveRoute.Result.COMPLETED,
    DriveOutcome.CANCELLED: DriveRoute.Result.CANCELLED,
    DriveOutcome.RETURNED_EARLY: DriveRoute.Result.RETURNED_EARLY,
    DriveOutcome.BATTERY_LOW: DriveRoute.Result.BATTERY_LOW,
    DriveOutcome.TURNED_BACK_DOSE: DriveRoute.Result.TURNED_BACK_DOSE,
    DriveOutcome.BLOCKED: DriveRoute.Result.BLOCKED,
    DriveOutcome.COLLISION: DriveRoute.Result.COLLISION,
    DriveOutcome.TURNED_BACK_GAS: DriveRoute.Result.TURNED_BACK_GAS,
    DriveOutcome.DOSE_UNEXPECTED: DriveRoute.Result.DOSE_UNEXPECTED,
}


def drive_route_of(message: GroundRoute, frame: LocalFrame) -> DrivenRoute:
    """Return the route of a message; raises `ValueError` if a field is out of range."""
    stops = []
    for stop in message.stops:
        east, north, _ = enu_of_point(stop.position, frame)
        stops.append(
            RouteStop(
                east_m=east, north_m=north, limit_mps=stop.speed_limit_mps, dwell_s=stop.dwell_s,
                evidence=stop.evidence, look_rad=stop.yaw_rad, predicted_s=stop.duration_s,
                predicted_usv=stop.dose_usv,
            )
        )  # fmt: skip
    return DrivenRoute(
        route_id=message.route_id,
        stops=tuple(stops),
        budget_usv=message.dose_budget_usv,
        turn_back_usvh=message.turn_back_usvh,
        turn_back_ppm=message.turn_back_ppm,
        upper_ratio=message.dose_upper_usv / message.dose_usv if message.dose_usv > 0.0 else 0.0,
    )


def ppm_of(reading: GasReading) -> float:
    """Return a concentration: infinite where the sensor is saturated, NaN where it tells none.

    What is saturated shows a lower limit, or nothing at all.
    """
    if reading.unit != 'ppm':
        return math.nan
    return math.inf if reading.saturated else float(reading.raw)


def drive_result(rgv: Rgv) -> DriveRoute.Result:
    """Return the result of a drive that has ended."""
    ledger = rgv.rover.state.ledger
    outcome = ledger.outcome or DriveOutcome.COMPLETED
    is_complete = outcome is DriveOutcome.COMPLETED
    return DriveRoute.Result(
        outcome=OUTCOMES[outcome],
        error_msg='' if is_complete else f'{outcome.value}: {ledger.text}',
        evidence_taken=list(ledger.evidence),
        distance_driven_m=ledger.distance_m,
        duration_s=(ledger.ended_ns - ledger.began_ns) * 1e-9,
        dose_usv=ledger.dose_usv,
        position=point_of_position(rgv.fix().position),
        blocked=[_point(rgv.frame, place) for place in ledger.blocked],
    )  # fmt: skip


def drive_refusal(reason: str) -> DriveRoute.Result:
    """Return the result of a refused route."""
    return DriveRoute.Result(outcome=DriveRoute.Result.REJECTED, error_msg=reason)


def drive_feedback(rgv: Rgv) -> DriveRoute.Feedback:
    """Return how far a drive has come."""
    rover = rgv.rover
    left_m, left_s = rover.left()
    return DriveRoute.Feedback(
        stop_index=rover.state.next_stop,
        stop_count=len(rover.stops),
        distance_left_m=left_m,
        time_left_s=left_s,
        dose_usv=rover.state.ledger.dose_usv,
        dose_predicted_usv=rover.predicted_usv(),
    )


def drive_state_message(rgv: Rgv, stamp: Time) -> VehicleState:
    """Return the state of the vehicle; its stops at evidence count as viewpoints."""
    state = rgv.rover.state
    capacity = rgv.rover.parts.chassis.capacity_j
    message = VehicleState(
        header=Header(stamp=stamp, frame_id=f'{rgv.name}/base_link'),
        vehicle=rgv.name,
        state=STATES[state.mode],
        is_simulated=True,
        shots_taken=state.shots,
        shots_pending=len(rgv.shots),
        battery_fraction=state.charge_j / capacity,
        distance_flown_m=state.odometer_m,
        text=state.ledger.text,
        position=point_of_position(rgv.fix().position),
        speed_mps=state.speed_mps,
        ending=0 if state.ledger.outcome is None else OUTCOMES[state.ledger.outcome],
    )
    if state.route is not None:
        message.plan_id = state.route.route_id
        message.viewpoint_count = sum(bool(stop.evidence) for stop in state.route.stops)
        message.viewpoints_visited = len(state.ledger.evidence)
    return message


def drive_battery(rgv: Rgv, stamp: Time) -> BatteryState:
    """Return charge and current; fields that are not simulated are NaN."""
    state, chassis = rgv.rover.state, rgv.rover.parts.chassis
    capacity_ah = chassis.capacity_j / VOLTAGE_V / 3600.0
    return BatteryState(
        header=Header(stamp=stamp, frame_id=f'{rgv.name}/base_link'),
        voltage=VOLTAGE_V,
        temperature=math.nan,
        current=-chassis.power_w(state.speed_mps, 0.0) / VOLTAGE_V,
        charge=state.charge_j / VOLTAGE_V / 3600.0,
        capacity=capacity_ah,
        design_capacity=capacity_ah,
        percentage=state.charge_j / chassis.capacity_j,
        power_supply_status=BatteryState.POWER_SUPPLY_STATUS_DISCHARGING,
        power_supply_health=BatteryState.POWER_SUPPLY_HEALTH_GOOD,
        power_supply_technology=BatteryState.POWER_SUPPLY_TECHNOLOGY_LIPO,
        present=True,
    )


def _point(frame: LocalFrame, place: Place) -> GeoPoint:
    return point_of_position(frame.position_of((*place, 0.0)))
