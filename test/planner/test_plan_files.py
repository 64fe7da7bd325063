# SPDX-License-Identifier: Apache-2.0
"""Files of a plan, read back as other programs would."""

import csv
import dataclasses
import itertools
import json
import math
import os
import zipfile
from xml.etree import ElementTree

import pytest
import shapely
from PIL import Image

from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.regions.area_files import read_area
from rocsafe_planner.export.plan_files import write_plan
from rocsafe_planner.export.plan_geojson import plan_geojson
from rocsafe_planner.export.route_colors import kml_color, route_color
from rocsafe_planner.plan.flight_summary import flight_stem
from rocsafe_planner.planning import plan_survey

from .fleets import RECTANGLE, request, vehicle

KML = '{http://www.opengis.net/kml/2.2}'
HOLE = tuple(
    GeoPosition(lat, lon)
    for lat, lon in ((53.2798, -9.0632), (53.2800, -9.0632), (53.2800, -9.0635))
)
AREA = SurveyArea(RECTANGLE.boundary, (HOLE,), 'A & B <yard>')


@pytest.fixture(scope='module')
def plan():
    """Return a plan with a hole, a name for XML to escape, and a vehicle that stays at home."""
    vehicles = (
        vehicle('rav1'),
        vehicle('rav2', altitude=math.nan),
        vehicle('idle', home=(53.5, -9.0)),
    )
    found = plan_survey(request(area=AREA, vehicles=vehicles, method='nearest_to_shortest'))
    routes = (*found.routes[:2], dataclasses.replace(found.routes[2], sorties=()))
    return dataclasses.replace(found, routes=routes)


@pytest.fixture(scope='module')
def folder(plan, tmp_path_factory):
    """Return a folder with the plan's files, to be read only."""
    folder = tmp_path_factory.mktemp('plan')
    write_plan(plan, folder)
    return folder


@pytest.mark.slow
def test_json_says_all(plan, folder):
    """Figures, region, fleet and every viewpoint are there; unknown altitudes are null."""
    document = json.loads((folder / 'plan.json').read_text())
    assert document['plan_id'] == plan.plan_id
    assert document['makespan_s'] == plan.makespan_s
    assert document['request']['regions'][0]['name'] == 'A & B <yard>'
    assert len(document['request']['regions'][0]['holes'][0]) == 3
    assert document['request']['vehicles'][1]['home']['altitude_m'] is None
    for written, route in zip(document['routes'], plan.routes, strict=True):
        assert [v['id'] for v in written['viewpoints']] == [v.id for v in route.viewpoints]
    first = document['routes'][0]['viewpoints'][0]
    assert first['latitude_deg'] == plan.routes[0].viewpoints[0].position.latitude_deg
    assert set(first) == {
        'id',
        'latitude_deg',
        'longitude_deg',
        'altitude_m',
        'height_agl_m',
        'yaw_rad',
        'sensors',
    }


@pytest.mark.parametrize('name', ['plan.geojson', 'plan.kml'])
def test_region_survives_the_file(folder, name):
    """The file's region is read back with its hole, in whatever turning sense."""
    area = read_area(folder / name)
    assert area.name == 'A & B <yard>'
    ours, theirs = (
        shapely.Polygon(
            [(c.longitude_deg, c.latitude_deg) for c in a.boundary],
            [[(c.longitude_deg, c.latitude_deg) for c in h] for h in a.holes],
        )
        for a in (AREA, area)
    )
    # Nine decimals of a degree.
    assert ours.symmetric_difference(theirs).area < 1e-10


def test_geojson_features(plan):
    """One feature for each thing; rings turn as RFC 7946 wants."""
    features = plan_geojson(plan)['features']
    kinds = [feature['properties']['kind'] for feature in features]
    assert {kind: kinds.count(kind) for kind in set(kinds)} == {
        'region': 1,
        'home': 3,
        'route': 2,
        'viewpoint': plan.viewpoint_count,
    }
    outer, hole = features[0]['geometry']['coordinates']
    assert shapely.LinearRing(outer).is_ccw
    assert not shapely.LinearRing(hole).is_ccw
    assert outer[0] == outer[-1]


def test_kml_opens_as_folders_with_heights(plan, folder):
    """A folder for the region and each vehicle; the flown line stands 32 m above ground."""
    document = ElementTree.parse(folder / 'plan.kml').getroot()[0]  # noqa: S314 (our own file)
    folders = document.findall(f'{KML}Folder')
    assert [f.find(f'{KML}name').text for f in folders] == ['Region', 'rav1', 'rav2', 'idle']
    line = folders[1].find(f'.//{KML}LineString')
    assert line.find(f'{KML}altitudeMode').text == 'relativeToGround'
    places = [place.split(',') for place in line.find(f'{KML}coordinates').text.split()]
    assert [float(place[2]) for place in places] == (
        [0.0] + [32.0] * (len(plan.routes[0].viewpoints) + 2) + [0.0]
    )
    assert float(places[0][1]) == plan.routes[0].vehicle.home.latitude_deg
    styles = {f'#{style.get("id")}' for style in document.findall(f'{KML}Style')}
    assert {url.text for url in document.iter(f'{KML}styleUrl')} <= styles


def test_qgroundcontrol_mission(plan, folder):
    """Take-off, waypoint and photograph by turns, back above home, then return to launch."""
    document = json.loads((folder / 'plan-rav1.plan').read_text())
    assert (document['fileType'], document['version']) == ('Plan', 1)
    mission = document['mission']
    assert mission['plannedHomePosition'][:2] == [53.28, -9.07]
    items, route = mission['items'], plan.routes[0]
    shots = [16, 2000] * len(route.viewpoints)
    assert [item['command'] for item in items] == [22, *shots, 16, 20]
    assert [item['doJumpId'] for item in items] == list(range(1, len(items) + 1))
    assert all(len(item['params']) == 7 for item in items)
    for item, viewpoint in zip(items[1:-2:2], route.viewpoints, strict=True):
        hold, _, _, heading, latitude, longitude, altitude = item['params']
        assert (hold, heading, altitude, item['frame']) == (2.0, 0.0, 32.0, 3)
        assert latitude == pytest.approx(viewpoint.position.latitude_deg, abs=1e-9)
        assert longitude == pytest.approx(viewpoint.position.longitude_deg, abs=1e-9)
    assert items[2]['params'] == [0, 0, 1, None, None, None, None]


def test_a_vehicle_that_stays_gets_no_mission(folder):
    """Its plan has no items, so that none from before is flown by mistake."""
    document = json.loads((folder / 'plan-idle.plan').read_text())
    assert document['mission']['items'] == []


@pytest.mark.slow
def test_equal_requests_give_equal_files(tmp_path):
    """Byte for byte, in whatever folder."""
    files = [write_plan(plan_survey(request()), tmp_path / name) for name in 'ab']
    flights = [f'plan-rav{k}.{kind}' for k in (1, 2, 3) for kind in ('plan', 'waypoints', 'kmz')]
    assert [p.name for p in files[0]] == [
        'plan.kml',
        'plan.geojson',
        'plan.gpx',
        'plan.csv',
        'plan.svg',
        'plan.png',
        *flights,
        'plan.json',
    ]
    for a, b in zip(*files, strict=True):
        assert a.read_bytes() == b.read_bytes()


def test_a_failed_write_leaves_the_old_file(plan, folder, monkeypatch):
    """When the disk is full the old plan stays whole, and nothing half-written is left."""
    before = {path.name: path.read_bytes() for path in folder.iterdir()}

    def full(_descriptor):
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(os, 'fsync', full)
    with pytest.raises(ValueError, match=r'cannot write the plan to .*: No space left on device'):
        write_plan(plan, folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_folder_that_cannot_be_made_is_refused(plan, tmp_path):
    """A file where the folder should be gives one line."""
    (tmp_path / 'file').write_text('')
    with pytest.raises(ValueError, match='cannot write the plan to'):
        write_plan(plan, tmp_path / 'file' / 'out')


def test_colours_of_both_formats_agree():
    """KML writes blue first."""
    assert (route_color(0), kml_color(0)) == ('#0072B2', 'ffb27200')
    assert route_color(6) == route_color(0)


def test_waypoints_come_back(plan, folder):
    """A MAVLink list: home, take-off, way-point and photograph by turns, above home, return."""
    header, *lines = (folder / 'plan-rav1.waypoints').read_text().splitlines()
    assert header == 'QGC WPL 110'
    rows = [line.split('\t') for line in lines]
    assert all(len(row) == 12 for row in rows)
    assert [int(row[0]) for row in rows] == list(range(len(rows)))
    commands = [int(row[3]) for row in rows]
    assert commands == [16, 22, *[16, 2000] * len(plan.routes[0].viewpoints), 16, 20]
    for row, viewpoint in zip(rows[2:-2:2], plan.routes[0].viewpoints, strict=True):
        assert float(row[4]) == 2.0
        place = GeoPosition(float(row[8]), float(row[9]))
        assert distance_m(place, viewpoint.position) < 0.01
        assert float(row[10]) == 32.0


def test_gpx_comes_back(plan, folder):
    """A route a vehicle that flies, from home to home, its viewpoints by name."""
    gpx = '{http://www.topografix.com/GPX/1/1}'
    root = ElementTree.parse(folder / 'plan.gpx').getroot()  # noqa: S314 (our own file)
    routes = root.findall(f'{gpx}rte')
    assert [route.find(f'{gpx}name').text for route in routes] == ['rav1', 'rav2']
    for written, route in zip(routes, plan.routes, strict=False):
        points = written.findall(f'{gpx}rtept')
        assert len(points) == len(route.viewpoints) + 2
        names = [point.findtext(f'{gpx}name') for point in points[1:-1]]
        assert names == [str(viewpoint.id) for viewpoint in route.viewpoints]
        place = GeoPosition(float(points[1].get('lat')), float(points[1].get('lon')))
        assert distance_m(place, route.viewpoints[0].position) < 0.001


def test_dji_archive_comes_back(plan, folder):
    """Both documents hold every viewpoint in order, and a photograph at each."""
    kml, wpml = '{http://www.opengis.net/kml/2.2}', '{http://www.dji.com/wpmz/1.0.2}'
    with zipfile.ZipFile(folder / 'plan-rav1.kmz') as archive:
        assert archive.namelist() == ['wpmz/template.kml', 'wpmz/waylines.wpml']
        roots = [ElementTree.fromstring(archive.read(n)) for n in archive.namelist()]  # noqa: S314
    for root, height in zip(roots, ('height', 'executeHeight'), strict=True):
        *marks, last = root.iter(f'{kml}Placemark')
        home = plan.routes[0].vehicle.home
        assert last.findtext(f'{kml}Point/{kml}coordinates').startswith(
            f'{home.longitude_deg:.9f}'
        )
        for mark, viewpoint in zip(marks, plan.routes[0].viewpoints, strict=True):
            place = mark.findtext(f'{kml}Point/{kml}coordinates').split(',')
            assert (
                distance_m(GeoPosition(float(place[1]), float(place[0])), viewpoint.position)
                < 0.001
            )
            assert mark.findtext(f'{wpml}{height}') == '32'
            functions = [f.text for f in mark.iter(f'{wpml}actionActuatorFunc')]
            assert functions == ['gimbalRotate', 'hover', 'takePhoto']


@pytest.fixture(scope='module')
def relay(tmp_path_factory):
    """Return a plan of small batteries, one home, landings at home, elsewhere and anywhere."""
    small = {'endurance_s': 210.0, 'battery_swap_s': 60.0}
    fleet = (
        vehicle('back', **small),
        vehicle('over', end=GeoPosition(53.2810, -9.0600), **small),
        vehicle('away', is_open=True, **small),
    )
    plan = plan_survey(
        request(vehicles=fleet, method='nearest_to_shortest', distance_m=5.0, height_agl_m=40.0)
    )
    folder = tmp_path_factory.mktemp('relay')
    write_plan(plan, folder)
    return plan, folder


@pytest.mark.slow
def test_the_table_says_when_each_flight_begins(relay):
    """By the clock of the mission: delays, swaps, landings; the last one ends the mission."""
    plan, folder = relay
    rows = list(csv.DictReader((folder / 'plan.csv').open()))
    begins = [float(row['takes_off_s']) for row in rows]
    assert begins == sorted(begins)
    assert len(rows) == sum(len(route.sorties) for route in plan.routes) > 3
    assert max(float(row['lands_s']) for row in rows) == pytest.approx(plan.makespan_s, abs=0.05)
    assert any(route.delay_s > 0.0 for route in plan.routes)
    for route, end in zip(plan.routes, ('home', 'end', 'last viewpoint'), strict=True):
        own = [row for row in rows if row['vehicle'] == route.vehicle.name]
        assert float(own[0]['takes_off_s']) == pytest.approx(route.delay_s, abs=0.05)
        assert [row['lands'] for row in own] == ['home'] * (len(own) - 1) + [end]
        assert [row['battery_swap_s'] for row in own] == ['60.0'] * (len(own) - 1) + ['']
        for row, after in itertools.pairwise(own):
            pause = float(after['takes_off_s']) - float(row['lands_s'])
            assert pause == pytest.approx(60.0, abs=0.11)
        assert all((folder / f'{row["file"]}.waypoints').is_file() for row in own)


def _landing(folder, stem):
    """Return the last command and place of a flight in all three formats, and DJI's action."""
    row = (folder / f'{stem}.waypoints').read_text().splitlines()[-1].split('\t')
    item = json.loads((folder / f'{stem}.plan').read_text())['mission']['items'][-1]
    with zipfile.ZipFile(folder / f'{stem}.kmz') as archive:
        wayline = archive.read('wpmz/waylines.wpml').decode()
    action = wayline.split('finishAction>')[1].split('<')[0]
    last = wayline.rsplit('<coordinates>', 1)[1].split('<')[0]
    assert int(row[3]) == item['command']
    return int(row[3]), (float(row[8]), float(row[9])), action, last


def test_flights_land_where_the_plan_says(relay):
    """At home for a new battery; then at home, at the end, or at the last viewpoint."""
    plan, folder = relay
    for route in plan.routes:
        stems = [flight_stem(route, number) for number in range(len(route.sorties))]
        home, end = route.vehicle.home, route.vehicle.end
        place = end or (route.viewpoints[-1].position if route.vehicle.is_open else home)
        for stem in stems:
            command, where, action, last = _landing(folder, stem)
            if stem != stems[-1] or place == home:
                assert (command, action) == (20, 'goHome')
                assert last == f'{home.longitude_deg:.9f},{home.latitude_deg:.9f}'
            else:
                assert (command, action) == (21, 'autoLand')
                assert where == pytest.approx((place.latitude_deg, place.longitude_deg))
                assert last == f'{place.longitude_deg:.9f},{place.latitude_deg:.9f}'


def test_maps_say_when_and_where_flights_land(relay):
    """In KML, GPX and GeoJSON each flight says when it begins and where it lands."""
    plan, folder = relay
    kml = (folder / 'plan.kml').read_text()
    assert '<name>over end</name>' in kml
    assert '<name>back flight 2</name>' in kml
    gpx = (folder / 'plan.gpx').read_text()
    routes = [
        f['properties']
        for f in plan_geojson(plan)['features']
        if f['properties']['kind'] == 'route'
    ]
    for said in routes:
        assert said['description'] in kml
        assert f'<desc>{said["description"]}</desc>' in gpx
    assert 'lands at its last viewpoint after' in routes[-1]['description']
    assert routes[0]['description'].endswith('and gets a new battery within 60 s')
    heights = [float(part.split('<')[0]) for part in gpx.split('<ele>')[1:]]
    assert heights == pytest.approx([52.0] * len(heights), abs=0.01)


@pytest.mark.slow
def test_flights_from_before_are_removed(plan, tmp_path):
    """A vehicle that stays this time leaves no flight of the last time behind."""
    routes = (dataclasses.replace(plan.routes[0], sorties=()), *plan.routes[1:])
    for written in (plan, dataclasses.replace(plan, routes=routes)):
        write_plan(written, tmp_path)
    assert sorted(p.name for p in tmp_path.glob('plan-rav1*')) == ['plan-rav1.plan']


def test_pictures(plan, folder):
    """The vector picture holds every route and footprint, the other is as large."""
    root = ElementTree.parse(folder / 'plan.svg').getroot()  # noqa: S314 (our own file)
    svg = '{http://www.w3.org/2000/svg}'
    lines = root.findall(f'{svg}polyline')
    assert len(lines) == 2 + 1  # routes, scale bar
    assert len(lines[0].get('points').split()) == len(plan.routes[0].viewpoints) + 2
    # A region with its hole, and the footprints.
    assert len(root.findall(f'{svg}polygon')) == 2 + plan.viewpoint_count
    texts = [text.text for text in root.findall(f'{svg}text')]
    assert any('% above optimal: no plan is shorter than' in text for text in texts)
    with Image.open(folder / 'plan.png') as image:
        assert image.size == (int(root.get('width')), int(root.get('height')))
        assert len(image.getcolors(maxcolors=1 << 20)) > 10
