# SPDX-License-Identifier: Apache-2.0
"""Readings of a flight: the survey that they make, what it says, where to measure next."""

import json
import math
from dataclasses import replace
from xml.etree import ElementTree

import numpy as np
import pytest
import rasterio
import yaml

from rocsafe_dispersion.agents.agent_table import agent
from rocsafe_dispersion.command_line import locate_command
from rocsafe_dispersion.estimation.amount import PARTICLES
from rocsafe_dispersion.estimation.fluctuating_plume import Shapes
from rocsafe_dispersion.estimation.found_release import ReleaseSamples
from rocsafe_dispersion.estimation.measuring_places import MeanAir, measuring_places, predicted
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_dispersion.mission_gas.gas_figure import gas_figure
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
    in_wind,
    suggested_places,
)
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.scale_bar import bar_length_m

from .airs import EASTWARDS, LAYER, SPEED_MPS

ORIGIN = GeoPosition(53.28, -9.06, 60.0)
FRAME = LocalFrame(ORIGIN)
QUICK = AssessmentOptions(locate=LocateOptions(most_releases=1, smallest_g_s=0.05, particles=300))
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


def flight_readings(
    rate_g_s: float = 5.0, seed: int = 3, step_m: float = 10.0
) -> list[GasFlightReading]:
    """Return the readings of a lawn mower 3 m above the ground, 4 s at each place."""
    release = Release(place_m=(-22.0, 13.0), height_m=1.0, rate_g_s=max(rate_g_s, 1e-9))
    plume = SteadyPlume(release=release, travel=AIR.travel, wind=EASTWARDS)
    generator = np.random.default_rng(seed)
    chemical = agent('isobutylene')
    found = []
    for east in np.arange(-45.0, 46.0, step_m):
        for north in np.arange(-45.0, 46.0, step_m):
            place = (float(east), float(north), 3.0)
            mean = chemical.ppm(float(plume.concentrations_g_m3(np.array([place]))[0]))
            for _ in range(4):
                read = DILUTION * mean * math.exp(0.2 * generator.standard_normal())
                noise = 0.02 * generator.standard_normal()
                found.append(gas(len(found) + 1, place, read + noise))
    return found


def flown(rate_g_s: float = 5.0) -> GasLog:
    """Return the log of these readings, with the wind of each second."""
    log = GasLog(FRAME, Sampling(dilution=DILUTION))
    for number, reading in enumerate(flight_readings(rate_g_s), 1):
        log.add_gas(reading)
        log.add_wind(wind(number))
    return log


@pytest.fixture(scope='module')
def assessment():
    """Return what the readings of a release say."""
    return assess(flown().survey(), QUICK)


@pytest.mark.slow
def test_a_flight_finds_the_release(assessment):
    """Its place within 10 m, its rate within a factor of 2; rotors' dilution is made good."""
    (release,) = assessment.found.releases
    assert math.dist(release.place_m, (-22.0, 13.0)) < 10.0
    assert 0.5 < release.rate_g_s / 5.0 < 2.0
    assert assessment.flight.anemometer_m == pytest.approx(10.0, abs=0.01)
    assert '1 release, placed within' in assessment.verdict.reason


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_long_verdict_is_told_whole_in_the_figure(assessment):
    """In lines that its width holds, above the key and the map."""
    reason = ', '.join(f'reason {number} of many' for number in range(20))
    verdict = replace(assessment.verdict, reason=reason)
    figure = ElementTree.fromstring(gas_figure(replace(assessment, verdict=verdict)))  # noqa: S314
    lines = [one for one in figure if one.tag.endswith('}text')]
    assert ' '.join(line.text for line in lines) == f'{assessment.flight.agent.name}: {reason}'
    assert max(len(line.text) for line in lines) <= 60
    (group,) = (one for one in figure if one.tag.endswith('}g'))
    (inner,) = (one for one in figure if one.tag.endswith('}svg'))
    (wind,) = (one for one in group if (one.text or '').startswith('wind '))
    moved = float(group.get('transform').removeprefix('translate(0 ').removesuffix(')'))
    assert float(lines[-1].get('y')) + 13.0 < moved + float(wind.get('y')) < float(inner.get('y'))


@pytest.mark.slow
def test_its_plume_and_zones_are_told_in_another_wind(assessment):
    """Where it goes to now: to the north instead of the east."""
    wind_mps = (0.0, SPEED_MPS)
    assert assessment.is_of_wind(assessment.flight.wind_towards_mps)
    assert not assessment.is_of_wind(wind_mps)
    turned = in_wind(assessment, wind_mps)
    assert turned.is_of_wind(wind_mps)
    for one, is_north in ((assessment, False), (turned, True)):
        grid, mean = one.plume.grid, one.plume.mean_g_m3
        middle = mean.ravel() @ grid.places_m()[:, :2] / mean.sum()
        along, across = (middle - (-22.0, 13.0))[:: -1 if is_north else 1]
        assert along > 30.0
        assert abs(across) < 20.0
    assert turned.found is assessment.found
    # In a calm no plume can be told.
    assert assessment.is_of_wind((0.0, 0.1))


def test_the_wind_told_is_that_of_the_last_ten_minutes():
    """Of a wind that has turned, not the mean of both."""
    log = GasLog(FRAME, Sampling())
    for number in range(100):
        log.add_wind(wind(number))
    log.add_wind(replace(wind(1000), towards_east_mps=0.0, towards_north_mps=2.0))
    assert log.recent_wind() == (0.0, 2.0)


@pytest.mark.slow
def test_clean_air_says_where_a_release_may_hide():
    """Downwind of all readings it may; enough only if that is little of the ground."""
    found = assess(flown(0.0).survey(), QUICK)
    assert found.found.releases == ()
    assert found.plume is None
    hidden = found.found.hidden
    assert 0.0 < hidden.share < 1.0
    east = hidden.places_m[:, 0]
    counted = np.minimum(hidden.ratios, 1.0)
    assert counted[east < -20.0].mean() < counted[east > 50.0].mean()
    assert 'g/s may be in' in found.verdict.reason


@pytest.mark.slow
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


@pytest.mark.slow
def test_a_release_beyond_the_ground_is_looked_for_there():
    """It is 17 m west of the ground searched, which is that of the readings and 20 m more."""
    log = GasLog(FRAME, Sampling(dilution=DILUTION))
    for number, reading in enumerate(flight_readings(), 1):
        if FRAME.enu_of(
            GeoPosition(reading.latitude_deg, reading.longitude_deg, reading.altitude_m)
        )[0] >= 14.0:  # fmt: skip
            log.add_gas(reading)
            log.add_wind(wind(number))
    found = assess(log.survey(), QUICK)
    (release,) = found.found.releases
    assert release.holds(-22.0, 13.0)
    assert found.area.west_m < -22.0
    assert not found.verdict.is_enough
    assert 'to the W: measure there' in found.verdict.reason
    places = np.array([place.place_m for place in suggested_places(found, 3)])
    assert (places[:, 0] < 5.0).all()


@pytest.mark.slow
def test_a_placed_release_leaves_the_question_of_another(assessment):
    """It may be where no reading was; it is asked, and looked for, once the first is placed."""
    found = assessment.found
    hidden = found.hidden
    assert 0.0 < hidden.share < 1.0
    east = hidden.places_m[:, 0]
    counted = np.minimum(hidden.ratios, 1.0)
    assert counted[east < -20.0].mean() < counted[east > 50.0].mean()
    loose = ReleaseRule(region_m=1000.0, hidden_share=0.9)
    assert loose.verdict(found).is_enough
    strict = replace(loose, hidden_share=0.001)
    verdict = strict.verdict(found)
    assert not verdict.is_enough
    assert 'another of' in verdict.reason
    far = [suggested_places(replace(assessment, rule=rule), 5) for rule in
           (ReleaseRule(region_m=0.1), strict)]  # fmt: skip
    assert {each.place_m for each in far[0]} != {each.place_m for each in far[1]}


def test_places_between_two_hypotheses_tell_them_apart():
    """Not where both say the same: the first place sees one plume and not the other."""
    samples = ReleaseSamples(
        places_m=np.array([[0.0, -20.0], [0.0, 20.0]]),
        rates_g_s=np.array([1.0, 1.0]),
        shapes=Shapes(
            turn_rad=np.zeros(2),
            spread_y=np.ones(2),
            spread_z=np.ones(2),
            meander=np.zeros(2),
            relative=np.full(2, 0.4),
        ),
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


def counts(step_m: float = 15.0) -> list[GasFlightReading]:
    """Return counts of particles of the same flight, a gram of gas taken for 1e9 particles."""
    per_ppm = 1e9 * agent('isobutylene').g_m3(1.0)
    return [
        replace(
            one, sensor='particle_counter', unit='per_m3', calibration_gas='particles', std=1e4,
            corrected=1e5 + per_ppm * one.corrected, raw=1e5 + per_ppm * one.raw,
        )
        for one in flight_readings(step_m=step_m)
    ]  # fmt: skip


@pytest.mark.parametrize(
    ('named', 'sensor'),
    [('', 'particle_counter'), ('particles', 'particle_counter'), ('isobutylene', 'pid_10_6_ev')],
)
def test_particles_are_counted_beside_gas(named, sensor):
    """What is asked for decides; else what is seen most clearly."""
    log = GasLog(FRAME, Sampling(dilution=DILUTION, agent=named))
    for number, reading in enumerate(counts(), 1):
        log.add_gas(reading)
        log.add_gas(gas(number, (float(number), 0.0, 3.0), 0.01 * (number % 3)))
        log.add_wind(wind(number))
    flight = log.survey()
    assert flight.sensor == sensor
    assert flight.survey.amount.is_particles == (sensor == 'particle_counter')


@pytest.mark.slow
def test_an_open_path_is_a_mean_down_to_the_ground():
    """From 12 m, where a sensor beside the vehicle would meet little of the plume."""
    release = Release(place_m=(-22.0, 13.0), height_m=1.0, rate_g_s=5.0)
    plume = SteadyPlume(release=release, travel=AIR.travel, wind=EASTWARDS)
    chemical, generator = agent('methane'), np.random.default_rng(3)
    heights = np.arange(0.05, 12.0, 0.1)
    log = GasLog(FRAME, Sampling(dilution=DILUTION, delay_s=3.0))
    numbers = iter(range(1, 10_000))
    for east in np.arange(-45.0, 46.0, 10.0):
        for north in np.arange(-45.0, 46.0, 10.0):
            column = np.column_stack([np.full((120, 2), (east, north)), heights])
            below = chemical.ppm(float(plume.concentrations_g_m3(column).sum()) * 0.1)
            for _ in range(4):
                number = next(numbers)
                read = below * math.exp(0.2 * generator.standard_normal())
                read += 2.0 * generator.standard_normal()
                place = (float(east), float(north), 12.0)
                log.add_wind(wind(number))
                log.add_gas(gas(number, place, read, sensor='open_path_methane', unit='ppm_m',
                                calibration_gas='methane', std=2.0))  # fmt: skip
    flight = log.survey()
    assert flight.flight_height_m == pytest.approx(12.0, abs=0.1)
    assert flight.survey.weights.sum() == pytest.approx(1.0)
    found = assess(flight, QUICK).found
    (one,) = found.releases
    assert one.holds(-22.0, 13.0)
    assert math.dist(one.place_m, (-22.0, 13.0)) < 12.0
    assert one.rate_low_g_s < 5.0 < one.rate_high_g_s
    # What is read beside the vehicle, or diluted, is another rate.
    assert 0.5 < one.rate_g_s / 5.0 < 2.0


@pytest.mark.slow
def test_files_of_particles_name_their_units(tmp_path):
    """Rates in particles a second, the map in particles a litre; no levels are known."""
    changed = {'agent': 'particles', 'settling_mps': 0.001, 'smallest_per_s': 1e7}
    file = written(tmp_path, counts(), changed=changed)
    assert locate_command.main([file, f'--out={tmp_path / "out"}']) == 0
    document = json.loads((tmp_path / 'out' / 'release.json').read_text())
    (release,) = document['releases']
    place = FRAME.enu_of(
        GeoPosition(release['latitude_deg'], release['longitude_deg'], ORIGIN.altitude_m)
    )
    assert math.dist(place[:2], (-22.0, 13.0)) < 15.0
    assert release['rate_unit'] == document['another']['rate_unit'] == PARTICLES.rate_unit
    assert release['rate_95'][0] < 5e9 < release['rate_95'][1]
    assert document['another']['rate'] == 1e7
    assert document['agent'] == 'particles'
    assert document['highest_reading']['unit'] == 'particles/l'
    assert document['threat_zones'] == []
    with rasterio.open(tmp_path / 'out' / 'plume.tif') as raster:
        assert 'particles/l' in raster.descriptions[0]
        assert 10.0 < np.nanmax(raster.read(1)) < 1e6


def written(folder, readings, text: str = '', changed=None) -> str:
    """Keep readings as a node does, and return its parameter file."""
    spool = GasSpool(str(folder / 'spool'))
    for number, reading in enumerate(readings, 1):
        spool.keep_gas(reading)
        spool.keep_wind(wind(number))
    values = {
        'vehicles': ['rav1'],
        'origin_latitude_deg': ORIGIN.latitude_deg,
        'origin_longitude_deg': ORIGIN.longitude_deg,
        'origin_altitude_m': ORIGIN.altitude_m,
        'dilution': DILUTION,
        'spool_directory': str(folder / 'spool'),
        'agent': 'ammonia',
        **(changed or {}),
    }
    file = folder / 'estimator.yaml'
    file.write_text(text or yaml.safe_dump({'/estimator': {'ros__parameters': values}}))
    return str(file)


@pytest.fixture(scope='module')
def flight_file(tmp_path_factory):
    """Return the parameter file of an estimator with the readings of a short flight."""
    return written(tmp_path_factory.mktemp('flight'), flight_readings(step_m=15.0))


@pytest.fixture(scope='module')
def files(flight_file, tmp_path_factory):
    """Return the folder of the files of this flight."""
    out = tmp_path_factory.mktemp('files')
    assert locate_command.main([flight_file, f'--out={out}']) == 0
    return out


@pytest.mark.slow
def test_files_of_a_flight_are_written(files):
    """Releases, zones and plume in the formats that responders open."""
    document = json.loads((files / 'release.json').read_text())
    (release,) = document['releases']
    place = FRAME.enu_of(
        GeoPosition(release['latitude_deg'], release['longitude_deg'], ORIGIN.altitude_m)
    )
    assert math.dist(place[:2], (-22.0, 13.0)) < 15.0
    assert document['agent'] == 'ammonia'
    zones = json.loads((files / 'threat_zones.geojson').read_text())
    assert {one['properties']['level'] for one in zones['features']} == {
        'AEGL-1', 'AEGL-2', 'AEGL-3',
    }  # fmt: skip
    ElementTree.parse(files / 'threat_zones.kml')  # noqa: S314 - our own file
    figure = ElementTree.parse(files / 'gas.svg').getroot()  # noqa: S314 - our own file
    assert sum(one.tag.endswith('animate') for one in figure.iter()) == document['reading_count']
    texts = [one.text or '' for one in figure.iter() if one.tag.endswith('}text')]
    assert any(text.startswith('wind ') for text in texts)
    assert {'AEGL-1', 'AEGL-2', 'AEGL-3'} <= set(texts)
    with rasterio.open(files / 'plume.tif') as raster:
        mean, upper, arrival = raster.read()
    assert (upper >= mean).all()
    assert np.nanmin(arrival) >= 0.0


@pytest.mark.parametrize(
    ('most_m', 'length_m'), [(1.0, 1.0), (4.9, 2.0), (87.0, 50.0), (0.3, 0.2)]
)
def test_scale_bars_have_round_lengths(most_m: float, length_m: float):
    """And are as long as there is room for."""
    assert bar_length_m(most_m) == pytest.approx(length_m)


@pytest.mark.parametrize('text', ['[]', 'a: 1', '/estimator: {ros__parameters: {water: 1}}', '{'])
def test_what_is_no_parameter_file_is_refused_in_one_line(tmp_path, capsys, text):
    """Without a traceback."""
    assert locate_command.main([written(tmp_path, [], text)]) == 2
    error = capsys.readouterr().err
    assert 'is no parameter file of an estimator' in error


@pytest.mark.slow
def test_assumptions_of_the_command_line_replace_those_of_a_flight(
    flight_file, files, tmp_path, capsys
):
    """In class A the plume of class D is lower than told; --json prints the document."""
    arguments = [flight_file, f'--out={tmp_path}', '--stability=A', '--json']
    assert locate_command.main(arguments) == 0
    printed = json.loads(capsys.readouterr().out)
    documents = [json.loads((out / 'release.json').read_text()) for out in (files, tmp_path)]
    assert printed == documents[1]
    factors = [document['plume']['height_factor'] for document in documents]
    assert factors[1] < 0.8 * factors[0]


@pytest.mark.parametrize('option', ['--anemometer=5', '--margin=3', '--most=1'])
def test_assumptions_that_a_flight_does_not_need_are_refused(tmp_path, capsys, option):
    """Rather than ignored."""
    assert locate_command.main([written(tmp_path, []), option]) == 2
    assert f'{option.partition("=")[0]} is for a table of readings' in capsys.readouterr().err
