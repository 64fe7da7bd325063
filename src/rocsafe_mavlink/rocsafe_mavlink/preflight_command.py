# SPDX-License-Identifier: Apache-2.0
"""The executable ``preflight``: checks vehicles before a flight, without ROS.

Reads a request as JSON from standard input: `bridge` (parameters of the bridge, the content of the
drones file among them), `routes` (see `plan_of`, by vehicle; may be left out) and `patience_s`;
with `only_options` true no link is opened, and only a mistake in the parameters is told, or in
the files of the vehicles named in `files_of`, which are on this machine.
Writes the answer as JSON: for each vehicle its checks and its home. It only reads: nothing is
commanded but the messages that it needs.
"""

import json
import sys
import time
from dataclasses import fields, replace
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.value_file import values_of
from rocsafe_mavlink.assembly import make_drone, make_stations, require_files
from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.checks.check import NOT_READ, Check, CheckVerdict, failures
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.station import Station
from rocsafe_mavlink.drone_options import DroneFleet
from rocsafe_mavlink.errors import MavlinkError
from rocsafe_mavlink.plan.flight_plan import FlightPlan, FlightWaypoint

POLL_S = 0.02
LARGEST_PATIENCE_S = 300.0
EXIT_GOOD, EXIT_FAILED, EXIT_USAGE = 0, 1, 2


def main() -> int:
    """Answer the request on standard input; return 0 if every vehicle may fly, else 1."""
    try:
        request = json.load(sys.stdin)
        given = dict(request['bridge'])
        fleet = values_of(given.pop('drones_file'), DroneFleet, 'drones_file')
        options = options_of(given)
        speeds_mps = {drone.name: drone.speed_mps for drone in fleet.drones}
        plans = {
            name: plan_of(route, speeds_mps[name])
            for name, route in request.get('routes', {}).items()
        }
        if request.get('only_options'):
            require_files(fleet, request.get('files_of', ()))
            json.dump({'vehicles': []}, sys.stdout)
            return EXIT_GOOD
        patience_s = min(float(request.get('patience_s', 0.0)), LARGEST_PATIENCE_S)
        stations = make_stations(options, fleet)
    except (KeyError, TypeError, ValueError, MavlinkError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_USAGE
    try:
        drones = [make_drone(drone, options, stations[drone.link]) for drone in fleet.drones]
        wait(drones, list(stations.values()), plans, patience_s)
        answers = [answer_of(drone, plans.get(drone.spec.name)) for drone in drones]
    finally:
        for station in stations.values():
            station.close()
    json.dump({'vehicles': answers}, sys.stdout)
    return EXIT_GOOD if all(answer['may_fly'] for answer in answers) else EXIT_FAILED


def options_of(given: dict[str, Any]) -> BridgeOptions:
    """Return the options of a request; a check keeps nothing over restarts."""
    known = {field.name for field in fields(BridgeOptions)}
    unknown = set(given) - known
    if unknown:
        raise ValueError(f'bridge.{min(unknown)} is not known')
    return replace(BridgeOptions(**given), state_directory='')


def plan_of(route: dict[str, Any], speed_mps: float) -> FlightPlan:
    """Return the plan of a route.

    Its ``waypoints`` are latitude, longitude, height above home, and whether it is a bend; its
    ``exclusions`` rings of latitude and longitude, to which ``clearance_m`` is kept.
    """
    home = route.get('home')
    return FlightPlan(
        waypoints=tuple(
            FlightWaypoint(
                position=GeoPosition(latitude, longitude, 0.0), height_m=height, is_bend=any(bend)
            )
            for latitude, longitude, height, *bend in route['waypoints']
        ),
        exclusions=tuple(
            tuple(GeoPosition(latitude, longitude, 0.0) for latitude, longitude in ring)
            for ring in route.get('exclusions', ())
        ),
        clearance_m=route.get('clearance_m', 0.0),
        speed_mps=speed_mps,
        home=home and GeoPosition(home[0], home[1], 0.0),
    )


def wait(
    drones: list[Drone],
    stations: list[Station],
    plans: dict[str, FlightPlan],
    patience_s: float,
) -> None:
    """Listen until waiting cannot change a check, but no longer than `patience_s`."""
    end_s = time.monotonic() + patience_s
    while (now_s := time.monotonic()) < end_s:
        for station in stations:
            station.take(now_s, time.time())
            station.tick(now_s, time.time(), is_supervised=True)
        if all(_is_settled(drone, plans.get(drone.spec.name), now_s) for drone in drones):
            return
        time.sleep(POLL_S)


def answer_of(drone: Drone, plan: FlightPlan | None) -> dict[str, Any]:
    """Return the answer for a vehicle."""
    checks = _checks(drone, plan, time.monotonic())
    home = drone.home
    return {
        'name': drone.spec.name,
        'may_fly': not failures(checks),
        'home': home and [home.latitude_deg, home.longitude_deg],
        'checks': [
            {
                'name': check.name,
                'verdict': check.verdict.value,
                'value': check.value,
                'limit': check.limit,
            }
            for check in checks
        ],
    }


def _is_settled(drone: Drone, plan: FlightPlan | None, now_s: float) -> bool:
    checks = _checks(drone, plan, now_s)
    is_waiting = any(check.value == NOT_READ for check in checks)
    failed = [check for check in checks if check.verdict is CheckVerdict.FAIL]
    return not is_waiting and not any(check.may_pass_soon for check in failed)


def _checks(drone: Drone, plan: FlightPlan | None, now_s: float) -> tuple[Check, ...]:
    try:
        return drone.checks(plan, now_s)
    except ValueError as error:
        return (Check('contact', CheckVerdict.FAIL, str(error), 'heard'),)


if __name__ == '__main__':
    raise SystemExit(main())
