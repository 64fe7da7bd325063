# SPDX-License-Identifier: Apache-2.0
"""Over ground that is not level sources lie on it, and so do maps and background."""

import dataclasses
import json
import math

import numpy as np
import pytest
import yaml
from test.planner.terrains import CENTRE, write_terrain

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.solids.ground_heights import read_heights, shift_to_m
from rocsafe_radiation.belief.belief_search import believe
from rocsafe_radiation.command_line.localize_command import main
from rocsafe_radiation.decision.waypoint_choice import candidate_places
from rocsafe_radiation.field_parameters.field_making import survey_field
from rocsafe_radiation.field_parameters.field_options import FieldOptions
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.likelihood import Likelihood
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.physics.background import Background
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.products.dose_map import dose_map
from rocsafe_radiation.readings.ground import LEVEL, Ground, GroundError, ground_over
from rocsafe_radiation.readings.reading_log import FlightReading, ReadingLog
from rocsafe_radiation.readings.survey import RadiationSurvey

from .simulated_survey import HEIGHT_M, LOSSLESS

pytestmark = pytest.mark.slow

RISE = 0.25
ORIGIN = GeoPosition(CENTRE.latitude_deg, CENTRE.longitude_deg, 66.0)
SOURCE = (210.0, 90.0, 9250.0)


def slope(rise=RISE):
    """Return ground that rises to the east, 0 at the origin."""
    east = np.arange(-400.0, 701.0, 10.0)
    ups = np.tile(rise * east, (111, 1))
    return Ground(corner_m=(-400.0, -400.0), cell_m=10.0, ups_m=ups)


def level_flight(ground=LEVEL, seed=0, rise=RISE):
    """Return readings of a level flight, 100 m above the origin, over a source on a slope."""
    generator = np.random.default_rng(seed)
    axis = np.arange(0.0, 300.1, 30.0)
    east, north = (part.ravel() for part in np.meshgrid(axis, axis))
    places = np.stack([east, north, np.full(east.size, 100.0)], axis=1)
    x, y, strength = SOURCE
    squares = ((places - [x, y, rise * x + 0.5]) ** 2).sum(axis=1)
    rates = 0.1 + strength / squares
    return RadiationSurvey(
        positions_enu_m=places,
        counts=generator.poisson(550.0 * rates).astype(float),
        exposures=np.full(east.size, 550.0),
        ground=ground,
    )


def test_a_source_on_a_slope_is_found_on_it():
    """It is where it is, within its own ellipse, and as strong as it is."""
    options = LocalizationOptions(kernel=Kernel(is_lossy=False))
    (source,) = localize(level_flight(slope()), options).sources
    way = source.position_enu_m - [SOURCE[0], SOURCE[1], RISE * SOURCE[0] + 0.5]
    assert way[:2] @ np.linalg.solve(source.covariance_m2[:2, :2], way[:2]) < 25.0
    assert abs(way[2]) < 3.0
    assert source.dose_rate_at_1m_usvh == pytest.approx(SOURCE[2], rel=0.1)


@pytest.mark.parametrize(('ground', 'is_biased'), [(slope(), False), (LEVEL, True)])
def test_a_slope_taken_for_level_biases_the_strength(ground, is_biased):
    """The source lies 52 m higher than level ground: by half too strong, far above its ground."""
    survey = level_flight(ground)
    setting = Setting(kernel=Kernel(is_lossy=False), source_up_m=0.5, source_up_std_m=1.0)
    likelihood = Likelihood(survey, setting, np.empty((survey.size, 0)))
    fit = likelihood.fit(np.array([-2.3, 0.7, 0.0, 0.0, *SOURCE[:2], 0.5, math.log(SOURCE[2])]))
    height, strength = fit.parameters[-2], math.exp(fit.parameters[-1]) / SOURCE[2]
    assert bool(strength > 1.3) is is_biased
    assert bool(abs(height) > 4.0) is is_biased
    assert (
        bool(likelihood.misfit(fit.parameters, are_spikes_left_out=False)[0] > 10.0) is is_biased
    )


def test_an_uncertain_place_on_a_slope_is_uncertain_in_height():
    """The deviation of up is that of the height and of the way up the slope."""
    found = localize(level_flight(slope()), LOSSLESS)
    covariance = found.sources[0].joint_covariance
    assert covariance[2, 2] == pytest.approx(RISE**2 * covariance[0, 0], rel=0.01)
    assert covariance[2, 0] == pytest.approx(RISE * covariance[0, 0], rel=0.01)


def test_slopes_of_the_likelihood_follow_the_ground():
    """The gradient is that of differences."""
    ground = slope()
    survey = level_flight(ground)
    likelihood = Likelihood(survey, Setting(source_up_std_m=1.0), np.empty((survey.size, 0)))
    start = np.array([-2.3, 0.7, 0.1, -0.1, 203.0, 83.0, 0.3, 9.0])
    weights = np.ones(survey.size)
    _, gradient = likelihood.information_and_gradient(start, weights)
    for index in range(len(start)):
        step = np.zeros(len(start))
        step[index] = 1e-5
        after, before = start + step, start - step
        rise = likelihood.objective(after, weights) - likelihood.objective(before, weights)
        assert rise / 2e-5 == pytest.approx(gradient[index], rel=1e-4, abs=1e-3)


def test_the_map_is_one_metre_above_the_ground():
    """Beside a source on the slope, the dose rate is that at its own distance."""
    survey = level_flight(slope())
    found = localize(survey, LOSSLESS)
    drawn = dose_map(found, survey, LOSSLESS.kernel, 2.5, largest_cells=10_000)
    (source,) = found.sources
    rows, columns = drawn.mean_usvh.shape
    for row, column in ((rows // 2, columns // 2), (rows // 3, columns // 5)):
        east = drawn.corner_m[0] + column * drawn.cell_m
        north = drawn.corner_m[1] + row * drawn.cell_m
        way = np.array([east, north, RISE * east + 1.0]) - source.position_enu_m
        expected = source.dose_rate_at_1m_usvh / float(way @ way) + found.background_usvh
        assert drawn.mean_usvh[row, column] == pytest.approx(expected, rel=0.02)


def test_the_next_places_keep_their_height_above_the_ground():
    """A level flight over a slope is followed by one along it."""
    places = candidate_places(level_flight(slope()), 0.0)
    heights = places[:, 2] - RISE * places[:, 0]
    assert np.ptp(heights) < 1e-9
    assert heights[0] == pytest.approx(100.0 - RISE * 150.0, abs=1.0)


def test_the_belief_grid_puts_sources_on_the_ground():
    """The place of a patch is as high as its ground."""
    survey = level_flight(slope())
    found, _ = believe(survey, LOSSLESS)
    assert found.sources
    for source in found.sources:
        assert source.position_enu_m[2] == pytest.approx(RISE * source.position_enu_m[0])


def test_background_falls_with_the_height_above_the_ground():
    """Not with the altitude: over a hill at the same altitude it is stronger."""

    class Hill:
        def altitudes_m(self, latitudes, _longitudes):
            return np.where(np.asarray(latitudes) > 53.28, 130.0, np.nan)

    flat = Background(terrestrial_usvh=0.06, ground_altitude_m=66.0)
    hilly = dataclasses.replace(flat, ground=Hill())
    places = np.array([53.281, 53.279]), np.array([-9.06, -9.06]), np.array([150.0, 150.0])
    over_hill, beside = hilly.dose_rates_usvh(*places)
    assert over_hill == pytest.approx(0.06 * math.exp(-20.0 / 120.0))
    assert beside == pytest.approx(flat.dose_rates_usvh(*places)[1])


def test_ground_between_nodes_is_linear_and_level_beyond_its_rim():
    """Heights and slopes, and where nothing is known, those of the nearest."""
    ground = Ground(corner_m=(10.0, 20.0), cell_m=2.0, ups_m=np.array([[0.0, 4.0], [2.0, 6.0]]))
    places = np.array([[11.0, 21.0], [12.0, 22.0], [0.0, 0.0], [99.0, 20.5]])
    assert ground.ups_at(places) == pytest.approx([3.0, 6.0, 0.0, 4.5])
    assert ground.slopes_at(places[:1])[0] == pytest.approx([2.0, 1.0])
    assert ground.slopes_at(places[2:3])[0] == pytest.approx([0.0, 0.0])
    assert not ground.is_level
    assert LEVEL.is_level


@pytest.mark.parametrize(
    ('change', 'message'),
    [
        ({'ups_m': np.array([[math.nan]])}, 'ups_m must be'),
        ({'ups_m': np.zeros((1, 1)), 'cell_m': 0.0}, 'cell_m = 0.0 must be above 0'),
    ],
)
def test_a_ground_without_heights_is_refused(change, message):
    """With the name of what is wrong."""
    with pytest.raises(ValueError, match=message):
        Ground(**change)


@pytest.fixture
def file(tmp_path):
    """Return a GeoTIFF that rises 0.25 m a metre to the east, by 1000 m of another datum."""
    columns = np.arange(-100, 100) + 0.5
    wide = math.cos(math.radians(CENTRE.latitude_deg))
    heights = np.tile(1000.0 + RISE * 10.0 * wide * columns, (200, 1))
    return str(write_terrain(tmp_path / 'dem.tif', heights.astype('float32')))


def shifted(file, known=(ORIGIN,)):
    """Return the heights of a file, shifted to agree with places of known altitude."""
    return read_heights(file, shift_to_m(read_heights(file), known))


def test_a_file_is_shifted_to_known_ground(file):
    """In the frame of the mission, with gaps filled from beside."""
    heights = shifted(file)
    places = np.array([[0.0, 0.0], [200.0, 50.0]])
    ground = ground_over(heights, LocalFrame(ORIGIN), places)
    assert ground.ups_at(places) == pytest.approx([0.0, 50.0], abs=0.3)
    assert ground.slopes_at(places)[1] == pytest.approx([RISE, 0.0], abs=0.01)
    assert ground.reaches(places)
    assert not ground.reaches(np.array([[290.0, 0.0]]))


def test_ground_beyond_the_file_is_level_and_that_nowhere_is_refused(file):
    """A place outside of the raster has the height of its rim; far away there is none."""
    heights = shifted(file)
    rim = ground_over(heights, LocalFrame(ORIGIN), np.array([[580.0, 0.0], [640.0, 0.0]]))
    assert rim.ups_at(np.array([[740.0, 0.0]]))[0] == pytest.approx(150.0, abs=2.0)
    with pytest.raises(GroundError, match='the terrain has no height about'):
        ground_over(heights, LocalFrame(ORIGIN), np.array([[9000.0, 0.0]]))


@pytest.mark.parametrize(
    ('name', 'known', 'message'),
    [
        ('/none.tif', (), 'terrain /none.tif: no such file'),
        ('/none.npz', (), 'solids /none.npz: no such file'),
        ('', (GeoPosition(10.0, 0.0, 0.0),), 'has no height at 10.000000, 0.000000'),
    ],
)
def test_a_wrong_terrain_is_refused_in_one_line(file, name, known, message):
    """With what is wrong."""
    with pytest.raises(ValueError, match=message) as caught:
        shifted(name or file, known)
    assert '\n' not in str(caught.value)


def test_the_field_lifts_its_sources_to_the_ground(file, tmp_path):
    """Given 1 m above level ground, a source is 1 m above the real one; so are boxes."""
    place = offset(ORIGIN, 200.0, 0.0)
    spot = [place.latitude_deg, place.longitude_deg]
    box = {'length_m': 4.0, 'width_m': 4.0, 'height_m': 2.0}
    content = {
        'sources': [{'name': 'wreck', 'position': spot, 'height_m': 1.0, 'sigma_usvps': 2.57}],
        'shields': [{'material': 'lead', 'position': spot, 'base_height_m': 3.0, **box}],
        'ground_altitude_m': 66.0,
        'terrain_file': file,
        'terrain_shift_m': shift_to_m(read_heights(file), (ORIGIN,)),
        'background': {'dose_rate_usvh': 0.06},
    }
    settings = tmp_path / 'field.yaml'
    settings.write_text(yaml.safe_dump(content))
    survey = survey_field(FieldOptions(field_file=str(settings), model='shielded'))
    (source,) = survey.field.sources
    assert source.position.altitude_m == pytest.approx(67.0 + 50.0, abs=0.3)
    assert survey.field.shielding.frame.origin.altitude_m == pytest.approx(69.0 + 50.0, abs=0.3)
    ground = survey.background.ground.altitudes_m([place.latitude_deg], [place.longitude_deg])
    assert ground[0] == pytest.approx(66.0 + 50.0, abs=0.3)


def test_readings_of_a_flight_are_over_the_ground(file):
    """The log of the localizer attaches the ground around all readings so far."""
    log = ReadingLog(ORIGIN, heights=shifted(file))
    for number, east in enumerate((0.0, 100.0, 280.0)):
        place = offset(ORIGIN, east, 0.0, RISE * east + HEIGHT_M)
        log.add(
            FlightReading(
                vehicle='rav1', time_ns=number, latitude_deg=place.latitude_deg,
                longitude_deg=place.longitude_deg, altitude_m=place.altitude_m, dose_rate_usvh=0.1,
            )
        )  # fmt: skip
        assert log.survey().heights_m == pytest.approx(HEIGHT_M, abs=0.3)


def lines(readings):
    """Return a file of readings in degrees."""
    places = LocalFrame(ORIGIN).to_geodetic(readings.positions_enu_m)
    rates = readings.counts / readings.exposures
    rows = zip(places.tolist(), rates.tolist(), strict=True)
    head = 'latitude_deg,longitude_deg,altitude_m,dose_rate_usvh\n'
    return head + ''.join(f'{lat!r},{lon!r},{alt!r},{rate!r}\n' for (lat, lon, alt), rate in rows)


def test_localize_takes_a_terrain(file, tmp_path, capsys, monkeypatch):
    """`localize --terrain` puts the source on the slope."""
    monkeypatch.setattr('rocsafe_radiation.command_line.localize_command.LARGEST_CELLS', 2000)
    table = tmp_path / 'readings.csv'
    table.write_text(lines(level_flight()))
    at = [f'{value:.9f}' for value in (ORIGIN.latitude_deg, ORIGIN.longitude_deg, 66.0)]
    arguments = [str(table), '--model=paper', '--json', f'--terrain={file}', '--terrain-at', *at]
    assert main(arguments) == 0
    (source,) = json.loads(capsys.readouterr().out)['sources']
    place = source['place']
    found = GeoPosition(place['latitude_deg'], place['longitude_deg'], place['altitude_m'])
    east, north, up = LocalFrame(ORIGIN).enu_of(found)
    assert math.hypot(east - SOURCE[0], north - SOURCE[1]) < 3.0
    assert up == pytest.approx(RISE * SOURCE[0] + 0.5, abs=3.0)


@pytest.mark.parametrize(
    ('head', 'arguments', 'message'),
    [
        ('', [], 'm below the ground: must be above; give --ground'),
        ('east_m,north_m,up_m', [], '--terrain needs places in degrees'),
        ('', ['--terrain-at', '53.28', '-9.0633'], 'expected 3 arguments'),
        ('', ['--terrain=/none.tif'], 'terrain /none.tif: no such file'),
    ],
)
def test_localize_refuses_a_terrain_that_does_not_fit(
    head, arguments, message, file, tmp_path, capsys
):
    """Of another datum, for a file in metres, half a place, no file: one line each."""
    table, text = tmp_path / 'readings.csv', lines(level_flight())
    table.write_text(text.replace('latitude_deg,longitude_deg,altitude_m', head) if head else text)
    try:
        code = main([str(table), '--model=paper', f'--terrain={file}', *arguments])
    except SystemExit as error:
        code = error.code
    assert code == 2
    assert message in capsys.readouterr().err.strip().splitlines()[-1]
