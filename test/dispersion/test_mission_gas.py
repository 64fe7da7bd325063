# SPDX-License-Identifier: Apache-2.0
"""Readings of a flight: the survey that they make, what it says, where to measure next."""

import math

import numpy as np
import pytest

from rocsafe_dispersion.agents.agent_table import agent
from rocsafe_dispersion.estimation.found_release import ReleaseSamples
from rocsafe_dispersion.estimation.measuring_places import MeanAir, measuring_places, predicted
from rocsafe_dispersion.estimation.plume_kernel import PlumeShape
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_dispersion.mission_gas.gas_log import (
    GasFlightReading,
    GasLog,
    NoSurveyError,
    Sampling,
    WindFlightReading,
)
from rocsafe_dispersion.mission_gas.gas_spool import GasSpool
from rocsafe_dispersion.mission_gas.release_assessment import (
    AssessmentOptions,
    assess,
    suggested_places,
)
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition

from .airs import EASTWARDS, LAYER, SPEED_MPS

ORIGIN = GeoPosition(53.28, -9.06, 60.0)
FRAME = LocalFrame(ORIGIN)
QUICK = AssessmentOptions(
    locate=LocateOptions(
        spread_y=(1.0,),
        spread_z=(1.0,),
        turns_deg=(0.0,),
        fluctuations=((0.0, 0.4),),
        smallest_g_s=0.05,
    )
)
AIR = MeanAir(
    towards_mps=(SPEED_MPS, 0.0),
    travel=similarity_travel(LAYER, 1.0),
    reference_mps=SPEED_MPS,
    release_height_m=1.0,
)
SECOND = 1_000_000_000
DILUTION = 0.5


def gas(number: int, place: tuple[float, float, float], ppm: float, **changed):
    """Return the reading of a second at a place, east, north and up."""
    position = FRAME.position_of(np.array(place))
    values = {
        'vehicle': 'rav1',
        'time_ns': number * SECOND,
        'sensor': 'pid_10_6_ev',
        'unit': 'ppm',
        'calibration_gas': 'isobutylene',
        'latitude_deg': position.latitude_deg,
        'longitude_deg': position.longitude_deg,
        'altitude_m': position.altitude_m,
        'raw': ppm,
        'corrected': ppm,
        'std': 0.02,
        'limit': 0.1,
        'is_saturated': False,
    }
    return GasFlightReading(**values | changed)


def wind(number: int):
    """Return the wind of a second."""
    return WindFlightReading(
        vehicle='rav1',
        time_ns=number * SECOND,
        altitude_m=ORIGIN.altitude_m + 10.0,
        towards_east_mps=SPEED_MPS,
        towards_north_mps=0.0,
    )


def flown(rate_g_s: float = 5.0, seed: int = 3) -> GasLog:
    """Return the readings of a lawn mower 3 m above the ground, 4 s at each place."""
    log = GasLog(FRAME, Sampling(dilution=DILUTION))
    release = Release(place_m=(-22.0, 13.0), height_m=1.0, rate_g_s=max(rate_g_s, 1e-9))
    plume = SteadyPlume(release=release, travel=AIR.travel, wind=EASTWARDS)
    generator = np.random.default_rng(seed)
    chemical = agent('isobutylene')
    number = 0
    for east in np.arange(-45.0, 46.0, 10.0):
        for north in np.arange(-45.0, 46.0, 10.0):
            place = (float(east), float(north), 3.0)
            mean = chemical.ppm(float(plume.concentrations_g_m3(np.array([place]))[0]))
            for _ in range(4):
                number += 1
                read = DILUTION * mean * math.exp(0.2 * generator.standard_normal())
                log.add_gas(gas(number, place, read + 0.02 * generator.standard_normal()))
                log.add_wind(wind(number))
    return log


@pytest.fixture(scope='module')
def assessment():
    """Return what the readings of a release say."""
    return assess(flown().survey(), QUICK)


def test_a_flight_finds_the_release(assessment):
    """Its place within 10 m, its rate within a factor of 2; rotors' dilution is made good."""
    (release,) = assessment.found.releases
    assert math.dist(release.place_m, (-22.0, 13.0)) < 10.0
    assert 0.5 < release.rate_g_s / 5.0 < 2.0
    assert assessment.flight.anemometer_m == pytest.approx(10.0, abs=0.01)
    assert '1 release, placed within' in assessment.verdict.reason


def test_its_plume_and_zones_lie_downwind(assessment):
    """And the gas comes later farther away."""
    plume = assessment.plume
    east = plume.grid.east_m()
    row = int(np.abs(plume.grid.north_m() - 13.0).argmin())
    assert plume.mean_g_m3[row, east > 20.0].max() > 0.0
    assert plume.mean_g_m3[row, east < -60.0].max(initial=0.0) == 0.0
    times = plume.arrival_s[row, east > 20.0]
    assert (np.diff(times) > 0.0).all()
    assert (plume.upper_g_m3 >= plume.mean_g_m3).all()


def test_clean_air_says_where_a_release_may_hide():
    """Downwind of all readings it may; enough only if that is little of the ground."""
    found = assess(flown(0.0).survey(), QUICK)
    assert found.found.releases == ()
    assert found.plume is None
    hidden = found.found.hidden
    assert 0.0 < hidden.share < 1.0
    east = hidden.places_m[:, 0]
    assert hidden.ratios[east < -20.0].mean() < hidden.ratios[east > 50.0].mean()
    assert 'g/s may be in' in found.verdict.reason


def test_suggested_places_lie_where_the_release_could_blow(assessment):
    """Different ones, at the height flown, and within the area if one is given."""
    import shapely

    places = suggested_places(assessment, 5)
    assert len({place.place_m for place in places}) == 5
    assert all(place.place_m[2] == 3.0 for place in places)
    assert all(one.gain >= 0.0 for one in places)
    area = shapely.box(-10.0, -10.0, 30.0, 30.0)
    inside = suggested_places(assessment, 5, area)
    assert all(area.covers(shapely.Point(place.place_m[:2])) for place in inside)


def test_places_between_two_hypotheses_tell_them_apart():
    """Not where both say the same: the first place sees one plume and not the other."""
    samples = ReleaseSamples(
        places_m=np.array([[0.0, -20.0], [0.0, 20.0]]),
        rates_g_s=np.array([1.0, 1.0]),
        shapes=(PlumeShape(), PlumeShape()),
    )
    candidates = np.array([[30.0, 0.0, 1.5], [30.0, 20.0, 1.5], [-30.0, 0.0, 1.5]])
    first = measuring_places([samples], candidates, AIR, 1e-5, 3)
    assert first[0].place_m[:2] == (30.0, 20.0)
    # The second reading has less to say, and upwind there is nothing to learn.
    assert all(one.gain < first[0].gain for one in first[1:])
    values = predicted(samples, candidates, AIR)
    assert values[1, 1] > 1e-3
    assert values[0, 1] < 1e-3 * values[1, 1]


def test_spool_gives_back_all_readings(tmp_path):
    """Bit by bit."""
    spool = GasSpool(str(tmp_path))
    one, two = gas(1, (1.0, 2.0, 3.0), 0.123456789), wind(1)
    spool.keep_gas(one)
    spool.keep_wind(two)
    log = GasLog(FRAME, Sampling())
    GasSpool(str(tmp_path)).restore(log)
    assert len(log) == 1
    assert not log.add_gas(one)
    assert not log.add_wind(two)


@pytest.mark.parametrize(
    ('log', 'named'),
    [
        ([], 'wind'),
        ([wind(1)], 'ppm'),
        ([wind(1), gas(1, (0.0, 0.0, 3.0), 1.0, unit='mg_m3')], 'ppm'),
        ([wind(1), gas(1, (0.0, 0.0, 3.0), math.nan)], 'ppm'),
    ],
)
def test_no_survey_says_what_is_missing(log, named):
    """In a word that a responder knows."""
    found = GasLog(FRAME, Sampling())
    for one in log:
        add = found.add_gas if isinstance(one, GasFlightReading) else found.add_wind
        add(one)
    with pytest.raises(NoSurveyError, match=named):
        found.survey()


def test_few_readings_and_calm_are_refused():
    """Nothing is said from nothing."""
    log = GasLog(FRAME, Sampling())
    log.add_wind(wind(1))
    log.add_gas(gas(1, (0.0, 0.0, 3.0), 1.0))
    with pytest.raises(NoSurveyError, match='too few'):
        assess(log.survey(), QUICK)


def test_a_sensor_blind_to_the_agent_is_not_used():
    """Chlorine: the lamp does not see it, its reading of zero says nothing."""
    log = GasLog(FRAME, Sampling(agent='chlorine'))
    log.add_wind(wind(1))
    log.add_gas(gas(1, (0.0, 0.0, 3.0), 0.0))
    with pytest.raises(NoSurveyError, match='could see the agent'):
        log.survey()
