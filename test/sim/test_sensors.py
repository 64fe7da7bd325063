# SPDX-License-Identifier: Apache-2.0
"""Sensors of motion, air, field and distance: true values, errors as stated, restarts."""

import math
from dataclasses import asdict

import numpy as np
import pytest
import yaml
from test.sim.flights import HOME, ROUTE, START_NS
from test.sim.vehicle_files import cameras_file

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import rotation_enu_from_body, rotation_of_quaternion
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.value_file import ValueFileError
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.options import RavOptions
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.shared_parts import make_shared
from rocsafe_sim.sensors.barometer import pressure_pa
from rocsafe_sim.sensors.earth_field import gravity_mps2, magnetic_field_ut, year_of
from rocsafe_sim.sensors.errors_over_time import Draws, ErrorModel
from rocsafe_sim.sensors.readings import (
    ImuReading,
    MagneticReading,
    PressureReading,
    RangeReading,
)
from rocsafe_sim.sensors.sensor_settings import (
    BarometerSettings,
    ImuSettings,
    MagnetometerSettings,
    RangefinderSettings,
    SensorRig,
)
from rocsafe_sim.sensors.sensor_suite import LONGEST_BURST_NS
from rocsafe_sim.sensors.streams import Stream

ORIGIN = GeoPosition(53.28, -9.06, 60.0)
FRAME = LocalFrame(ORIGIN)
STEP_NS = NS_PER_S // 10
ALL = SensorRig(
    imu=ImuSettings(),
    barometer=BarometerSettings(),
    magnetometer=MagnetometerSettings(),
    range=RangefinderSettings(max_m=60.0),
)
EXACT = SensorRig(
    imu=ImuSettings(
        gyroscope_noise=0.0,
        gyroscope_drift_std_radps=0.0,
        accelerometer_noise=0.0,
        accelerometer_drift_std_mps2=0.0,
    ),
    barometer=BarometerSettings(noise_std_pa=0.0, drift_std_pa=0.0),
    magnetometer=MagnetometerSettings(noise_std_ut=0.0, drift_std_ut=0.0),
    range=RangefinderSettings(noise_std_m=0.0, max_m=60.0),
)


def equipped(folder, rig, spool=None, **values):
    """Return a RAV with a tiny camera that has just been told to fly; its body sways."""
    folder.mkdir(exist_ok=True)
    given = {key: value for key, value in asdict(rig).items() if value is not None}
    (folder / 'sensors.yaml').write_text(yaml.safe_dump(given), encoding='utf-8')
    options = RavOptions(
        origin_latitude_deg=ORIGIN.latitude_deg,
        origin_longitude_deg=ORIGIN.longitude_deg,
        origin_altitude_m=ORIGIN.altitude_m,
        cameras_file=cameras_file(folder, {'image_width_px': 16, 'image_height_px': 16}),
        sensors_file=str(folder / 'sensors.yaml'),
        **{'tilt_std_deg': 1.0, 'attitude_std_deg': 0.0, **values},
    )
    home = FRAME.position_of(HOME)
    return make_rav(options, 'rav1', home, make_shared(options), spool)


def launched(*arguments, **values):
    """Return a RAV as `equipped` that has just been told to fly."""
    rav = equipped(*arguments, **values)
    rav.vehicle.step(START_NS)
    rav.vehicle.fly_route(ROUTE)
    rav.keep_journal()
    return rav


def flown(rav, seconds, step_ns=STEP_NS, start_ns=START_NS):
    """Return all readings of a flight."""
    found = []
    for time_ns in range(start_ns + step_ns, start_ns + int(seconds * NS_PER_S) + 1, step_ns):
        rav.step(time_ns)
        found += rav.readings
    return found


def of(kind, readings):
    """Return the readings of one kind."""
    return [one for one in readings if isinstance(one, kind)]


def turned(vector):
    """Return the rotation (3, 3) about a vector by its length in rad (Rodrigues)."""
    angle = np.linalg.norm(vector)
    x, y, z = vector / max(angle, 1e-15)
    cross = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    return np.eye(3) + math.sin(angle) * cross + (1.0 - math.cos(angle)) * cross @ cross


@pytest.mark.slow
def test_exact_inertial_samples_add_up_to_the_flight(tmp_path):
    """Summed up from rest they give velocity, place and orientation of the moving vehicle.

    Velocities are exact to rounding; places are the sums of 10 ms steps, of which each is wrong by
    a half of the change of velocity: 0.05 m/s of 5 m/s^2 in 10 ms, in all by 10 ms at 8 m/s.
    """
    rav = launched(tmp_path, EXACT)
    gravity = gravity_mps2(ORIGIN)
    first = rav.vehicle.pose_at(START_NS)
    rotation = rotation_enu_from_body(first.yaw_rad, 0.0, 0.0)
    velocity, place = np.zeros(3), np.array(first.position_enu)
    for sample in of(ImuReading, flown(rav, 40.0)):
        rotation = rotation @ turned(np.array(sample.rate_radps) * 0.01)
        velocity = velocity + (rotation @ sample.force_mps2 - (0.0, 0.0, gravity)) * 0.01
        place = place + velocity * 0.01
        assert rotation_of_quaternion(sample.orientation_xyzw) == pytest.approx(rotation, abs=1e-9)
    pose = rav.vehicle.pose_at(rav.vehicle.time_ns)
    assert pose.speed_mps > 1.0
    assert velocity == pytest.approx(pose.velocity_enu, abs=1e-6)
    assert place == pytest.approx(pose.position_enu, abs=0.1)


def test_at_rest_the_accelerometer_feels_gravity_upwards(tmp_path):
    """On the ground nothing sways, and nothing turns."""
    rav = equipped(tmp_path, EXACT)
    rav.vehicle.step(START_NS)
    samples = of(ImuReading, flown(rav, 1.0))
    assert len(samples) == 100
    assert samples[-1].force_mps2 == pytest.approx((0.0, 0.0, gravity_mps2(ORIGIN)), abs=1e-9)
    assert samples[-1].rate_radps == pytest.approx((0.0, 0.0, 0.0), abs=1e-9)


@pytest.mark.slow
def test_pressure_and_distance_tell_the_height(tmp_path):
    """The exact barometer inverts to the altitude, the exact beam to the height over its tilt."""
    rav = launched(tmp_path, EXACT)
    readings = flown(rav, 25.0)
    up_m = rav.vehicle.pose_at(rav.vehicle.time_ns).position_enu[2]
    assert up_m > 20.0
    pressure = of(PressureReading, readings)[-1].pressure_pa
    assert pressure == pytest.approx(pressure_pa(60.0 + up_m, 101_325.0), abs=0.05)
    distance = of(RangeReading, readings)[-1].distance_m
    tilt = math.radians(1.0) * 3.5
    assert up_m - 1e-6 <= distance <= up_m / math.cos(tilt)


def test_a_beam_out_of_its_limits_says_so(tmp_path):
    """By REP 117: too near is -infinite, nothing there is infinite; upwards there is nothing."""
    low = equipped(tmp_path / 'low', SensorRig(range=RangefinderSettings(noise_std_m=0.0)))
    low.vehicle.step(START_NS)
    assert flown(low, 1.0)[-1].distance_m == -math.inf
    high = launched(tmp_path / 'high', SensorRig(range=RangefinderSettings()))
    assert flown(high, 25.0)[-1].distance_m == math.inf
    up = launched(tmp_path / 'up', SensorRig(range=RangefinderSettings(pitch_deg=10.0)))
    assert {one.distance_m for one in flown(up, 15.0)} == {math.inf}


def test_a_slanted_beam_is_longer(tmp_path):
    """At 30 degrees above straight down the ground is farther by 1 / cos 30, without sway."""
    settings = RangefinderSettings(noise_std_m=0.0, max_m=100.0, pitch_deg=-60.0, yaw_deg=40.0)
    rav = launched(tmp_path, SensorRig(range=settings), tilt_std_deg=0.0)
    reading = flown(rav, 25.0)[-1]
    up_m = rav.vehicle.pose_at(reading.time_ns).position_enu[2]
    assert reading.distance_m == pytest.approx(up_m / math.cos(math.radians(30.0)), rel=1e-9)


def test_the_magnetic_field_is_that_of_the_world_magnetic_model():
    """East, north, up in nT, computed by pygeomag 1.1.0 from the same published coefficients.

    The second row is also the first of the model's own table of test values.
    """
    for latitude, longitude, altitude, year, expected in (
        (53.28, -9.06, 60.0, 2025.5, (-812.93, 18765.52, -45699.4)),
        (80.0, 0.0, 0.0, 2025.0, (145.89, 6521.6, -54791.51)),
        (-33.0, 151.0, 1000.0, 2027.5, (5399.23, 24528.94, 50614.31)),
        (0.0, 120.0, 0.0, 2025.0, (-109.61, 39677.76, 10580.17)),
    ):
        field = magnetic_field_ut(GeoPosition(latitude, longitude, altitude), year)
        assert [1e3 * value for value in field] == pytest.approx(expected, abs=0.006)
    assert year_of(START_NS) == pytest.approx(2023.87, abs=0.01)
    first, last = magnetic_field_ut(ORIGIN, 2025.0), magnetic_field_ut(ORIGIN, 2030.0)
    assert magnetic_field_ut(ORIGIN, 1970.0) == first
    assert magnetic_field_ut(ORIGIN, 2090.0) == last != first


@pytest.mark.slow
def test_the_magnetometer_turns_with_the_vehicle(tmp_path):
    """Turned back by the true orientation, its samples are the field."""
    rav = launched(tmp_path, EXACT)
    readings = flown(rav, 30.0)
    field = magnetic_field_ut(ORIGIN, year_of(START_NS))
    orientations = {
        one.time_ns: rotation_of_quaternion(one.orientation_xyzw)
        for one in of(ImuReading, readings)
    }
    for sample in of(MagneticReading, readings):
        back = orientations[sample.time_ns] @ sample.field_ut
        assert back == pytest.approx(field, abs=1e-9)


def test_gravity_and_pressure_are_those_of_the_tables():
    """WGS84: 9.8061977 at 45 deg, 9.8321849 at the pole; ICAO: 89 874.6 Pa at 1000 m'."""
    assert gravity_mps2(GeoPosition(45.0, 0.0, 0.0)) == pytest.approx(9.8061977, abs=1e-6)
    assert gravity_mps2(GeoPosition(90.0, 0.0, 0.0)) == pytest.approx(9.8321849, abs=1e-6)
    geometric_m = 6_356_766.0 * 1000.0 / (6_356_766.0 - 1000.0)
    assert pressure_pa(0.0, 101_325.0) == 101_325.0
    assert pressure_pa(geometric_m, 101_325.0) == pytest.approx(89_874.6, abs=0.1)


def test_errors_have_the_stated_size():
    """White and drift add up to the stated variance, and a drift stays for its period.

    4000 white values give their deviation within 5 %, 400 independent drifts within 15 %.
    """
    model = ErrorModel(
        white_std=2.0,
        drift_std=0.5,
        drift_period_ns=NS_PER_S,
        streams=(Stream.RANGE_WHITE, Stream.RANGE_DRIFT),
    )
    draws = Draws(seed=3, vehicle='rav1')
    both = np.array([model.at(draws, 10**7 * number) for number in range(4000)])
    assert both.std(axis=0) == pytest.approx([math.sqrt(model.variance)] * 3, rel=0.05)
    drifts = np.array(
        [draws.drift(Stream.RANGE_DRIFT, 2 * NS_PER_S * n + 10**8, NS_PER_S) for n in range(400)]
    )
    assert drifts.std(axis=0) == pytest.approx([1.0] * 3, rel=0.15)
    near = np.array(
        [draws.drift(Stream.RANGE_DRIFT, 2 * NS_PER_S * n + 2 * 10**8, NS_PER_S)
         for n in range(400)]
    )  # fmt: skip
    assert np.corrcoef(drifts[:, 0], near[:, 0])[0, 1] > 0.95


@pytest.mark.slow
def test_measured_samples_err_as_their_variances_say(tmp_path):
    """The errors of 2000 samples at rest have the deviations that the messages state.

    The drift hardly moves in 20 s: only the white part is seen, the variance less the drift's.
    """
    settings = ImuSettings(gyroscope_drift_std_radps=0.0, accelerometer_drift_std_mps2=0.0)
    rav = equipped(tmp_path, SensorRig(imu=settings))
    rav.vehicle.step(START_NS)
    samples = of(ImuReading, flown(rav, 20.0))
    rates = np.array([one.rate_radps for one in samples])
    forces = np.array([one.force_mps2 for one in samples])
    assert rates.std(axis=0) == pytest.approx([8.7e-4] * 3, rel=0.06)
    assert forces.std(axis=0) == pytest.approx([3.9e-2] * 3, rel=0.06)
    assert samples[0].rate_variance == pytest.approx(8.7e-4**2)
    assert samples[0].force_variance == pytest.approx(3.9e-2**2)


@pytest.mark.slow
def test_the_orientation_errs_as_a_photograph_does(tmp_path):
    """Its deviation is attitude_std_deg; over 20 s it is one slow turn, of a few deviations."""
    rig = SensorRig(imu=ImuSettings())
    true, wrong = (
        flown(launched(tmp_path / name, rig, attitude_std_deg=std), 5.0)
        for name, std in (('true', 0.0), ('wrong', 2.0))
    )
    one, other = (rotation_of_quaternion(each[-1].orientation_xyzw) for each in (true, wrong))
    angle = math.acos(min(1.0, 0.5 * (np.trace(one.T @ other) - 1.0)))
    assert 0.0 < angle < math.radians(2.0) * 5.0
    assert wrong[-1].orientation_variance == pytest.approx(math.radians(2.0) ** 2)


@pytest.mark.slow
def test_step_and_order_do_not_change_a_sample(tmp_path):
    """Steps of 50 ms and of 0.2 s give the same samples, with the same seed only."""
    fine = flown(launched(tmp_path / 'fine', ALL), 8.0, STEP_NS // 2)
    coarse = flown(launched(tmp_path / 'coarse', ALL), 8.0, 2 * STEP_NS)
    other = flown(launched(tmp_path / 'other', ALL, seed=2), 8.0)
    assert fine == coarse
    assert len(other) == len(fine)
    assert other != fine
    assert [one.time_ns for one in fine] == sorted(one.time_ns for one in fine)


@pytest.mark.slow
def test_a_restart_goes_on_with_the_samples(tmp_path):
    """What a process measures, and another started after it, is what one alone measures."""
    reference = flown(launched(tmp_path / 'one', ALL), 12.0)
    spool = tmp_path / 'spool'
    spool.mkdir()
    before = flown(launched(tmp_path / 'two', ALL, spool), 7.0)
    again = equipped(tmp_path / 'three', ALL, spool)
    after = flown(again, 5.0, start_ns=START_NS + 7 * NS_PER_S)
    assert before + after == reference


@pytest.mark.slow
def test_sensors_do_not_change_the_flight(tmp_path):
    """With and without them the vehicle is at the same places and takes the same photographs."""
    bare, full = (
        launched(tmp_path / name, rig) for name, rig in (('bare', SensorRig()), ('full', ALL))
    )
    for time_ns in range(START_NS + STEP_NS, START_NS + 60 * NS_PER_S, STEP_NS):
        assert bare.step(time_ns) == full.step(time_ns)
        assert bare.readings == []
    assert bare.vehicle.record == full.vehicle.record


def test_after_a_pause_old_samples_are_left_out(tmp_path):
    """A process that stood still does not send what nobody waited for."""
    rav = equipped(tmp_path, SensorRig(imu=ImuSettings()))
    rav.step(START_NS)
    assert len(rav.readings) == 100
    rav.step(START_NS + 3600 * NS_PER_S)
    assert len(rav.readings) == 100
    assert rav.readings[0].time_ns > rav.vehicle.time_ns - LONGEST_BURST_NS


@pytest.mark.parametrize(
    ('content', 'line'),
    [
        ({'imu': {'rate_hz': 0.0}}, 'imu.rate_hz|rate_hz is 0'),
        ({'imu': {'rate_hz': 4000.0}}, 'rate_hz is 4000: must be 0.01 to 400'),
        ({'barometer': {'noise_std_pa': -1.0}}, 'noise_std_pa is -1'),
        ({'barometer': {'sea_level_pressure_pa': 1013.25}}, 'sea_level_pressure_pa is 1013.25'),
        ({'magnetometer': {'drift_std_ut': math.nan}}, 'drift_std_ut'),
        ({'range': {'min_m': 20.0, 'max_m': 12.0}}, 'min_m is 20'),
        ({'range': {'pitch_deg': -91.0}}, 'pitch_deg is -91'),
        ({'lidar': {}}, 'lidar'),
    ],
)
def test_wrong_settings_are_refused(tmp_path, content, line):
    """The line names file, key, value and limit."""
    path = tmp_path / 'sensors.yaml'
    path.write_text(yaml.safe_dump(content), encoding='utf-8')
    with pytest.raises(ValueFileError, match=line) as caught:
        RavOptions(sensors_file=str(path)).sensors()
    assert 'sensors.yaml' in str(caught.value)
