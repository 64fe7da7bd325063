# SPDX-License-Identifier: Apache-2.0
"""A vehicle that was cut off, because its process stood still or was away, holds where it was."""

from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from test.sim.flights import HOME, ROUTE, START_NS
from test.sim.vehicle_files import cameras_file

from rocsafe_geo.position import GeoPosition
from rocsafe_sim.clock.step_times import LONGEST_GAP_NS, StepTimes
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.options import RavOptions
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.rav.shared_parts import make_shared

STEP_NS = 200_000_000


@pytest.mark.parametrize('is_restarted', [False, True])
@pytest.mark.parametrize(
    ('is_lockstep', 'gap_ns', 'is_cut_off'),
    [
        (True, STEP_NS, False),
        (True, 2 * STEP_NS, True),
        (False, 2 * STEP_NS, False),
        (False, LONGEST_GAP_NS, False),
        (False, LONGEST_GAP_NS + 1, True),
    ],
)
def test_who_misses_a_step_in_lockstep_was_cut_off(
    tmp_path: Path, is_restarted: bool, is_lockstep: bool, gap_ns: int, is_cut_off: bool
) -> None:
    """Elsewhere it may miss some seconds; a process that is started again knows it, too."""
    times = StepTimes(tmp_path / 'steps', is_lockstep=is_lockstep)
    assert times.missed_ns(START_NS) == 0
    for number in range(3):
        times.note(START_NS + number * STEP_NS)
    if is_restarted:
        times = StepTimes(tmp_path / 'steps', is_lockstep=is_lockstep)
    last_ns = START_NS + 2 * STEP_NS
    assert times.last_ns == last_ns
    assert times.missed_ns(last_ns) == 0
    assert times.missed_ns(last_ns + gap_ns) == (gap_ns if is_cut_off else 0)


def rav_of(folder: Path) -> Rav:
    """Return a vehicle in lock-step that continues from what it kept in a folder."""
    files = cameras_file(folder, {'image_width_px': 160, 'image_height_px': 120})
    options = RavOptions(cameras_file=files, origin_latitude_deg=53.28)
    home = options.frame().position_of(HOME)
    place = GeoPosition(home.latitude_deg, home.longitude_deg, 0.0)
    return make_rav(options, 'rav1', place, make_shared(options), folder / 'rav1')


@pytest.mark.slow
@pytest.mark.parametrize('is_restarted', [False, True], ids=['stood still', 'was killed'])
@pytest.mark.parametrize(
    ('delay_s', 'mode'), [(0.0, Mode.HOLDING), (60.0, Mode.WAITING)], ids=['aloft', 'waits']
)
def test_vehicle_that_was_cut_off_flies_nothing_of_what_it_missed(
    tmp_path: Path, is_restarted: bool, delay_s: float, mode: Mode
) -> None:
    """It holds where it was, in the air or on the ground, and photographs nothing until told."""
    rav = rav_of(tmp_path)
    rav.step(START_NS)
    rav.vehicle.fly_route(replace(ROUTE, delay_s=delay_s))
    now_ns, taken = START_NS, 0
    for now_ns in range(START_NS, START_NS + 35 * 10**9, STEP_NS):
        assert rav.hold_if_cut_off(now_ns) == 0
        taken += len(rav.step(now_ns)[1])
    place = rav.vehicle.pose_at(now_ns).position_enu
    rav = rav_of(tmp_path) if is_restarted else rav
    back_ns = now_ns + 60 * 10**9
    assert rav.hold_if_cut_off(back_ns) == 60 * 10**9
    seen, shots = rav.step(back_ns)
    assert shots == []
    assert (seen.mode, seen.shots_taken) == (mode, taken)
    assert seen.pose.position_enu[:2] == pytest.approx(place[:2], abs=20.0)
    assert rav.hold_if_cut_off(back_ns + STEP_NS) == 0
    assert rav.step(back_ns + 600 * STEP_NS)[0].mode is mode


def test_an_order_after_a_restart_begins_where_it_was(tmp_path: Path) -> None:
    """Not where it was at its last order, though that alone is in the journal."""
    rav = rav_of(tmp_path)
    rav.step(START_NS)
    rav.vehicle.fly_route(ROUTE)
    for time_ns in range(START_NS, START_NS + 35 * 10**9, STEP_NS):
        rav.step(time_ns)
    again = rav_of(tmp_path)
    again.vehicle.hold()
    assert again.vehicle.pose_at(time_ns) == rav.vehicle.pose_at(time_ns)
    assert again.step(time_ns + 20 * 10**9)[0].mode is Mode.HOLDING
