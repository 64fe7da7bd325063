# SPDX-License-Identifier: Apache-2.0
"""Files of a plan, read back as other programs would."""

import dataclasses
import json
import math
import os
from xml.etree import ElementTree

import pytest
import shapely

from rocsafe_geo.area import SurveyArea
from rocsafe_geo.area_files import read_area
from rocsafe_geo.position import GeoPosition
from rocsafe_planner.plan_files import write_plan
from rocsafe_planner.plan_geojson import plan_geojson
from rocsafe_planner.planning import plan_survey
from rocsafe_planner.route_colors import kml_color, route_color

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


@pytest.fixture
def folder(plan, tmp_path):
    """Return a folder with the plan's files."""
    write_plan(plan, tmp_path)
    return tmp_path


def test_json_says_all(plan, folder):
    """Figures, region, fleet and every viewpoint are there; unknown altitudes are null."""
    document = json.loads((folder / 'plan.json').read_text())
    assert document['plan_id'] == plan.plan_id
    assert document['makespan_s'] == plan.makespan_s
    assert document['region']['name'] == 'A & B <yard>'
    assert len(document['region']['holes'][0]) == 3
    assert document['vehicles'][1]['home']['altitude_m'] is None
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
    """One feature for each thing; rings turn as RFC 7946 wants; footprints only when asked."""
    for with_footprints in (False, True):
        features = plan_geojson(plan, with_footprints)['features']
        kinds = [feature['properties']['kind'] for feature in features]
        count = plan.viewpoint_count
        assert {kind: kinds.count(kind) for kind in set(kinds)} == {
            'region': 1,
            'home': 3,
            'route': 2,
            'viewpoint': count,
            **({'footprint': count} if with_footprints else {}),
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
    """Take-off, then waypoint and photograph by turns, then return to launch."""
    document = json.loads((folder / 'plan-rav1.plan').read_text())
    assert (document['fileType'], document['version']) == ('Plan', 1)
    mission = document['mission']
    assert mission['plannedHomePosition'][:2] == [53.28, -9.07]
    items, route = mission['items'], plan.routes[0]
    assert [item['command'] for item in items] == [22, *[16, 2000] * len(route.viewpoints), 20]
    assert [item['doJumpId'] for item in items] == list(range(1, len(items) + 1))
    assert all(len(item['params']) == 7 for item in items)
    for item, viewpoint in zip(items[1:-1:2], route.viewpoints, strict=True):
        hold, _, _, heading, latitude, longitude, altitude = item['params']
        assert (hold, heading, altitude, item['frame']) == (2.0, 0.0, 32.0, 3)
        assert latitude == pytest.approx(viewpoint.position.latitude_deg, abs=1e-9)
        assert longitude == pytest.approx(viewpoint.position.longitude_deg, abs=1e-9)
    assert items[2]['params'] == [0, 0, 1, None, None, None, None]


def test_a_vehicle_that_stays_gets_no_mission(folder):
    """Its plan has no items, so that none from before is flown by mistake."""
    document = json.loads((folder / 'plan-idle.plan').read_text())
    assert document['mission']['items'] == []


def test_equal_requests_give_equal_files(tmp_path):
    """Byte for byte, in whatever folder."""
    files = [write_plan(plan_survey(request()), tmp_path / name) for name in 'ab']
    assert [p.name for p in files[0]] == [
        'plan.kml',
        'plan.geojson',
        'plan-rav1.plan',
        'plan-rav2.plan',
        'plan-rav3.plan',
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
