# SPDX-License-Identifier: Apache-2.0
"""Detectors: what they see, how they follow, limits, and that restarts change nothing."""

import math
from dataclasses import replace

import numpy as np
import pytest

from rocsafe_dispersion.agents.agent_table import agent, agents
from rocsafe_dispersion.detection.gas_sensor import GasSensor, Intake
from rocsafe_dispersion.detection.particle_counter import CountingWindows, ParticleCounter
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_dispersion.detection.sensor_windows import GasSample, WindowSensor

S = 1_000_000_000
START_NS = 1_700_000_000 * S
PID, IMS = GAS_SENSORS['pid_10_6_ev'], GAS_SENSORS['ion_mobility']
HERE = (53.0, -9.0, 30.0)


def flown(sensor, value_at, seconds, *, intake=None, seed=1, vehicle='rav1', first=0.0):
    """Return the readings of a flight with ten samples a second from `first` seconds on."""
    windows = WindowSensor(sensor, intake or Intake(), vehicle, 1.0, seed)
    found = []
    for tick in range(round(first * 10), round(seconds * 10) + 1):
        time = tick / 10.0
        sample = GasSample(time_ns=START_NS + tick * S // 10, value=value_at(time), believed=HERE)
        found.append(windows.add(sample))
    return [one for one in found if one]


def step(time: float) -> float:
    """Return gas between 100 and 160 s."""
    return 50.0 if 100.0 < time <= 160.0 else 0.0


def at(readings, second: float):
    """Return the reading of the window that ends at a second."""
    return next(one for one in readings if one.time_ns == START_NS + round(second * S))


def quiet(sensor: GasSensor) -> GasSensor:
    """Return the sensor almost without noise and drift."""
    return replace(sensor, noise=1e-9, relative_noise=0.0, drift=0.0)


@pytest.mark.parametrize('name', ['chlorine', 'hydrogen_cyanide', 'methane', 'carbon_monoxide'])
def test_lamp_is_blind_above_its_energy(name):
    """However much of it there is."""
    assert PID.response(agent(name)) == 0.0
    assert PID.sees(agent(name)) is False


def test_lamp_knows_what_it_does_not_know():
    """An agent of unknown ionisation energy may or may not be seen."""
    assert PID.sees(agent('lewisite')) is None
    assert PID.sees(agent('acetone')) is True


def test_cross_sensitivity():
    """A channel reads another gas as its own."""
    chlorine = GAS_SENSORS['electrochemical_chlorine']
    assert chlorine.response(agent('chlorine')) == 1.0
    assert 0.0 < chlorine.response(agent('nitrogen_dioxide')) < 1.0
    assert chlorine.response(agent('ammonia')) == 0.0


def test_kinds_name_agents_of_the_table():
    """No response to an agent that does not exist."""
    for sensor in GAS_SENSORS.values():
        assert set(sensor.responses) <= set(agents())


@pytest.mark.parametrize('name', ['metal_oxide', 'electrochemical_ammonia', 'pid_10_6_ev'])
def test_sensor_follows_with_its_time_constants(name):
    """1 - 1/e of a step after the rise time, 1/e of it after the fall time."""
    sensor = quiet(GAS_SENSORS[name])
    times = np.arange(0.0, 600.0, 0.01)
    values = sensor.follow(times, np.where(times < 300.0, 1.0, 0.0))
    assert np.interp(sensor.rise_s, times, values) == pytest.approx(1.0 - math.exp(-1), abs=5e-3)
    assert np.interp(300.0 + sensor.fall_s, times, values) == pytest.approx(math.exp(-1), abs=5e-3)


def test_reading_corrected_for_its_delay_is_right_sooner():
    """Six seconds after a step the metal oxide sensor is within 3 % as corrected."""
    sensor = quiet(GAS_SENSORS['electrochemical_chlorine'])
    readings = flown(sensor, lambda time: 10.0 if time > 200.0 else 0.0, 230.0)
    late, early = at(readings, 206.0).raw, at(readings, 206.0).corrected
    assert late < 5.0
    assert early == pytest.approx(10.0, rel=0.03)


def test_downwash_dilutes_and_delays():
    """Half the gas, five seconds later."""
    sensor = quiet(PID)
    plain = flown(sensor, step, 160.0)
    blown = flown(sensor, step, 160.0, intake=Intake(dilution=0.5, delay_s=5.0))
    assert at(blown, 140.0).raw == pytest.approx(0.5 * at(plain, 135.0).raw, rel=1e-6)
    assert at(blown, 104.0).raw == pytest.approx(0.0, abs=1e-6)


def test_limits():
    """Clean air is below the limit of detection, much gas at the ceiling."""
    assert at(flown(PID, step, 60.0), 50.0).is_below_limit
    full = at(flown(PID, lambda _: 1e6, 60.0), 50.0)
    assert full.is_saturated
    assert full.raw == PID.ceiling


@pytest.mark.slow
def test_false_alarms_in_clean_air_are_rare():
    """Of 2000 readings at most 1 % are above the limit."""
    readings = flown(PID, lambda _: 0.0, 2020.0)
    assert sum(not one.is_below_limit for one in readings) <= 0.01 * len(readings)


@pytest.mark.slow
def test_ion_mobility_needs_minutes_after_an_overload():
    """Clean air or not, it stays at its ceiling, and shows bars, not numbers."""
    readings = flown(IMS, lambda time: 500.0 if 250.0 < time < 255.0 else 0.0, 520.0)
    assert not at(readings, 245.0).is_saturated
    assert at(readings, 245.0).bars <= 1
    assert at(readings, 330.0).is_saturated
    assert at(readings, 330.0).bars == len(IMS.bars)
    assert not at(readings, 500.0).is_saturated


@pytest.mark.slow
@pytest.mark.parametrize('name', ['pid_10_6_ev', 'metal_oxide', 'ion_mobility'])
def test_restart_changes_no_reading(name):
    """A sensor that starts in the middle of a flight gives the same readings, later."""
    sensor = GAS_SENSORS[name]
    whole, later = flown(sensor, step, 400.0), flown(sensor, step, 400.0, first=77.7)
    assert later == [one for one in whole if one.time_ns >= later[0].time_ns]
    assert later[0].time_ns - START_NS <= (77.7 + sensor.memory_s + 3.0) * S


def test_seed_and_vehicle_change_the_noise_only():
    """And the same seed gives the same bytes."""
    first = flown(PID, step, 140.0)
    assert first == flown(PID, step, 140.0)
    for other in (flown(PID, step, 140.0, seed=2), flown(PID, step, 140.0, vehicle='rav2')):
        pairs = [(a.raw, b.raw) for a, b in zip(first, other, strict=True)]
        assert any(a != b for a, b in pairs)
        assert all(abs(a - b) < 0.5 + 0.3 * a for a, b in pairs)


def test_reading_knows_where_it_was_taken():
    """The mean of the believed places."""
    assert at(flown(PID, step, 60.0), 50.0).believed == pytest.approx(HERE)


def test_after_a_gap_the_past_is_unknown():
    """No reading until the memory of the sensor is full again."""
    windows = WindowSensor(PID, Intake(), 'rav1', 1.0, 1)
    found = []
    for second in [*range(60), *range(100, 160)]:
        sample = GasSample(time_ns=START_NS + second * S, value=0.0, believed=HERE)
        found.append((second, windows.add(sample)))
    given = [second for second, reading in found if reading]
    assert not [second for second in given if 100 <= second < 100 + PID.memory_s]
    assert [second for second in given if second < 60]
    assert [second for second in given if second > 120]


def test_trigger_has_its_rate_of_false_alarms():
    """At 1 in 100, of 3000 windows of natural background 10 to 60 trigger."""
    counter = ParticleCounter(false_alarm_probability=0.01)
    windows = CountingWindows(counter, 'rav1', 1.0, 3)
    alarms = sum(windows.count(number, 0.0).is_triggered for number in range(3000))
    assert 10 <= alarms <= 60


def test_trigger_sees_a_release():
    """1000 particles in a litre within a second; 100 in most windows."""
    windows = CountingWindows(ParticleCounter(), 'rav1', 1.0, 3)
    for number in range(40):
        assert not windows.count(number, 0.0).is_triggered
    assert windows.count(40, 1000.0).is_triggered


def test_counts_do_not_depend_on_restarts():
    """Nor does the trigger, once it has its windows."""
    old, fresh = (CountingWindows(ParticleCounter(), 'rav1', 1.0, 3) for _ in range(2))
    for number in range(200):
        old.count(number, 0.0)
    for number in range(150, 200):
        fresh.count(number, 0.0)
    assert old.count(200, 50.0) == fresh.count(200, 50.0)


def test_particles_beyond_what_it_counts():
    """It says that it is blind most of the time."""
    windows = CountingWindows(ParticleCounter(), 'rav1', 1.0, 3)
    assert windows.count(0, 1e9).is_saturated
    assert not windows.count(1, 0.0).is_saturated


@pytest.mark.parametrize(
    'make',
    [
        lambda: Intake(dilution=0.0),
        lambda: Intake(delay_s=-1.0),
        lambda: replace(PID, limit=0.0),
        lambda: replace(PID, unit='%'),
        lambda: replace(IMS, bars=(2.0, 1.0)),
        lambda: WindowSensor(PID, Intake(), 'rav1', 0.0, 1),
        lambda: ParticleCounter(efficiency=2.0),
    ],
)
def test_bad_values_are_refused(make):
    """With one error type."""
    with pytest.raises(ValueError, match='must'):
        make()
