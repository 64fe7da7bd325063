# SPDX-License-Identifier: Apache-2.0
"""Drives of a simulated ground vehicle in a given field, for tests."""

from rocsafe_sim.driving.caution import CautionOptions
from rocsafe_sim.driving.chassis import Chassis, Skid
from rocsafe_sim.driving.drive_route import DrivenRoute, RouteStop
from rocsafe_sim.driving.drive_state import DriveState, Ledger
from rocsafe_sim.driving.rover import Rover
from rocsafe_sim.driving.rover_parts import RoverParts
from rocsafe_sim.sensors.sensing_noise import SensorNoise

SECOND = 1_000_000_000
STEP_NS = SECOND // 5


def parts_of(seed=1, *, surroundings=None, chassis=None, caution=None, has_detector=True):
    """Return the parts of a vehicle."""
    chassis = chassis or Chassis()
    return RoverParts(
        chassis=chassis,
        skid=Skid(chassis=chassis, seed=seed, vehicle='rgv1'),
        noise=SensorNoise(
            seed=seed, vehicle='rgv1', gps_horizontal_std_m=0.02, gps_vertical_std_m=0.04,
            tilt_std_rad=0.0, attitude_std_rad=0.0,
        ),
        caution=caution or CautionOptions(),
        has_detector=has_detector,
        surroundings=surroundings,
    )  # fmt: skip


def rover_of(parts=None, place=(0.0, 0.0)):
    """Return a vehicle that stands at a place."""
    parts = parts or parts_of()
    state = DriveState(
        time_ns=0, east_m=place[0], north_m=place[1], charge_j=parts.chassis.capacity_j,
        ledger=Ledger(),
    )  # fmt: skip
    rover = Rover(parts, state)
    rover.step(SECOND)
    return rover


def route_of(places, *, dwells=None, limit_mps=1.0, rate=lambda _place: 0.0, budget=1e3, wall=1e5):
    """Return a route over places, with the predictions of a field ``rate(place)``, uSv/h."""
    dwells = dwells or {}
    looks = [0.0 if k in dwells else None for k in range(len(places))]
    limits = [limit_mps] * len(places)
    times = Chassis().motion.durations_s(places, limits, looks)
    stops = []
    for k, place in enumerate(places):
        before = places[max(k - 1, 0)]
        along = [
            rate((before[0] + s * (place[0] - before[0]), before[1] + s * (place[1] - before[1])))
            for s in (i / 20 for i in range(21))
        ]
        dwell = dwells.get(k, 0.0)
        dose = (times[k] * sum(along) / len(along) + dwell * rate(place)) / 3600.0
        stops.append(
            RouteStop(
                east_m=place[0], north_m=place[1], limit_mps=limit_mps if k else 0.0,
                dwell_s=dwell, evidence=f'e{k}' if k in dwells else '',
                predicted_s=times[k] + dwell, predicted_usv=dose,
            )
        )  # fmt: skip
    return DrivenRoute(
        route_id='drive-1', stops=tuple(stops), budget_usv=budget, turn_back_usvh=wall
    )


def driven(rover, rate=None, *, limit_s=2000.0, step_ns=STEP_NS):
    """Drive to the end, with readings of a field; return the photographs and the true dose."""
    shots, dose = [], 0.0
    end = rover.state.time_ns + round(limit_s * SECOND)
    while not (rover.is_over and rover.is_idle):
        assert rover.state.time_ns < end, rover.state
        shots += rover.step(rover.state.time_ns + step_ns)
        if rate is not None:
            value = rate(rover.state.place)
            dose += value * step_ns / SECOND / 3600.0
            rover.read(rover.state.time_ns, value)
    return shots, dose


def point_field(east, north, at_1m_usvh, background_usvh=0.1):
    """Return the dose rate of a point source 1 m below the detector's height."""

    def rate(place):
        square = (place[0] - east) ** 2 + (place[1] - north) ** 2
        return background_usvh + at_1m_usvh / max(square, 0.01)

    return rate
