# SPDX-License-Identifier: Apache-2.0
"""Gusts that push vehicles off their way: the autopilot's response, restarts, the air's gusts."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from scipy.integrate import solve_ivp

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.wind.gusts import correlated_noise
from rocsafe_sim.flight.gust_drift import GustDrift
from rocsafe_sim.options import VehicleOptions
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.shared_parts import make_shared

from .flights import ROUTE

SECOND = 10**9
GUSTS = GustDrift(
    std_mps=0.8, scale_s=15.0, seed=5, start_ns=100 * SECOND, drag_per_m=0.054,
    wind_mps=(6.0, 0.0),
)  # fmt: skip


def integrated(until_s: float) -> tuple[np.ndarray, np.ndarray]:
    """Return offset and speed of a hovering vehicle that holds its place in the same gusts."""
    push = 0.054 * 0.8 * np.diag([2.0 * 6.0, 6.0])

    def rates(time_s: float, state: np.ndarray) -> np.ndarray:
        place, speed, total = state.reshape(3, 2)
        gust = correlated_noise(5, time_s / 15.0)[:2] @ push
        error = -place - speed
        return np.concatenate([speed, gust + 2.0 * error + total, error])

    solved = solve_ivp(rates, (until_s - 40.0, until_s), np.zeros(6), max_step=0.1, rtol=1e-6)
    return solved.y[:2, -1], solved.y[2:4, -1]


@pytest.mark.parametrize('time_s', [12.3, 77.0])
def test_drift_is_that_of_the_controlled_vehicle(time_s: float):
    """The equations of motion, integrated; the square of the gust is left out."""
    offset, rate = GUSTS.at(round((100.0 + time_s) * SECOND), (0.0, 0.0))
    expected, speed = integrated(time_s)
    assert offset == pytest.approx(expected, abs=0.02)
    assert rate == pytest.approx(speed, abs=0.02)


def test_drift_grows_with_gusts_and_airspeed():
    """No gusts: none."""

    def size(gusts: GustDrift, velocity: tuple[float, float]) -> float:
        times = range(100 * SECOND, 400 * SECOND, 3 * SECOND)
        return float(np.mean([np.hypot(*gusts.at(time, velocity)[0]) for time in times]))

    still = size(GUSTS, (0.0, 0.0))
    assert 0.04 < still < 0.2
    assert size(replace(GUSTS, std_mps=1.6), (0.0, 0.0)) == pytest.approx(2.0 * still, rel=0.05)
    assert size(GUSTS, (-4.0, 0.0)) > 1.4 * still
    assert size(replace(GUSTS, std_mps=0.0), (5.0, 0.0)) == 0.0


def test_vehicle_is_pushed_in_the_air_and_not_on_the_ground(tmp_path: Path):
    """Its fix is where it is; another process of the same seed is at the same place."""
    options = VehicleOptions(
        origin_latitude_deg=53.28, origin_longitude_deg=-9.06, origin_altitude_m=10.0,
        wind_east_mps=5.0, gust_std_mps=1.0, gps_horizontal_std_m=0.0, gps_vertical_std_m=0.0,
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
