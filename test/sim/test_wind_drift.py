# SPDX-License-Identifier: Apache-2.0
"""Wind that pushes vehicles off their way: the autopilot's response, restarts, the air's wind."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.wind.anemometer_file import RecordedWind
from rocsafe_geo.wind.gusts import GustyWind
from rocsafe_geo.wind.wind_field import UniformWind, WindField
from rocsafe_geo.wind.wind_vector import WindVector
from rocsafe_sim.flight.segment import FlightPose
from rocsafe_sim.flight.wind_drift import WindDrift
from rocsafe_sim.options import VehicleOptions
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.shared_parts import make_shared

from .flights import ROUTE

SECOND = 10**9
WIND = UniformWind(wind=WindVector(towards_east_mps=6.0, towards_north_mps=0.0))
GUSTS = GustyWind(mean=WIND, sigma_east_mps=0.8, sigma_north_mps=0.8, time_scale_s=15.0, seed=5)


def drift(wind: WindField) -> WindDrift:
    """Return the drift of a vehicle that knows the mean wind."""
    return WindDrift(wind, start_ns=100 * SECOND, drag_per_m=0.054, mean_mps=(6.0, 0.0))


def moving(velocity_mps: tuple[float, float] = (0.0, 0.0)) -> Callable[[int], FlightPose]:
    """Return a way straight through the place over the origin at the start of the mission."""

    def way(time_ns: int) -> FlightPose:
        since_s = time_ns / SECOND - 100.0
        return FlightPose(
            position_enu=(velocity_mps[0] * since_s, velocity_mps[1] * since_s, 20.0),
            velocity_enu=(*velocity_mps, 0.0),
            yaw_rad=0.0,
        )

    return way


def integrated(until_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return offset and speed of a hovering vehicle that holds its place in the same gusts."""

    def rates(time_s: float, state: np.ndarray) -> np.ndarray:
        place, speed, total = state.reshape(3, 2)
        air = GUSTS.velocities_mps(time_s, np.zeros((1, 3)))[0, :2]
        push = 0.054 * (np.hypot(*air) * air - 6.0 * np.array([6.0, 0.0]))
        error = -place - speed
        return np.concatenate([speed, push + 2.0 * error + total, error])

    solved = solve_ivp(rates, (until_s - 40.0, until_s), np.zeros(6), max_step=0.1, rtol=1e-6)
    return solved.y[:2, -1], solved.y[2:4, -1]


@pytest.mark.parametrize('time_s', [12.3, 77.0])
def test_drift_is_that_of_the_controlled_vehicle(time_s: float):
    """The equations of motion, integrated."""
    offset, rate = drift(GUSTS).at(round((100.0 + time_s) * SECOND), moving(), None)
    expected, speed = integrated(time_s)
    assert offset == pytest.approx(expected, abs=0.01)
    assert rate == pytest.approx(speed, abs=0.01)


@pytest.mark.slow
def test_drift_grows_with_gusts_and_airspeed():
    """In the mean wind there is none."""

    def size(wind: WindField, velocity: tuple[float, float]) -> float:
        own, way = drift(wind), moving(velocity)
        times = range(100 * SECOND, 400 * SECOND, 3 * SECOND)
        return float(np.mean([np.hypot(*own.at(time, way, None)[0]) for time in times]))

    still = size(GUSTS, (0.0, 0.0))
    assert 0.04 < still < 0.2
    stronger = replace(GUSTS, sigma_east_mps=1.6, sigma_north_mps=1.6)
    assert size(stronger, (0.0, 0.0)) == pytest.approx(2.0 * still, rel=0.15)
    assert size(GUSTS, (-4.0, 0.0)) > 1.4 * still
    assert size(WIND, (5.0, 0.0)) == 0.0


def test_a_change_of_the_wind_is_held_within_seconds():
    """A record that turns: the offset grows, and is gone ten seconds later."""
    turned = RecordedWind(
        times_s=np.array([0.0, 50.0, 51.0]),
        towards_mps=np.array([[6.0, 0.0], [6.0, 0.0], [0.0, 6.0]]),
    )
    sizes = [
        np.hypot(*drift(turned).at(round((100.0 + time) * SECOND), moving(), None)[0])
        for time in (50.0, 52.5, 65.0)
    ]
    assert sizes[0] < 1e-9
    assert sizes[1] > 0.2
    assert sizes[2] < 0.02


def test_a_vehicle_that_flies_into_a_lee_is_pushed_upwind_and_comes_back():
    """The offset depends on the way, and another command forgets what was kept of the last."""

    class Lee:
        def velocities_mps(self, time_s: float, places_m: np.ndarray) -> np.ndarray:
            found = WIND.velocities_mps(time_s, places_m)
            found[(np.abs(places_m[:, 1] - 100.0) < 10.0)] = 0.0
            return found

    own, way = drift(Lee()), moving((0.0, 5.0))
    offsets = [own.at(round((100.0 + t) * SECOND), way, 'fly')[0][0] for t in (17.0, 19.5, 40.0)]
    assert abs(offsets[0]) < 1e-6
    assert offsets[1] < -0.1
    assert abs(offsets[2]) < 0.01
    assert own.at(round(119.5 * SECOND), moving(), 'hold')[0] == pytest.approx((0.0, 0.0))


@pytest.mark.slow
def test_vehicle_is_pushed_in_the_air_and_not_on_the_ground(tmp_path: Path):
    """Its fix is where it is; another process of the same seed is at the same place."""
    wind = tmp_path / 'wind.yaml'
    wind.write_text('{towards_east_mps: 5.0, gust_std_mps: 1.0}', encoding='utf-8')
    options = VehicleOptions(
        origin_latitude_deg=53.28, origin_longitude_deg=-9.06, origin_altitude_m=10.0,
        wind_east_mps=5.0, wind_file=str(wind), gps_horizontal_std_m=0.0, gps_vertical_std_m=0.0,
    )  # fmt: skip
    home = GeoPosition(53.28, -9.06, 10.0)
    shared = make_shared(options)
    places = []
    for _ in range(2):
        rav = make_rav(options, 'rav1', home, shared, None)
        seen, _ = rav.step(SECOND)
        assert seen.pose.position_enu[:2] == pytest.approx((0.0, 0.0), abs=1e-6)
        rav.vehicle.fly_route(replace(ROUTE, home_enu=(0.0, 0.0, 0.0)))
        seen, _ = rav.step(60 * SECOND)
        places.append(seen.pose.position_enu)
        calm = rav.vehicle.pose_at(60 * SECOND).position_enu
        assert 0.02 < np.hypot(places[-1][0] - calm[0], places[-1][1] - calm[1]) < 2.0
        assert places[-1][2] == calm[2]
        assert rav.fix(60 * SECOND, places[-1]).position_enu == pytest.approx(places[-1])
    assert places[0] == places[1]
