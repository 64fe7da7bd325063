# SPDX-License-Identifier: Apache-2.0
"""A drive on the products of a survey keeps to free ground and to its budgets."""

import functools
import itertools
import json
import math
import re
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
import rasterio
import shapely
from rasterio.transform import from_origin
from test.ground.villages import (
    DARK,
    FRAME,
    GRASS,
    RED,
    ROAD,
    SOIL,
    SOURCE_RATE_USVH,
    WATER,
    position,
    text,
    write_gas,
    write_labels,
    write_village,
)

from rocsafe_geo.evidence.evidence_log import LOG_NAME, Event, EvidenceLog
from rocsafe_geo.position import GeoPosition
from rocsafe_ground.command_line.ground_command import lines_of, main
from rocsafe_ground.drivable.drivable_ground import Reason
from rocsafe_ground.drivable.ground_classes import GroundClass, ground_classes
from rocsafe_ground.drivable.labels import read_labels
from rocsafe_ground.drivable.vehicle import GroundVehicle
from rocsafe_ground.drive.drive_plan import DriveRequest
from rocsafe_ground.drive.ground_map import MapFiles, read_ground_map
from rocsafe_ground.drive.planning import plan_drive
from rocsafe_ground.errors import BeyondBudgetError, NoMapError, NoWayError
from rocsafe_ground.evidence.evidence_point import EvidencePoint
from rocsafe_ground.evidence.found_releases import found_releases
from rocsafe_ground.evidence.labelled_things import labelled_things

CELL_M = 0.5
TURN_BACK = 1e5
# The village is symmetric about the source: a mark beyond it is reached on either side.
START, BEYOND = (-20.0, 7.0), (20.0, 9.0)


@pytest.fixture(scope='module')
def village(tmp_path_factory) -> Path:
    """Return the folder of a village."""
    return write_village(tmp_path_factory.mktemp('village'))


@pytest.fixture(scope='module')
def gassed(tmp_path_factory):
    """Return the map of a village with gas south of its source."""
    return ground_of(write_gas(write_village(tmp_path_factory.mktemp('gassed'))))


@functools.cache
def ground_of(folder, vehicle=None, turn_back=TURN_BACK):
    """Return the map of a folder as it is when it is first read."""
    return read_ground_map(MapFiles(folder=folder), vehicle or GroundVehicle(), CELL_M, turn_back)


def request_of(*places, start=START, budget=1e6, **options) -> DriveRequest:
    """Return a request to drive to marks without waiting there."""
    points = tuple(
        EvidencePoint(id=f'm{number}', position=position(*place), dwell_s=0.0)
        for number, place in enumerate(places, 1)
    )
    return DriveRequest(start=position(*start), evidence=points, dose_budget_usv=budget, **options)


@pytest.mark.parametrize(
    ('colour', 'kind'),
    [
        (GRASS, GroundClass.GRASS),
        (ROAD, GroundClass.ROAD),
        (SOIL, GroundClass.SOIL),
        (RED, GroundClass.OBJECT),
        (WATER, GroundClass.WATER),
        (DARK, GroundClass.DARK),
        ((30, 55, 20), GroundClass.VEGETATION),
        ((240, 240, 240), GroundClass.OBJECT),
    ],
)
def test_colours_tell_the_ground(colour, kind):
    """Of plain colours."""
    red, green, blue = (np.array([float(value)]) for value in colour)
    assert ground_classes(red, green, blue)[0] == kind


def test_unseen_ground_is_not_free_and_walls_grow_by_the_vehicle(village):
    """The margin is half the width and the distance asked for."""
    vehicle = GroundVehicle(width_m=2.0, margin_m=1.0)
    ground = ground_of(village, vehicle)

    def reason(east, north):
        return Reason(int(ground.reasons.ravel()[ground.grid.cell_of(east, north)]))

    assert reason(38.0, 0.0) is Reason.UNKNOWN
    assert reason(-10.0, 20.0) is Reason.OBSTACLE
    assert reason(-10.0, 21.9) is Reason.TOO_NEAR
    assert reason(-10.0, 23.0) is Reason.FREE
    assert reason(34.5, 0.0) is Reason.TOO_NEAR
    assert not ground.is_free[0].any()


@pytest.mark.slow
def test_route_stays_on_free_ground_and_its_figures_are_those_of_its_lines(village):
    """Whatever the budget."""
    ground = ground_of(village)
    blocked = shapely.box(-40.0, 19.5, 10.0, 20.5)
    plan = plan_drive(request_of((-20.0, 33.0)), ground)
    way = shapely.LineString([(stop.east_m, stop.north_m) for stop in plan.stops])
    assert way.distance(blocked) > 0.5 * GroundVehicle().width_m
    assert plan.length_m == pytest.approx(way.length, rel=1e-6)
    pairs = itertools.pairwise(plan.stops)
    times = [np.hypot(b.east_m - a.east_m, b.north_m - a.north_m) / b.speed_mps for a, b in pairs]
    # Braking, speeding up and turns in place come on top of the speeds.
    assert plan.time_s >= sum(times) - 1e-6
    assert sum(stop.duration_s for stop in plan.stops) == pytest.approx(plan.time_s, rel=1e-6)
    assert sum(stop.dose_usv for stop in plan.stops) == pytest.approx(plan.forecast.mean_usv)
    assert plan.stops[0].place == plan.stops[-1].place
    assert [stop.evidence for stop in plan.stops if stop.evidence] == ['m1']


@pytest.mark.slow
def test_stops_tell_how_the_dose_grows_along_lines(village):
    """A vehicle that passes a source knows what was predicted up to where it is."""
    plan = plan_drive(request_of((4.0, -38.0), start=(4.0, 18.0)), ground_of(village))
    east, north, seconds, rates = plan.track.T
    taken = np.concatenate([[0.0], np.cumsum(0.5 * (rates[1:] + rates[:-1]) * np.diff(seconds))])
    way = np.concatenate([[0.0], np.cumsum(np.hypot(np.diff(east), np.diff(north)))])
    stops = np.array([(stop.east_m, stop.north_m) for stop in plan.stops])
    stops_m = np.concatenate([[0.0], np.cumsum(np.hypot(*np.diff(stops, axis=0).T))])
    told = np.cumsum([stop.dose_usv for stop in plan.stops])
    assert np.interp(way, stops_m, told) == pytest.approx(taken / 3600.0, abs=0.05 * told[-1])
    assert len(plan.stops) > 8


@pytest.mark.slow
def test_tighter_budget_gives_less_dose_and_more_time(village):
    """And each forecast is within its budget."""
    ground = ground_of(village)
    free = plan_drive(request_of(BEYOND), ground)
    before = free
    for share in (0.6, 0.4):
        budget = share * free.forecast.mean_usv
        plan = plan_drive(request_of(BEYOND, budget=budget), ground)
        assert plan.forecast.probability >= 0.95
        assert plan.forecast.mean_usv < budget
        assert plan.time_s > before.time_s
        assert plan.grid_time_s >= plan.bound_s
        assert plan.price_s_per_usv > 0.0
        before = plan


@pytest.mark.slow
def test_dose_of_a_pass_is_that_of_the_closed_form(village):
    """The forecast's mean is that of the law 1 / r^2 along the track."""
    plan = plan_drive(request_of(BEYOND), ground_of(village))
    east, north, seconds = plan.track[:, :3].T
    rates = 0.1 + SOURCE_RATE_USVH / (east**2 + (north - 10.0) ** 2)
    assert plan.forecast.mean_usv == pytest.approx(
        float((0.5 * (rates[1:] + rates[:-1]) * np.diff(seconds)).sum()) / 3600.0, rel=0.01
    )


@pytest.mark.slow
def test_chance_counts_what_is_not_known_of_the_source(tmp_path):
    """A strength known to a factor of two takes a drive far from it; the same seed, the same."""
    vague = ground_of(write_village(tmp_path / 'vague', rate_std_usvh=35_000.0))
    sure = ground_of(write_village(tmp_path / 'sure', rate_std_usvh=100.0))
    request = request_of(BEYOND, budget=40.0)
    far, near = plan_drive(request, vague), plan_drive(request, sure)
    assert far.forecast.mean_usv < near.forecast.mean_usv < 40.0
    assert far.forecast.probability >= 0.95
    again = plan_drive(request, vague)
    assert again.forecast == far.forecast


def test_ground_where_a_source_may_be_is_a_wall(tmp_path):
    """Not only around the place where it was found."""
    walls = []
    for name, std_m in (('sure', 0.1), ('unsure', 1.0)):
        ground = ground_of(write_village(tmp_path / name, place_std_m=std_m))
        walls.append(int((ground.reasons == Reason.HOT).sum()) * CELL_M**2)
    assert walls[0] < 4.0
    assert 2.0 * walls[0] < walls[1] < 60.0


@pytest.mark.slow
def test_hot_ground_is_a_wall(village):
    """No sample of the track has the upper dose rate at which the vehicle turns back."""
    ground = ground_of(village, turn_back=300.0)
    plan = plan_drive(request_of(BEYOND), ground)
    cells = [ground.grid.cell_of(east, north) for east, north in plan.track[:, :2].tolist()]
    assert ground.field.upper_usvh.ravel()[cells].max() < 300.0
    assert plan.length_m > plan_drive(request_of(BEYOND), ground_of(village)).length_m


@pytest.mark.slow
def test_source_is_seen_from_where_the_dose_rate_is_low(village):
    """Within its reach, not on it."""
    ground = ground_of(village)
    mark = EvidencePoint(id='s', position=position(0.0, 10.0), kind='source', dwell_s=60.0)
    plan = plan_drive(replace(request_of(BEYOND), evidence=(mark,)), ground)
    (stand,) = (stop for stop in plan.stops if stop.evidence)
    assert 13.0 < np.hypot(stand.east_m, stand.north_m - 10.0) <= 15.0
    assert plan.time_s > 60.0


NEEDS = {
    'dose_budget_usv': r'a dose budget of ([0-9.e+]+) uSv',
    'load_budget': r'a load budget of ([0-9.e+]+)',
    'endurance_s': r'an endurance of ([0-9]+) s',
}


def raised(request: DriveRequest, text: str) -> DriveRequest:
    """Return a request with the budgets that a text names."""
    found = {name: re.search(pattern, text) for name, pattern in NEEDS.items()}
    values = {name: float(one.group(1)) for name, one in found.items() if one}
    assert values, text
    endurance = values.pop('endurance_s', request.vehicle.endurance_s)
    return replace(request, vehicle=replace(request.vehicle, endurance_s=endurance), **values)


@pytest.mark.slow
@pytest.mark.parametrize(
    ('dose', 'load', 'endurance'),
    [
        (20.0, math.inf, 7200.0),
        (1e6, 0.02, 7200.0),
        (1e6, math.inf, 80.0),
        pytest.param(20.0, 0.02, 80.0, marks=pytest.mark.all),
    ],
)
def test_budgets_that_are_named_admit_what_was_left_out(gassed, dose, load, endurance):
    """Of dose, toxic load and battery, for what is left out and for a drive that is refused."""
    request = request_of(
        (-30.0, -5.0), (1.0, 10.0), (0.0, -20.0), budget=dose, load_budget=load,
        vehicle=GroundVehicle(endurance_s=endurance), curve_points=0,
    )  # fmt: skip
    try:
        plan = plan_drive(request, gassed)
    except BeyondBudgetError as error:
        all_take = str(error).split('; all 3 take ')[1]
        assert not plan_drive(raised(request, all_take), gassed).left_out
        (first,) = re.findall(r': (m[0-9]) takes ([^;]*)', str(error).split(';')[0])
        alone = replace(
            request, evidence=tuple(one for one in request.evidence if one.id == first[0])
        )
        with pytest.raises(BeyondBudgetError):
            plan_drive(alone, gassed)
        assert not plan_drive(raised(alone, first[1]), gassed).left_out
        return
    taken = {stop.evidence for stop in plan.stops if stop.evidence}
    assert plan.time_s <= endurance
    assert plan.forecast.probability >= 0.95
    assert plan.gas.load_upper_share <= load
    for left in plan.left_out:
        more = replace(
            request,
            evidence=tuple(one for one in request.evidence if one.id in {*taken, left.evidence}),
        )
        assert not plan_drive(raised(more, left.why), gassed).left_out


@pytest.mark.slow
def test_load_budget_leads_around_the_gas(gassed):
    """With less of it the drive takes longer, and keeps it; the proof counts it."""
    free = plan_drive(request_of((20.0, -25.0), start=(-20.0, -20.0)), gassed)
    share = free.gas.load_upper_share
    request = request_of((20.0, -25.0), start=(-20.0, -20.0), load_budget=0.3 * share)
    plan = plan_drive(request, gassed)
    assert plan.gas.load_upper_share <= 0.3 * share
    assert plan.time_s > free.time_s
    assert free.time_s * 0.9 < plan.bound_s <= plan.grid_time_s
    assert plan.gap_fraction < 0.02


def test_load_that_is_not_known_cannot_be_limited(tmp_path):
    """The exponent of the gas is not published."""
    folder = write_gas(write_village(tmp_path), load_exponent=None)
    with pytest.raises(NoMapError, match='ammonia: its toxic load is not known'):
        plan_drive(request_of(BEYOND, load_budget=0.1), ground_of(folder))


@pytest.mark.slow
def test_what_does_not_fit_is_named_with_what_would_admit_it(village):
    """With that budget it is visited."""
    ground = ground_of(village)
    far, hot = (-30.0, -5.0), (1.0, 10.0)
    spare = 2.0 * plan_drive(request_of(far), ground).forecast.upper_usv
    plan = plan_drive(request_of(far, hot, budget=spare), ground)
    (left,) = plan.left_out
    assert left.evidence == 'm2'
    budget = float(left.why.split('dose budget of ')[1].split(' ')[0])
    assert not plan_drive(request_of(far, hot, budget=budget * 1.001), ground).left_out


@pytest.mark.slow
@pytest.mark.parametrize(
    ('changes', 'error', 'match'),
    [
        ({'start': (500.0, 0.0)}, NoMapError, 'beyond the map, by 460 m'),
        ({'start': (-10.0, 20.0), 'budget': 0.01}, BeyondBudgetError, 'm1 takes a dose budget'),
        ({'place': (39.0, 0.0)}, NoWayError, 'ground that was not seen'),
        ({'place': (900.0, 0.0)}, NoWayError, 'm1: it is beyond the map'),
        ({'budget': 0.01}, BeyondBudgetError, 'within 0.01 uSv and 7200 s: m1 takes a dose'),
        ({'vehicle': GroundVehicle(endurance_s=5.0)}, BeyondBudgetError, 'm1 takes an endurance'),
    ],
)
def test_request_without_a_route_says_why(village, changes, error, match):
    """In one line."""
    options = {'place': BEYOND, **changes}
    with pytest.raises(error, match=match):
        plan_drive(request_of(options.pop('place'), **options), ground_of(village))


def test_goal_inside_a_wall_is_refused(tmp_path):
    """A mark in the middle of a wide block of red."""
    folder = write_village(tmp_path)
    zone = {'type': 'Polygon', 'coordinates': [[[*lonlat(e, n)] for e, n in CORNERS]]}
    (folder / 'zone.geojson').write_text(json.dumps(zone))
    files = MapFiles(folder=folder, keep_outs=(folder / 'zone.geojson',))
    ground = read_ground_map(files, GroundVehicle(), CELL_M, TURN_BACK)
    with pytest.raises(NoWayError, match='m1: it is on a zone not to be entered') as caught:
        plan_drive(request_of((20.0, -20.0)), ground)
    # The nearest place that it names can be driven to.
    place = [float(word) for word in re.findall(r'[0-9.-]{8,}', str(caught.value))]
    east, north, _ = FRAME.enu_of(GeoPosition(*place, math.nan)).tolist()
    assert plan_drive(request_of((east, north)), ground).stops


CORNERS = ((10.0, -30.0), (30.0, -30.0), (30.0, -10.0), (10.0, -10.0), (10.0, -30.0))


def lonlat(east, north):
    """Return longitude and latitude of a place."""
    place = position(east, north)
    return place.longitude_deg, place.latitude_deg


@pytest.mark.slow
def test_command_writes_every_file(village, tmp_path, capsys):
    """And prints the budget, the proof and the curve."""
    out = tmp_path / 'out'
    words = ['--from', text(*START), '--to', 'sources', '--to', text(*BEYOND)]
    assert main([str(village), *words, '--dose-budget', '500', '--out', str(out)]) == 0
    said = capsys.readouterr().out
    assert 'drive to' in said
    assert 'gap' in said
    assert 'is kept with probability 1' in said
    assert 'time by budget of dose' in said
    document = json.loads((out / 'route.json').read_text())
    assert {stop['evidence'] for stop in document['stops']} == {'', 'source-1', 'mark-2'}
    collection = json.loads((out / 'route.geojson').read_text())
    kinds = [feature['properties']['kind'] for feature in collection['features']]
    assert kinds == ['route', 'stand', 'stand', 'evidence', 'evidence']
    items = json.loads((out / 'route.plan').read_text())['mission']['items']
    assert sum(item['command'] == 2000 for item in items) == 2
    for name in ('route.kml', 'route.gpx'):
        ElementTree.parse(out / name)  # noqa: S314 - our own file
    assert (out / 'ground.tif').stat().st_size > 1000


@pytest.mark.slow
def test_each_budget_of_the_trade_off_admits_a_drive_of_its_time(village):
    """As it is driven, with braking and turns, and surely enough."""
    request = request_of((20.0, -10.0))
    ground = ground_of(village)
    curve = plan_drive(request, ground).curve
    assert len(curve) >= 3
    assert list(curve) == sorted(curve)
    assert [time for _, time in curve] == sorted((time for _, time in curve), reverse=True)
    for budget, time in curve:
        plan = plan_drive(
            replace(request, dose_budget_usv=budget * (1.0 + 1e-6), curve_points=0), ground
        )
        assert plan.forecast.probability >= request.confidence
        assert plan.time_s <= 1.02 * time


@pytest.mark.slow
def test_time_of_the_trade_off_is_printed_once(village):
    """With the least budget that gives it."""
    plan = plan_drive(request_of((20.0, -10.0)), ground_of(village))
    curve = ((5.0, 100.2), (6.0, 100.1), (7.0, 90.0), (8.0, 90.0))
    shown = lines_of(replace(plan, curve=curve))[-2:]
    assert [line.split()[0] for line in shown] == ['5', '7']


@pytest.mark.slow
def test_marks_of_operators_propose_evidence(tmp_path, capsys):
    """Those of the console, in the log of the run; a log that somebody changed is refused."""
    folder = write_village(tmp_path)
    words = [str(folder), '--from', text(-25, 15), '--to', 'marks', '--dose-budget', '1e6']
    assert main(words) == 2
    assert 'nobody marked a place in this run' in capsys.readouterr().err
    log = EvidenceLog(folder / LOG_NAME)
    place = position(20.0, -10.0)
    where = {'latitude_deg': place.latitude_deg, 'longitude_deg': place.longitude_deg}
    mark = Event(time_s=0.0, kind='mark', by='ann', what={**where, 'text': 'a bag'})
    log.add([Event(time_s=0.0, kind='login', by='ann', what={}), mark])
    log.close()
    assert main(words) == 0
    route = json.loads((folder / 'ground' / 'route.json').read_text())
    assert [stop['evidence'] for stop in route['stops'] if stop['evidence']] == ['operator-1']
    path = folder / LOG_NAME
    path.write_text(path.read_text().replace('a bag', 'a box'))
    assert main(words) == 2
    assert 'line 2: has been changed' in capsys.readouterr().err


@pytest.mark.slow
def test_releases_propose_evidence(tmp_path, capsys):
    """The stronger the higher the priority; without any a clear refusal."""
    folder = write_village(tmp_path)
    words = [str(folder), '--from', text(*START), '--to', 'releases', '--dose-budget', '500']
    assert main(words) == 2
    assert '--to releases: the survey found no release of gas' in capsys.readouterr().err
    rows = [
        {
            'latitude_deg': position(*place).latitude_deg,
            'longitude_deg': position(*place).longitude_deg,
            'rate': rate,
            'rate_unit': 'g/s',
            'region_95_m2': 314.16,
        }
        for place, rate in (((10.0, -20.0), 50.0), ((-10.0, -25.0), 20.0))
    ]
    (folder / 'release.json').write_text(json.dumps({'releases': rows, 'agent': 'chlorine'}))
    first, second = found_releases(folder / 'release.json')
    assert (first.kind, first.priority, second.priority) == ('release', 1.0, 0.4)
    assert first.found_in == 'release 1: 50 g/s of chlorine, within 10 m (95 %)'
    assert main([*words, '--json']) == 0
    stops = json.loads(capsys.readouterr().out)['stops']
    assert {stop['evidence'] for stop in stops} == {'', 'release-1', 'release-2'}
    (folder / 'release.json').write_text('[]')
    assert main(words) == 2
    assert 'is no file of releases' in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize(
    ('words', 'code', 'match'),
    [
        (['nowhere'], 2, 'nowhere: no such folder'),
        (['{village}', '--to', 'x,y'], 2, 'must be LAT,LON'),
        (['{village}', '--to', '0.1,0.1'], 1, 'beyond the map'),
        (['{village}', '--to', 'nothing.geojson'], 2, 'No such file'),
        (['{village}', '--dose-map', 'nothing.tif'], 2, 'nothing.tif: no such file'),
        (['{village}', '--from', '9.06,53.28'], 2, 'is it latitude,longitude in WGS84'),
        (['{village}', '--dose-budget', '0.001'], 1, 'takes .* uSv'),
        (['{village}', '--load-budget', '0.1'], 2, 'has no plume.tif and threat_zones.geojson'),
        (['{village}', '--from', '-33.9,18.4'], 2, 'beyond the map'),
        (['{village}', '--to', '-33.9,18.4'], 1, 'beyond the map'),
    ],
)
def test_mistake_on_the_command_line_gives_one_line(village, capsys, words, code, match):
    """And no traceback."""
    given = [word.format(village=village) for word in words]
    for option, value in (
        ('--from', text(*START)),
        ('--to', text(*BEYOND)),
        ('--dose-budget', '500'),
    ):
        if option not in given:
            given += [option, value]
    assert main(given) == code
    said = capsys.readouterr().err
    assert said.count('\n') == 1
    assert said.startswith('error: ')
    assert re.search(match, said), said


@pytest.mark.slow
def test_labels_count_instead_of_colours_and_propose_things(tmp_path, capsys):
    """A pond that colours do not show is an obstacle; drums are evidence, the larger one first."""
    folder = write_village(tmp_path)
    labels = write_labels(folder)
    files = MapFiles(folder=folder, labels=labels)
    ground = read_ground_map(files, GroundVehicle(), CELL_M, TURN_BACK)
    assert not ground.is_free.ravel()[ground.grid.cell_of(25.0, -25.0)]
    assert ground.is_free.ravel()[ground.grid.cell_of(-10.0, 20.0)]
    first, second = labelled_things(read_labels(labels), 12)
    assert ground.grid.enu_of(first.position) == pytest.approx((-10.0, 0.0), abs=0.05)
    assert ground.grid.enu_of(second.position) == pytest.approx((5.0, -15.0), abs=0.05)
    assert labelled_things(read_labels(labels), 1) == [first]
    words = [str(folder), '--from', text(*START), '--to', 'objects', '--dose-budget', '500']
    assert main([*words, '--labels', str(labels)]) == 0
    assert 'drum-' in capsys.readouterr().out
    assert main(words) == 2
    assert '--to objects: needs --labels' in capsys.readouterr().err


def test_dose_map_of_another_place_is_refused(tmp_path):
    """It lies beyond the mosaic: nothing is known of the dose rates there."""
    folder = write_village(tmp_path)
    with rasterio.open(folder / 'dose_map.tif', 'r+') as file:
        file.transform = from_origin(5000.0, 5000.0, 2.0, 2.0)
    with pytest.raises(NoMapError, match='does not overlap'):
        ground_of(folder)


@pytest.mark.parametrize('rate', [-1.0, math.inf])
def test_dose_map_that_no_field_has_is_refused(tmp_path, rate):
    """A negative dose rate would make a way cheaper; an infinite one, none possible."""
    folder = write_village(tmp_path)
    with rasterio.open(folder / 'dose_map.tif', 'r+') as file:
        values = file.read()
        values[:, 5, 5] = rate
        file.write(values)
    with pytest.raises(NoMapError, match=r'dose_map\.tif: has a dose rate below 0, or an inf'):
        ground_of(folder)


def test_source_with_a_variance_below_zero_is_refused(tmp_path):
    """Naming the file."""
    folder = write_village(tmp_path)
    document = json.loads((folder / 'sources.json').read_text())
    document['sources'][0]['position_covariance_m2'][0][0] = -1.0
    (folder / 'sources.json').write_text(json.dumps(document))
    with pytest.raises(NoMapError, match=r'sources\.json: .*no variance below 0'):
        ground_of(folder)


def test_map_without_dose_rates_is_refused(tmp_path):
    """A route without them would promise what nobody knows."""
    folder = write_village(tmp_path)
    (folder / 'dose_map.tif').unlink()
    with pytest.raises(NoMapError, match=r'dose_map\.tif: no such file'):
        ground_of(folder)
