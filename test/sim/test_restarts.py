# SPDX-License-Identifier: Apache-2.0
"""Restarts: a vehicle that is killed again and again flies as one that never was."""

from dataclasses import replace
from pathlib import Path
from tempfile import TemporaryDirectory

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from test.sim.flights import AIRFRAME, HOME, START_NS, airframes, at_s, routes, vehicle_on

from rocsafe_sim.flight.route import BatterySwap
from rocsafe_sim.vehicle.journal import read_journal, write_journal
from rocsafe_sim.vehicle.simulated_vehicle import SimulatedVehicle


def restarted(vehicle, path):
    """Return a vehicle that knows of `vehicle` what its journal says."""
    write_journal(path, vehicle.record)
    again = SimulatedVehicle(vehicle.airframe, HOME)
    again.restore(read_journal(path))
    return again


@pytest.mark.slow
@settings(max_examples=25, deadline=None)
@given(airframes(), routes(), st.lists(st.floats(0.1, 90.0), min_size=1, max_size=8), st.data())
def test_any_number_of_restarts_changes_no_photograph(airframe, route, gaps_s, data):
    """Swaps, delays and a battery that fails included, photographs and outcome are the same."""
    after = data.draw(st.integers(0, len(route.waypoints)))
    route = replace(route, swaps=(BatterySwap(after=after),), swap_s=30.0, delay_s=12.0)
    fails_after_s = data.draw(st.sampled_from([0.0, 45.0]))
    airframe = replace(airframe, fails_after_s=fails_after_s)
    whole = vehicle_on(route, airframe)
    expected = at_s(whole, 1e6).shots
    vehicle, taken, now_s = vehicle_on(route, airframe), [], 0.0
    with TemporaryDirectory() as folder:
        for gap_s in gaps_s:
            now_s += gap_s
            taken += at_s(vehicle, now_s).shots
            vehicle = restarted(vehicle, Path(folder) / 'journal.json')
    taken += at_s(vehicle, 1e6).shots
    assert tuple(taken) == expected
    assert vehicle.summary() == whole.summary()


def test_a_restart_on_the_ground_keeps_home():
    """A vehicle that never flew is where it was put."""
    vehicle = SimulatedVehicle(AIRFRAME, HOME)
    vehicle.step(START_NS)
    with TemporaryDirectory() as folder:
        again = restarted(vehicle, Path(folder) / 'journal.json')
    assert again.step(START_NS).pose.position_enu == HOME
    assert again.flight is None
