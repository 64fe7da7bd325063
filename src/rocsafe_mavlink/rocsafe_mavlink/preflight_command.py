# SPDX-License-Identifier: Apache-2.0
"""The executable ``preflight``: looks at vehicles before a flight, without ROS.

Reads a request as JSON from standard input: `bridge` (parameters of the bridge), `routes` (name of
a vehicle -> heights and places to fly to; may be left out) and `patience_s`. Writes the answer as
JSON: for each vehicle its checks and its home. It only reads: nothing is commanded but the
messages that it needs.
"""

import json
import math
import sys
import time
from dataclasses import fields, replace
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.assembly import make_drones, make_lines
from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.line import Line
from rocsafe_mavlink.errors import MavlinkError
from rocsafe_mavlink.flight.flight_plan import FlightPlan, Waypoint
from rocsafe_mavlink.flight.preflight import NOT_READ, Check, Verdict, failures

POLL_S = 0.02
LARGEST_PATIENCE_S = 300.0
EXIT_GOOD, EXIT_FAILED, EXIT_USAGE = 0, 1, 2


def main() -> int:
    """Answer the request on standard input; return 0 if every vehicle may fly, else 1."""
    try:
        request = json.load(sys.stdin)
        options = options_of(request['bridge'])
        plans = {
            name: plan_of(route, options, options.vehicles.index(name))
            for name, route in request.get('routes', {}).items()
        }
        patience_s = min(float(request.get('patience_s', 0.0)), LARGEST_PATIENCE_S)
        lines = make_lines(options)
    except (KeyError, TypeError, ValueError, MavlinkError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_USAGE
    try:
        drones = make_drones(options, lines)
        wait(drones, list(lines.values()), plans, patience_s)
        answers = [answer_of(drone, plans.get(drone.spec.name)) for drone in drones]
    finally:
        for line in lines.values():
            line.close()
    json.dump({'vehicles': answers}, sys.stdout)
    return EXIT_GOOD if all(answer['may_fly'] for answer in answers) else EXIT_FAILED


def options_of(given: dict[str, Any]) -> BridgeOptions:
    """Return the options of a request; nothing is remembered of a look."""
    known = {field.name for field in fields(BridgeOptions)}
    unknown = set(given) - known
    if unknown:
        raise ValueError(f'bridge.{min(unknown)} is not known')
    values = {key: _value(value) for key, value in given.items()}
    return replace(BridgeOptions(**values), state_directory='')


def plan_of(route: dict[str, Any], options: BridgeOptions, index: int) -> FlightPlan:
    """Return the plan of a route: ``waypoints`` of latitude, longitude, height above home."""
    home = route.get('home')
    return FlightPlan(
        waypoints=tuple(
            Waypoint(position=GeoPosition(latitude, longitude, 0.0), height_m=height)
            for latitude, longitude, height in route['waypoints']
        ),
        speed_mps=options.spec(index).speed_mps,
        home=home and GeoPosition(home[0], home[1], 0.0),
    )


def wait(
    drones: list[Drone], lines: list[Line], plans: dict[str, FlightPlan], patience_s: float
) -> None:
    """Listen until nothing that waiting helps is amiss, but no longer than `patience_s`."""
    end_s = time.monotonic() + patience_s
    while (now_s := time.monotonic()) < end_s:
        for line in lines:
            line.take(now_s, time.time())
            line.tick(now_s, time.time(), is_supervised=True)
        if all(_is_settled(drone, plans.get(drone.spec.name), now_s) for drone in drones):
            return
        time.sleep(POLL_S)


def answer_of(drone: Drone, plan: FlightPlan | None) -> dict[str, Any]:
    """Return what is to be said of a vehicle."""
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
    failed = [check for check in checks if check.verdict is Verdict.FAIL]
    return not is_waiting and not any(check.may_pass_soon for check in failed)


def _checks(drone: Drone, plan: FlightPlan | None, now_s: float) -> tuple[Check, ...]:
    try:
        return drone.checks_of(plan, now_s)
    except ValueError as error:
        return (Check('contact', Verdict.FAIL, str(error), 'heard'),)


def _value(value: Any) -> Any:
    if isinstance(value, list):
        return tuple(map(_value, value))
    return math.nan if value is None else value


if __name__ == '__main__':
    raise SystemExit(main())
