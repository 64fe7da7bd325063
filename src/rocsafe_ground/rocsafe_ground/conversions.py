# SPDX-License-Identifier: Apache-2.0
"""Requests and routes of the router <-> messages."""

import math

import numpy as np
from builtin_interfaces.msg import Time
from nav_msgs.msg import OccupancyGrid, Path
from std_msgs.msg import Header

from rocsafe_geo.limits import require_not_negative
from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drivable.labels import read_labels
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import (
    DEFAULT_CURVE_POINTS,
    DEFAULT_TURN_BACK_USVH,
    DrivePlan,
    DriveRequest,
)
from rocsafe_ground.drive.ground_map import GroundMap
from rocsafe_ground.errors import BeyondBudgetError, NoMapError, NoWayError
from rocsafe_ground.evidence.evidence_point import EvidencePoint
from rocsafe_ground.evidence.labelled_things import labelled_things
from rocsafe_ground.options import RouterOptions
from rocsafe_ground.tour.orders import MOST_POINTS
from rocsafe_interfaces.action import PlanGroundRoute
from rocsafe_interfaces.msg import EvidencePoint as EvidenceMessage
from rocsafe_interfaces.msg import GroundRoute, GroundStop
from rocsafe_ros.conversions import (
    MAP_FRAME,
    path_pose,
    point_of_position,
    position_of_point,
    yaw_quaternion,
)

# Dose rates of the costs 0 and 99, logarithmic; 100 is a cell that is not free, -1 an unseen one.
LOWEST_USVH, HIGHEST_USVH = 0.1, 1e5
LARGEST_COST, NOT_FREE, UNSEEN = 99, 100, -1
_ERRORS = (
    (NoMapError, PlanGroundRoute.Result.NO_MAP),
    (NoWayError, PlanGroundRoute.Result.NO_WAY),
    (BeyondBudgetError, PlanGroundRoute.Result.BEYOND_BUDGET),
)


def request_of_goal(goal: PlanGroundRoute.Goal, options: RouterOptions) -> DriveRequest:
    """Return what a goal asks for; a turn-back level or endurance of 0 is the default.

    A load budget or concentration to turn back at of 0 is no limit. With `to_objects` the things
    of the router's labels follow what the goal names, as many as a tour takes.

    Raises
    ------
    NoMapError
        If the goal asks for the things of labels, and they cannot be read.
    ValueError
        If a field is out of range.
    """
    require_not_negative('endurance_s', goal.endurance_s, 's')
    require_not_negative('load_budget', goal.load_budget)
    require_not_negative('turn_back_usvh', goal.turn_back_usvh, 'uSv/h')
    require_not_negative('turn_back_ppm', goal.turn_back_ppm, 'ppm')
    return DriveRequest(
        start=position_of_point(goal.start),
        evidence=(*map(_evidence, goal.evidence), *_objects(goal, options)),
        dose_budget_usv=goal.dose_budget_usv,
        load_budget=goal.load_budget or math.inf,
        vehicle=options.vehicle(goal.endurance_s or GroundVehicle().endurance_s),
        turn_back_usvh=goal.turn_back_usvh or DEFAULT_TURN_BACK_USVH,
        turn_back_ppm=goal.turn_back_ppm or math.inf,
        # A vehicle under way waits for its new route.
        curve_points=0 if goal.end else DEFAULT_CURVE_POINTS,
        end=position_of_point(goal.end[0]) if goal.end else None,
        blocked=tuple(map(position_of_point, goal.blocked)),
    )


def _objects(goal: PlanGroundRoute.Goal, options: RouterOptions) -> list[EvidencePoint]:
    if not goal.to_objects:
        return []
    labels = options.files(goal.products).labels
    if labels is None:
        raise NoMapError('to_objects: the router has no labels_file')
    room = max(MOST_POINTS - len(goal.evidence), 0)
    return labelled_things(read_labels(labels), room, goal.object_dwell_s)


def _evidence(message: EvidenceMessage) -> EvidencePoint:
    return EvidencePoint(
        id=message.id,
        position=position_of_point(message.position),
        kind=message.kind,
        priority=message.priority,
        dwell_s=message.dwell_s,
        found_in=message.found_in,
    )


def evidence_message(point: EvidencePoint) -> EvidenceMessage:
    """Return an evidence point."""
    return EvidenceMessage(
        id=point.id,
        position=point_of_position(point.position),
        kind=point.kind,
        priority=point.priority,
        dwell_s=point.dwell_s,
        found_in=point.found_in,
    )


def route_message(plan: DrivePlan, vehicle: str, route_id: str) -> GroundRoute:
    """Return a drive for the vehicle of a name."""
    return GroundRoute(
        route_id=route_id,
        vehicle=vehicle,
        stops=[
            GroundStop(
                position=point_of_position(stop.place),
                speed_limit_mps=stop.speed_mps,
                dwell_s=stop.dwell_s,
                evidence=stop.evidence,
                duration_s=stop.duration_s,
                dose_usv=stop.dose_usv,
                yaw_rad=stop.look_rad,
            )
            for stop in plan.stops
        ],
        duration_s=plan.time_s,
        dose_usv=plan.forecast.mean_usv,
        dose_upper_usv=plan.forecast.upper_usv,
        dose_budget_usv=plan.request.dose_budget_usv,
        turn_back_usvh=plan.request.turn_back_usvh,
        turn_back_ppm=(
            plan.request.turn_back_ppm if math.isfinite(plan.request.turn_back_ppm) else 0.0
        ),
        lower_bound_s=plan.bound_s,
        left_out=[f'{one.evidence}: {one.why}' for one in plan.left_out],
    )


def path_message(plan: DrivePlan, stamp: Time) -> Path:
    """Return the stops as poses in the frame of the mission, each turned to the next one.

    The poses are also those of a goal of Nav2's action NavigateThroughPoses.
    """
    message = Path(header=Header(stamp=stamp, frame_id=MAP_FRAME))
    yaw = 0.0
    for number, stop in enumerate(plan.stops):
        pose = path_pose((stop.east_m, stop.north_m, 0.0), stamp)
        if number + 1 < len(plan.stops):
            ahead = plan.stops[number + 1]
            yaw = math.atan2(ahead.north_m - stop.north_m, ahead.east_m - stop.east_m)
        pose.pose.orientation = yaw_quaternion(yaw)
        message.poses.append(pose)
    return message


def costs_message(ground: GroundMap, stamp: Time) -> OccupancyGrid:
    """Return the cells of a map for a Nav2 stack: 0 to 99 by the logarithm of the dose rate.

    One byte is too coarse to plan doses on: the router does not.
    """
    rates = np.nan_to_num(ground.field.upper_usvh)
    share = np.log10(np.maximum(rates, LOWEST_USVH) / LOWEST_USVH)
    costs = np.round(LARGEST_COST * share / math.log10(HIGHEST_USVH / LOWEST_USVH))
    reasons = ground.reasons
    cells = np.clip(costs, 0, LARGEST_COST)
    cells[reasons != Reason.FREE] = NOT_FREE
    cells[reasons == Reason.UNKNOWN] = UNSEEN
    grid = ground.grid
    message = OccupancyGrid(data=cells.astype(np.int8).ravel().tolist())
    message.header.stamp, message.header.frame_id = stamp, MAP_FRAME
    message.info.resolution = grid.cell_m
    message.info.width, message.info.height = grid.columns, grid.rows
    message.info.origin.position.x = grid.west_m
    message.info.origin.position.y = grid.south_m
    message.info.origin.orientation.w = 1.0
    return message


def result_of_error(error: Exception) -> PlanGroundRoute.Result:
    """Return why there is no route."""
    code = next(
        (code for kind, code in _ERRORS if isinstance(error, kind)),
        PlanGroundRoute.Result.INVALID_REQUEST,
    )
    return PlanGroundRoute.Result(error_code=code, error_msg=str(error))
