# SPDX-License-Identifier: Apache-2.0
"""Airframes, routes and flights for the tests of the simulated vehicle."""

from collections.abc import Iterator

from hypothesis import strategies as st

from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.motion.performance import Performance
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.flight.route import FlightRoute, RouteWaypoint
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle
from rocsafe_sim.vehicle.snapshot import VehicleSnapshot

HOME = (-40.0, 25.0, 0.0)
START_NS = 1_700_000_000_000_000_000
AIRFRAME = Airframe(
    performance=Performance(
        cruise_speed_mps=8.0, acceleration_mps2=2.0, climb_rate_mps=3.0, descent_rate_mps=2.0
    ),
    hover_s=1.5,
    endurance_s=1200.0,
    reserve_fraction=0.2,
)
ROUTE = FlightRoute(
    plan_id='plan-1',
    home_enu=HOME,
    waypoints=(
        RouteWaypoint(viewpoint_id=7, position_enu=(0.0, 0.0, 32.0), yaw_rad=0.5),
        RouteWaypoint(viewpoint_id=3, position_enu=(24.0, 0.0, 32.0), yaw_rad=0.5),
        RouteWaypoint(viewpoint_id=4, position_enu=(24.0, 24.0, 32.0), yaw_rad=3.0),
        RouteWaypoint(viewpoint_id=9, position_enu=(0.0, 24.0, 32.0), yaw_rad=-3.0),
    ),
)

coordinates = st.floats(-120.0, 120.0)


@st.composite
def airframes(draw: st.DrawFn) -> Airframe:
    """Return multirotors from sluggish to brisk, with batteries that always suffice."""
    autopilot = Autopilot(
        jerk_mps3=draw(st.floats(0.3, 10.0)),
        smoothing_s=draw(st.just(0.0) | st.floats(0.05, 1.0)),
        vertical_acceleration_mps2=draw(st.floats(0.3, 3.0)),
        waypoint_radius_m=draw(st.just(0.0) | st.floats(0.5, 8.0)),
        lean_angle_deg=draw(st.floats(20.0, 45.0)),
    )
    performance = Performance(
        cruise_speed_mps=draw(st.floats(3.0, 20.0)),
        acceleration_mps2=draw(st.floats(0.3, 8.0)),
        climb_rate_mps=draw(st.floats(0.5, 6.0)),
        descent_rate_mps=draw(st.floats(0.5, 6.0)),
        autopilot=autopilot,
        wind_mps=draw(st.just((0.0, 0.0)) | st.tuples(st.floats(-4, 4), st.floats(-4, 4))),
    )
    return Airframe(
        performance=performance,
        hover_s=draw(st.floats(0.0, 5.0)),
        endurance_s=1e6,
        reserve_fraction=0.1,
    )


@st.composite
def routes(draw: st.DrawFn) -> FlightRoute:
    """Return routes of one to five viewpoints, sometimes the same place twice."""
    places = st.tuples(coordinates, coordinates, st.floats(5.0, 60.0))
    points = draw(st.lists(places, min_size=1, max_size=5))
    yaws = st.floats(-3.1, 3.1)
    return FlightRoute(
        plan_id='drawn',
        home_enu=HOME,
        waypoints=tuple(
            RouteWaypoint(viewpoint_id=number, position_enu=point, yaw_rad=draw(yaws))
            for number, point in enumerate(points)
        ),
    )


def vehicle_on(
    route: FlightRoute = ROUTE,
    airframe: Airframe = AIRFRAME,
    kind: type[SimulatedVehicle] = SimulatedVehicle,
) -> SimulatedVehicle:
    """Return a vehicle that has just been told to fly `route` at `START_NS`."""
    vehicle = kind(airframe, HOME)
    vehicle.step(START_NS)
    vehicle.fly_route(route)
    return vehicle


def steps(
    vehicle: SimulatedVehicle, step_s: float, limit: int = 200_000
) -> Iterator[VehicleSnapshot]:
    """Yield what `vehicle` observes at steps of `step_s` until it stands on the ground."""
    step_ns = round(step_s * 1e9)
    for _ in range(limit):
        snapshot = vehicle.step(vehicle.time_ns + step_ns)
        yield snapshot
        if snapshot.mode is Mode.LANDED:
            return
    raise AssertionError(f'not landed after {limit} steps')


def at_s(vehicle: SimulatedVehicle, elapsed_s: float) -> VehicleSnapshot:
    """Return what `vehicle` observes `elapsed_s` seconds after `START_NS`."""
    return vehicle.step(START_NS + round(elapsed_s * 1e9))
