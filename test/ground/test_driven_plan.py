# SPDX-License-Identifier: Apache-2.0
"""A vehicle that drives a plan is stopped by what its map does not show, and by nothing else."""

import math

import numpy as np
import pytest
from scipy.ndimage import distance_transform_edt
from test.ground.villages import position, write_village
from test.sim.drives import driven, parts_of, rover_of

from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DriveRequest
from rocsafe_ground.drive.ground_map import MapFiles, read_ground_map
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.evidence.evidence_point import EvidencePoint
from rocsafe_sim.driving.drive_route import DrivenRoute, RouteStop
from rocsafe_sim.driving.drive_state import DriveOutcome

CELL_M = 0.5
# Beside the end of the wall, and beyond it.
MARKS = ((11.3, 20.0), (-25.0, 24.0))


class Things:
    """The obstacles of a map as square blocks, and posts that it does not show."""

    def __init__(self, ground, posts=()):
        self.grid, self.posts = ground.grid, posts
        is_thing = ground.ground.reasons == Reason.OBSTACLE
        rows, columns = np.nonzero(is_thing & (distance_transform_edt(is_thing) <= 1.5))
        self.places = ground.grid.place_of(rows * ground.grid.columns + columns)

    def ground_up_m(self, _east_m, _north_m):
        """Return level ground."""
        return 0.0

    def touched(self, place_enu, radius_m):
        """Return what a ball touches."""
        beside = np.maximum(np.abs(self.places - place_enu[:2]) - 0.5 * self.grid.cell_m, 0.0)
        if (np.hypot(*beside.T) < radius_m).any():
            return 'block'
        is_near = any(math.dist(place_enu[:2], post) < radius_m for post in self.posts)
        return 'post' if is_near else ''


@pytest.fixture(scope='module')
def planned(tmp_path_factory):
    """Return a map and a drive around the end of its wall."""
    folder = write_village(tmp_path_factory.mktemp('village'))
    ground = read_ground_map(MapFiles(folder=folder), GroundVehicle(), CELL_M, 1e5)
    marks = tuple(
        EvidencePoint(id=f'm{number}', position=position(*mark), dwell_s=2.0)
        for number, mark in enumerate(MARKS)
    )
    request = DriveRequest(
        start=position(-20.0, 12.0), evidence=marks, dose_budget_usv=1e6, curve_points=0
    )
    return ground, plan_drive(request, ground)


def end_of(ground, plan, posts=(), seed=1):
    """Return how a drive of the plan ends among things."""
    rover = rover_of(
        parts_of(seed, surroundings=Things(ground, posts), has_detector=False),
        (plan.stops[0].east_m, plan.stops[0].north_m),
    )
    stops = tuple(
        RouteStop(
            east_m=stop.east_m, north_m=stop.north_m, limit_mps=stop.speed_mps,
            dwell_s=stop.dwell_s, evidence=stop.evidence, look_rad=stop.look_rad,
        )
        for stop in plan.stops
    )  # fmt: skip
    rover.drive(DrivenRoute(route_id='r', stops=stops, budget_usv=1e6, turn_back_usvh=1e5))
    driven(rover)
    return rover.state.ledger


@pytest.mark.slow
@pytest.mark.parametrize('seed', range(4))
def test_what_the_map_shows_does_not_stop_it(planned, seed):
    """The route keeps more from it than the driver asks for, skid and bends included."""
    assert end_of(*planned, seed=seed).outcome is DriveOutcome.COMPLETED


@pytest.mark.slow
def test_post_that_the_map_does_not_show_stops_it(planned):
    """Also if it stands beside the way, nearer than its clearance."""
    ground, plan = planned
    middle = plan.track[len(plan.track) // 3, :2]
    ahead = plan.track[len(plan.track) // 3 + 1, :2] - middle
    aside = np.array([-ahead[1], ahead[0]]) / np.hypot(*ahead)
    for distance in (0.0, 0.4):
        post = tuple((middle + distance * aside).tolist())
        assert end_of(ground, plan, (post,)).outcome is DriveOutcome.BLOCKED
