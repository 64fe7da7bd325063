# SPDX-License-Identifier: Apache-2.0
"""The simulated air of a mission: settings, what is where, and what vehicles read."""

import math
import typing
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_dispersion.air_field.air_file import (
    PARTICLES,
    AirFile,
    ReleaseSettings,
    WindSettings,
)
from rocsafe_dispersion.air_field.air_making import air_field, read_air
from rocsafe_dispersion.air_field.air_options import AirOptions
from rocsafe_dispersion.air_field.vehicle_sensors import Moment, Readings, VehicleSensors
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_scenario.blocks.air import GasSensorKind, ReleasedAgent

S = 1_000_000_000
TANKER = GeoPosition(53.28, -9.06, 60.0)
AT = (TANKER.latitude_deg, TANKER.longitude_deg)
CHLORINE = ReleaseSettings(name='tanker', agent='chlorine', position=AT, rate_g_s=50.0)
SPORES = ReleaseSettings(name='spores', agent=PARTICLES.name, position=AT, rate_per_s=1e9)
EASTWARDS = WindSettings(towards_east_mps=4.0)
SETTINGS = AirFile(
    wind=EASTWARDS,
    releases=(CHLORINE, SPORES),
    gas_sensors=('electrochemical_chlorine', 'pid_10_6_ev'),
    particle_counter=True,
    ground_altitude_m=60.0,
)


def place(east: float, north: float, height: float = 2.0):
    """Return a place beside the tanker."""
    found = offset(TANKER, east, north, height)
    return found.latitude_deg, found.longitude_deg, found.altitude_m


def flown(settings: AirFile, where, seconds: int, *, first: int = 0, seed: int = 1):
    """Return the readings of a vehicle that stands at `where`, five moments a second."""
    sensors = VehicleSensors('rav1', settings, air_field(settings, seed), 1.0, seed)
    found: list[Readings] = []
    for tick in range(first * 5, seconds * 5 + 1):
        moment = Moment(time_ns=1000 * S + tick * S // 5, place=where, believed=where)
        found.append(sensors.add(moment, tick / 5.0))
    gases = [reading for one in found for reading in one.gases]
    return gases, [one.window for one in found if one.window]


@pytest.mark.slow
def test_gas_is_downwind():
    """East of the release in a wind towards the east, not west of it."""
    air = air_field(SETTINGS, 1)
    sums = [
        sum(air.gases_g_m3(time, place(east, 0.0))[0][1] for time in np.arange(100.0, 130.0))
        for east in (40.0, -40.0)
    ]
    assert sums[0] > 1e-3
    assert sums[1] == 0.0


@pytest.mark.slow
def test_sensors_of_a_vehicle_read_gas_particles_and_wind():
    """Chlorine by its cell, not by the lamp; spores by the counter; the wind by the anemometer."""
    gases, windows = flown(SETTINGS, place(40.0, 0.0), 230)
    largest = {}
    for sensor, measured in gases:
        largest[sensor.name] = max(largest.get(sensor.name, 0.0), measured.raw)
    assert largest['electrochemical_chlorine'] > 10.0
    assert largest['pid_10_6_ev'] < 0.5
    assert max(window.count.particles_per_l for window in windows) > 20_000.0
    east = np.mean([window.wind.towards_mps[0] for window in windows])
    assert 2.0 < east < 3.6


@pytest.mark.slow
def test_an_open_path_reads_what_is_below_and_not_what_the_rotors_take_in():
    """Ten metres above a plume that is low, beside a lamp that is above it."""
    leak = replace(CHLORINE, agent='methane', height_m=0.5, rate_g_s=2.0)
    settings = replace(
        SETTINGS, releases=(leak,), gas_sensors=('open_path_methane',), particle_counter=False
    )
    where = place(25.0, 0.0, 12.0)
    air = air_field(settings, 1)
    ((chemical, column),) = air.columns_g_m2(100.0, where)
    heights = np.linspace(0.0, 12.0, 1201)
    each = [air.gases_g_m3(100.0, place(25.0, 0.0, height))[0][1] for height in heights]
    assert column == pytest.approx(np.trapezoid(each, heights), rel=0.02)
    gases, _ = flown(replace(settings, dilution=0.01), where, 110)
    shown = {one.time_ns: one.raw for sensor, one in gases if sensor.unit == 'ppm_m'}
    assert max(shown.values()) > 100.0
    assert shown[1100 * S] == pytest.approx(chemical.ppm(column), rel=0.5, abs=10.0)


@pytest.mark.slow
def test_readings_do_not_depend_on_restarts():
    """Of gas and wind; of the counter its counts."""
    whole_gases, whole = flown(SETTINGS, place(40.0, 0.0), 260)
    gases, windows = flown(SETTINGS, place(40.0, 0.0), 260, first=33)
    by_end = {(sensor.name, one.time_ns): one for sensor, one in whole_gases}
    assert gases
    assert all(by_end[sensor.name, one.time_ns] == one for sensor, one in gases)
    by_window = {one.time_ns: one for one in whole}
    assert all(by_window[one.time_ns].wind == one.wind for one in windows)
    assert all(by_window[one.time_ns].count.total == one.count.total for one in windows)


def test_settings_are_read_from_a_file(tmp_path: Path):
    """As a scenario's block is written."""
    file = tmp_path / 'air.yaml'
    content = {
        'wind': {'towards_east_mps': 4.0, 'stability': 'E', 'gust_std_mps': 0.5},
        'releases': [{'name': 'a', 'agent': 'ammonia', 'position': list(AT), 'rate_g_s': 3.0}],
        'gas_sensors': ['electrochemical_ammonia'],
    }
    file.write_text(yaml.safe_dump(content), encoding='utf-8')
    settings = read_air(AirOptions(air_file=str(file)))
    assert settings.releases[0].agent == 'ammonia'
    assert settings.wind.stability == 'E'
    assert air_field(settings, 1).gases_g_m3(100.0, place(20.0, 0.0))


def test_a_warm_light_gas_passes_above():
    """Hot ammonia is less dense near the ground downwind than ammonia that does not rise."""
    cold = replace(CHLORINE, agent='ammonia')
    airs = [
        air_field(AirFile(wind=EASTWARDS, releases=(each,), ground_altitude_m=60.0), 1)
        for each in (cold, replace(cold, temperature_c=150.0))
    ]
    plain, warm = (
        sum(air.gases_g_m3(time, place(25.0, 0.0, 0.5))[0][1] for time in np.arange(60.0, 90.0))
        for air in airs
    )
    assert 0.0 < warm < 0.9 * plain


def test_still_air_has_no_releases():
    """And without them it is allowed."""
    assert air_field(AirFile(), 1).gases_g_m3(10.0, place(1.0, 0.0)) == []
    with pytest.raises(ValueError, match=r'wind is 0 m/s: must be'):
        air_field(replace(SETTINGS, wind=WindSettings()), 1)


def test_scenario_knows_the_same_names():
    """Of agents that may be released, and of sensors."""
    released = {one.name for one in agents().values() if one.is_industrial} | {PARTICLES.name}
    assert set(typing.get_args(ReleasedAgent)) == released
    assert set(typing.get_args(GasSensorKind)) == set(GAS_SENSORS)


@pytest.mark.parametrize(
    ('make', 'named'),
    [
        (lambda: replace(CHLORINE, agent='sarin'), r'industrial chemicals only'),
        (lambda: replace(CHLORINE, agent='water'), r'is not known'),
        (lambda: replace(CHLORINE, rate_g_s=0.0), r'tanker: needs exactly one'),
        (lambda: replace(CHLORINE, rate_g_s=0.0, rate_per_s=5.0), r'needs exactly one'),
        (lambda: replace(CHLORINE, position=(99.0, 0.0)), r'latitude'),
        (lambda: replace(SPORES, temperature_c=20.0), r'spores: temperature_c needs rate_g_s'),
        (lambda: replace(SETTINGS, releases=(CHLORINE, CHLORINE)), r'different names'),
        (lambda: replace(SETTINGS, gas_sensors=('nose',)), r'nose'),
        (lambda: WindSettings(towards_east_mps=math.nan), r'towards_east_mps'),
        (lambda: AirOptions(vehicles=('a', 'a')), r'vehicles'),
    ],
)
def test_bad_settings_are_refused(make, named):
    """By their names."""
    with pytest.raises(ValueError, match=named):
        make()
