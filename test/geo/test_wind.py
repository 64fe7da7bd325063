# SPDX-License-Identifier: Apache-2.0
"""The wind: conventions, profile, gusts and records."""

import math
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_geo.wind.anemometer_file import RecordedWind, read_wind
from rocsafe_geo.wind.gusts import STEPS_A_SCALE, GustyWind, correlated_noise
from rocsafe_geo.wind.similarity import SurfaceLayer, stability_correction, surface_layer
from rocsafe_geo.wind.wind_field import ProfileWind, UniformWind
from rocsafe_geo.wind.wind_vector import WindVector, wind_from

PLACES = np.array([[0.0, 0.0, 2.0], [50.0, -20.0, 10.0], [0.0, 0.0, 40.0]])


def test_west_wind_goes_east():
    """A wind from 270 degrees blows towards the east."""
    wind = wind_from(5.0, 270.0)
    assert wind.towards_east_mps == pytest.approx(5.0)
    assert wind.towards_north_mps == pytest.approx(0.0, abs=1e-12)


@given(st.floats(0.1, 90.0), st.floats(0.0, 359.9))
def test_direction_survives_a_round_trip(speed: float, direction: float):
    """Speed and direction come back from the components."""
    wind = wind_from(speed, direction)
    assert wind.speed_mps == pytest.approx(speed)
    assert math.cos(math.radians(wind.from_deg - direction)) == pytest.approx(1.0)


def test_neutral_profile_is_logarithmic():
    """u* / k ln(z / z0)."""
    layer = SurfaceLayer(friction_velocity_mps=0.4, roughness_m=0.1)
    assert float(layer.speed_mps(10.0)) == pytest.approx(math.log(100.0))


def test_prairie_grass_profile():
    """Friction velocity, length and wind at 2 m of runs 9 and 17 belong together within 10 %."""
    for friction, length, speed in ((0.46, -31.0, 7.0), (0.21, 48.0, 3.41)):
        layer = SurfaceLayer(
            friction_velocity_mps=friction, obukhov_length_m=length, roughness_m=0.006
        )
        assert float(layer.speed_mps(2.0)) == pytest.approx(speed, rel=0.1)


def test_correction_agrees_with_published_points():
    """Unstable: Paulson 1970 at z/L = -1: 1.116; stable: about -5 z/L for small z/L."""
    assert float(stability_correction(-1.0)) == pytest.approx(1.116, abs=0.005)
    assert float(stability_correction(0.01)) == pytest.approx(-0.05, abs=0.002)
    assert float(stability_correction(0.0)) == pytest.approx(0.0, abs=1e-12)


@given(st.floats(0.5, 20.0), st.floats(2.0, 50.0), st.sampled_from([-20.0, math.inf, 30.0]))
def test_layer_has_the_wind_that_was_measured(speed: float, height: float, length: float):
    """And grows with the height."""
    layer = surface_layer(speed, height, length)
    assert float(layer.speed_mps(height)) == pytest.approx(speed)
    assert (np.diff(layer.speed_mps(np.linspace(0.0, 100.0, 50))) >= 0.0).all()


def test_profile_wind_has_its_direction_at_all_heights():
    """And its speed at the reference height."""
    wind = WindVector(towards_east_mps=3.0, towards_north_mps=-4.0)
    layer = SurfaceLayer(friction_velocity_mps=0.3)
    found = ProfileWind(layer=layer, wind=wind).velocities_mps(0.0, PLACES)
    assert found[1] == pytest.approx([3.0, -4.0, 0.0])
    assert np.allclose(found[:, 0] * -4.0, found[:, 1] * 3.0)
    assert np.linalg.norm(found[2]) > 5.0 > np.linalg.norm(found[0])


def test_gusts_are_a_function_of_seed_and_time():
    """The order of questions changes nothing, another seed changes all."""
    mean = UniformWind(wind=WindVector(towards_east_mps=3.0, towards_north_mps=0.0))
    wind = GustyWind(mean=mean, sigma_east_mps=1.0, sigma_north_mps=0.5, seed=7)
    other = GustyWind(mean=mean, sigma_east_mps=1.0, sigma_north_mps=0.5, seed=8)
    times = [-300.0, 0.0, 17.3, 512.7, 9999.0]
    forward = [wind.velocities_mps(time, PLACES) for time in times]
    backward = [wind.velocities_mps(time, PLACES) for time in reversed(times)]
    assert np.array_equal(forward, backward[::-1])
    assert not np.allclose(forward[0], other.velocities_mps(times[0], PLACES))


@pytest.mark.slow
def test_gusts_have_their_variance_and_correlation():
    """Variance 1 also between steps, correlation 1/e after one time scale."""
    times = np.arange(0.0, 4000.0, 0.275)
    noise = np.array([correlated_noise(3, time) for time in times])
    # 4000 time scales give about 2000 independent values: 1 / sqrt(1000) of the variance.
    assert noise.var(axis=0) == pytest.approx(np.ones(3), abs=0.1)
    later = np.array([correlated_noise(3, time + 1.0) for time in times])
    assert (noise * later).mean(axis=0) == pytest.approx(np.full(3, math.exp(-1.0)), abs=0.1)


def test_gusts_change_little_in_a_little_time():
    """Also where one block of noise follows another."""
    steps = np.arange(-1.2, 1.2, 0.001) * 512 / STEPS_A_SCALE
    noise = np.array([correlated_noise(3, time) for time in steps])
    assert np.abs(np.diff(noise, axis=0)).max() < 1.0


def test_record_is_read_in_both_conventions(tmp_path: Path):
    """Components, and speed with the direction it comes from, give the same wind."""
    vector, source = tmp_path / 'vector.csv', tmp_path / 'from.csv'
    vector.write_text(
        'time_s,wind_towards_east_mps,wind_towards_north_mps\n0,0,-2\n10,2,0\n', encoding='utf-8'
    )
    source.write_text('time_s,wind_speed_mps,wind_from_deg\n0,2,0\n10,2,270\n', encoding='utf-8')
    winds = [read_wind(path).velocities_mps(5.0, PLACES) for path in (vector, source)]
    assert np.allclose(winds[0], [1.0, -1.0, 0.0])
    assert np.allclose(winds[0], winds[1])


def test_a_record_with_gaps_is_read(tmp_path: Path):
    """Rows without a wind are left out; it is straight in between."""
    path = tmp_path / 'gaps.csv'
    path.write_text(
        'time_s,wind_speed_mps,wind_from_deg\n0,2,270\n5,,\n6,nan,270\n10,4,270\n,3,9\n',
        encoding='utf-8',
    )
    assert read_wind(path).wind_at(5.0).towards_east_mps == pytest.approx(3.0)


@pytest.mark.parametrize(
    ('text', 'named'),
    [
        ('', '0 rows'),
        ('time_s,speed,wind_direction\n0,1,2\n', 'wind_direction does not say'),
        ('time_s,wind_speed_mps\n0,1\n', 'needs either'),
        ('wind_speed_mps,wind_from_deg\n1,2\n', 'time_s is missing'),
        ('time_s,wind_speed_mps,wind_from_deg\n0,x,2\n', "line 2: wind_speed_mps is 'x'"),
        ('time_s,wind_speed_mps,wind_from_deg\n0,nan,2\n', 'must be finite'),
        ('time_s,wind_speed_mps,wind_from_deg\n0,-1,2\n', 'line 2: speed_mps is -1'),
        ('time_s,wind_speed_mps,wind_from_deg\n1,1,2\n0,1,2\n', 'must ascend'),
    ],
)
def test_bad_record_is_refused_in_one_line(tmp_path: Path, text: str, named: str):
    """Each by the name of what is wrong."""
    path = tmp_path / 'wind.csv'
    path.write_text(text, encoding='utf-8')
    with pytest.raises(ValueError, match=named) as error:
        read_wind(path)
    assert '\n' not in str(error.value)


def test_missing_record_is_refused(tmp_path: Path):
    """By its name."""
    with pytest.raises(ValueError, match=r'none\.csv'):
        read_wind(tmp_path / 'none.csv')


@pytest.mark.parametrize(
    'make',
    [
        lambda: WindVector(towards_east_mps=math.nan, towards_north_mps=0.0),
        lambda: wind_from(-1.0, 0.0),
        lambda: wind_from(1.0, 400.0),
        lambda: SurfaceLayer(friction_velocity_mps=0.0),
        lambda: SurfaceLayer(friction_velocity_mps=0.3, obukhov_length_m=0.0),
        lambda: surface_layer(3.0, 0.01, roughness_m=0.03),
        lambda: RecordedWind(times_s=np.zeros(0), towards_mps=np.zeros((0, 2))),
    ],
)
def test_bad_values_are_refused(make):
    """With one error type."""
    with pytest.raises(ValueError, match=r'must|needs'):
        make()
