# SPDX-License-Identifier: Apache-2.0
"""Photographs without a fix are mapped: by ground control, a list, a track, or locally."""

import dataclasses
import importlib.util
import json
import math
import pathlib
from datetime import datetime, timedelta, timezone

import numpy as np
import pytest
import rasterio
from pyproj import Transformer

from rocsafe_geo.pinhole import ground_homography
from rocsafe_mapping.command_line.map_command import EXIT_FAILED, EXIT_OK, EXIT_REFUSED, main
from rocsafe_mapping.errors import MappingError, PlacementError
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Shot
from rocsafe_mapping.mosaic.survey import Survey
from rocsafe_mapping.photographs.exif import with_exif
from rocsafe_mapping.photographs.geolocation import read_geolocations
from rocsafe_mapping.photographs.ground_control import read_control
from rocsafe_mapping.photographs.track import read_track
from rocsafe_mapping.products.control_points import control_facts
from rocsafe_mapping.products.quality import violations

pytestmark = pytest.mark.slow

_spec = importlib.util.spec_from_file_location(
    'texture', pathlib.Path(__file__).with_name('texture.py')
)
texture = importlib.util.module_from_spec(_spec)
_spec.loader.exec_module(texture)

TO_UTM = Transformer.from_crs(4326, 32629, always_xy=True)
# Surveyed points of the ground, local (east, north) in metres.
POINTS = {
    'a': (-20.0, 12.0), 'b': (19.0, 11.0), 'c': (-18.0, -13.0), 'd': (20.0, -12.0),
    'CHK-1': (1.0, 2.0), 'CHK-2': (-8.0, -9.0),
}  # fmt: skip
UNKNOWN = {'latitude_deg': math.nan, 'longitude_deg': math.nan, 'altitude_m': math.nan}


def ignored(line):
    """Take a notice that the test does not look at."""


def place_of(east, north):
    """Return longitude and latitude of a point of the ground."""
    latitude, longitude, _ = texture.FRAME.to_geodetic([east, north, 0.0])[0]
    return longitude, latitude


@pytest.fixture(scope='module')
def flight():
    """Eight photographs of level ground, their fixes off by 3 m."""
    return texture.flight(5, rows=2, columns=4, spacing_m=(13.0, 13.0), fix_m=3.0)


def without_fix(shot):
    """Return the photograph as a camera without a receiver takes it."""
    return dataclasses.replace(shot.record, **UNKNOWN, height_agl_m=math.nan)


def name_of(shot):
    """Return the name of its file."""
    return f'DJI_{shot.record.sequence:04d}.JPG'


def gcp_text(flight, points=POINTS):
    """Return a gcp_list.txt of `points` as the photographs show them."""
    lines = ['EPSG:32629']
    for label, (east, north) in points.items():
        x, y = TO_UTM.transform(*place_of(east, north))
        for shot in flight:
            homography = ground_homography(texture.CAMERA, shot.centre, shot.rotation)
            u, v, w = homography @ [east, north, 1.0]
            column, row = u / w, v / w
            if 5 < column < 394 and 5 < row < 294:
                lines.append(
                    f'{x:.4f}\t{y:.4f}\t60.0\t{column:.2f}\t{row:.2f}\t{name_of(shot)}\t{label}'
                )
    return '\n'.join(lines) + '\n'


def aligned(shots, survey=None):
    """Return the map maker and its alignment of `shots`, pairs of name, record and JPEG file."""
    notices = []
    maker = Mapmaker(MapOptions(), notices.append)
    maker.add_all(
        [
            Shot(name=name, record=record, read=lambda jpeg=jpeg: jpeg)
            for name, record, jpeg in shots
        ],
        survey,
    )
    return maker, maker.align(), notices


@pytest.fixture(scope='module')
def control(flight, tmp_path_factory):
    """The surveyed points, read from a file."""
    path = tmp_path_factory.mktemp('control') / 'gcp_list.txt'
    path.write_text(gcp_text(flight))
    return read_control(path, ignored)


@pytest.fixture(scope='module')
def checked(flight, control):
    """The alignment of all photographs by their fixes, with check points alone."""
    shots = [(name_of(shot), shot.record, shot.jpeg) for shot in flight]
    points = tuple(point for point in control if point.is_check)
    return aligned(shots, Survey(control=points))[1]


def test_ground_control_places_photographs_without_a_fix(flight, control):
    """Check points, which take no part, are exact to what is stated."""
    shots = [(name_of(shot), without_fix(shot), shot.jpeg) for shot in flight]
    _, alignment, _ = aligned(shots, Survey(control=control))
    facts = control_facts(alignment)
    assert facts['check']['count'] == 2
    assert facts['check']['rmse_m'] < 0.1
    assert facts['check']['rmse_m'] < 3.0 * facts['check']['stated_error_m']
    assert not alignment.is_local


def test_ground_control_tightens_a_map_with_fixes(flight, control, checked):
    """The map that fixes of 3 m place is off by a metre; with ground control by centimetres."""
    shots = [(name_of(shot), shot.record, shot.jpeg) for shot in flight]
    loose = control_facts(checked)
    tight = control_facts(aligned(shots, Survey(control=control))[1])
    assert tight['check']['rmse_m'] < 0.1 < loose['check']['rmse_m']
    assert tight['check']['stated_error_m'] < 0.2 * loose['check']['stated_error_m']


@pytest.mark.parametrize(
    ('crs', 'x', 'y', 'datum_error_m', 'says'),
    [
        ('EPSG:27700', 351339.5, 512979.5, 2.0, 'uk_os_OSTN15_NTv2_OSGBtoETRS.tif'),
        ('EPSG:4230', 9.0, 53.0, 1.5, 'EPSG:4230'),
        ('EPSG:25832', 500000.0, 5900000.0, 0.0, None),
        ('EPSG:4326', 9.0, 53.0, 0.0, None),
        ('WGS84 UTM 32N', 500000.0, 5900000.0, 0.0, None),
    ],
)
def test_a_datum_that_is_known_to_metres_is_told(tmp_path, crs, x, y, datum_error_m, says):
    """Figures of PROJ's data base: without its grids, the British National Grid is off by 2 m."""
    path, notices = tmp_path / 'list.txt', []
    path.write_text(f'{crs}\n{x} {y} 60 10 20 a.jpg a')
    (point,) = read_control(path, notices.append)
    path.write_text(f'{crs}\na.jpg {x} {y}')
    place = read_geolocations(path, notices.append)['a.jpg']
    assert point.datum_error_m == place.datum_error_m >= datum_error_m
    assert (point.datum_error_m == 0.0) == (datum_error_m == 0.0)
    assert len(notices) == (0 if says is None else 2)
    assert all(says in notice for notice in notices)


def test_an_inexact_datum_is_in_the_stated_error(flight, control, checked):
    """Of check points in another CRS than the fixes, and of all that such points place."""
    shots = [(name_of(shot), shot.record, shot.jpeg) for shot in flight]
    inexact = tuple(dataclasses.replace(point, datum_error_m=2.0) for point in control)
    checks = Survey(control=tuple(point for point in inexact if point.is_check))
    judged, exact = (control_facts(it)['check'] for it in (aligned(shots, checks)[1], checked))
    assert judged['stated_error_m'] == pytest.approx(
        math.hypot(exact['stated_error_m'], 2.0), rel=0.01
    )
    assert judged['rmse_m'] == exact['rmse_m']
    placed = aligned(shots, Survey(control=inexact))[1]
    assert min(placed.errors_m.values()) >= 2.0
    assert control_facts(placed)['check']['stated_error_m'] == pytest.approx(2.0, abs=0.1)


def test_check_points_do_not_move_the_map(flight, checked):
    """With check points alone, all photographs lie where they lie without."""
    shots = [(name_of(shot), shot.record, shot.jpeg) for shot in flight]
    for name, placement in aligned(shots)[1].placements.items():
        assert np.array_equal(placement.pose.centre, checked.placements[name].pose.centre)


@pytest.mark.parametrize('lost', [0, 5])
def test_a_photograph_without_fix_lies_beside_those_that_have_one(flight, lost):
    """One photograph of eight, also the first, lost its fix; it is placed by what it shows."""
    shots = [
        (name_of(shot), without_fix(shot) if number == lost else shot.record, shot.jpeg)
        for number, shot in enumerate(flight)
    ]
    _, alignment, notices = aligned(shots)
    found = alignment.placements[name_of(flight[lost])].pose.centre
    others = [alignment.placements[name_of(s)].pose.centre - s.centre for s in flight]
    assert not notices
    assert np.linalg.norm((found - flight[lost].centre - np.mean(others, axis=0))[:2]) < 0.5


def test_a_photograph_that_nothing_places_is_left_out(flight):
    """Neither a fix nor ties: it is named, and not drawn at the edge of the world."""
    other = texture.flight(99, rows=1, columns=1)[0]
    shots = [(name_of(shot), shot.record, shot.jpeg) for shot in flight]
    shots.append(('lost.jpg', without_fix(other), other.jpeg))
    maker, _, notices = aligned(shots)
    assert [note for note in notices if 'lost.jpg' in note and 'without a fix' in note]
    assert 'lost.jpg' not in maker


def path_text(flight, behind_s, kind):
    """Return a track that passes the photographs, its clock `behind_s` ahead of the camera's."""
    places = np.array([shot.centre[:2] for shot in flight])
    seconds = np.array([shot.record.time_ns / 1e9 for shot in flight])
    places = np.concatenate([[places[0] - (40, 25)], places, [places[-1] + (30, -50)]])
    seconds = np.concatenate([[seconds[0] - 9.0], seconds, [seconds[-1] + 7.0]])
    rows = []
    for second in np.arange(seconds[0], seconds[-1] + 0.2, 0.25):
        east, north = (np.interp(second, seconds, column) for column in places.T)
        longitude, latitude = place_of(east, north)
        time = datetime.fromtimestamp(0, timezone.utc) + timedelta(seconds=second + behind_s)
        rows.append((time.isoformat(), latitude, longitude))
    if kind == 'csv':
        lines = ['Latitude,Longitude,Time', *(f'{lat:.8f},{lon:.8f},{t}' for t, lat, lon in rows)]
        return '\n'.join(lines)
    points = ''.join(
        f'<trkpt lat="{lat:.8f}" lon="{lon:.8f}"><ele>92.0</ele><time>{t}</time></trkpt>'
        for t, lat, lon in rows
    )
    return (
        '<?xml version="1.0"?><gpx version="1.1" xmlns="http://www.topografix.com/GPX/1/1">'
        f'<trk><trkseg>{points}</trkseg></trk></gpx>'
    )


@pytest.mark.parametrize(('kind', 'given'), [('gpx', False), ('csv', True)])
def test_a_track_places_photographs_by_their_times(flight, tmp_path, kind, given):
    """The offset of the clocks, two hours and some seconds, is found, or taken as given."""
    path = tmp_path / 'track'
    path.write_text(path_text(flight, 7203.4, kind))
    survey = Survey(track=read_track(path), clock_offset_s=7203.4 if given else math.nan)
    shots = [(name_of(shot), without_fix(shot), shot.jpeg) for shot in flight]
    maker, alignment, notices = aligned(shots, survey)
    assert maker.block.clock_offset_s == pytest.approx(7203.4, abs=0.3)
    frame = maker.frame.frame
    off = []
    for shot in flight:
        there = frame.to_geodetic(alignment.placements[name_of(shot)].pose.centre)[0]
        off.append(texture.FRAME.to_enu(there[0], there[1], [60.0])[0, :2] - shot.centre[:2])
    assert np.sqrt(np.mean(np.sum(np.array(off) ** 2, axis=1))) < 3.0
    assert any('+7203' in note for note in notices)


def test_a_track_of_another_flight_is_refused(flight, tmp_path):
    """Nothing of it has the shape of the photographs."""
    path = tmp_path / 'track.csv'
    rows = [f'{t},{53.28 + 1e-4 * t},{-9.06}' for t in range(60)]
    path.write_text('\n'.join(['time,lat,lon', *rows]))
    shots = [(name_of(shot), without_fix(shot), shot.jpeg) for shot in flight]
    with pytest.raises(PlacementError, match='clock-offset'):
        aligned(shots, Survey(track=read_track(path)))


@pytest.fixture(scope='module')
def folder(flight, tmp_path_factory):
    """A folder of photographs whose tags tell no place."""
    folder = tmp_path_factory.mktemp('no_fix')
    for shot in flight:
        (folder / name_of(shot)).write_bytes(with_exif(shot.jpeg, without_fix(shot)))
    return folder


def test_local_map_says_that_it_has_neither_scale_nor_north(flight, folder, tmp_path, capsys):
    """It is drawn without KML and tiles, its CRS is no place on earth, and its shape is right."""
    assert main([str(folder), '-o', str(tmp_path)]) == EXIT_FAILED
    assert 'neither scale nor north' in capsys.readouterr().out
    quality = json.loads((tmp_path / 'quality.json').read_text())
    assert quality['is_local']
    assert quality['epsg_code'] is None
    assert quality['photographs']['placed_by_features'] == len(flight)
    with rasterio.open(tmp_path / 'mosaic.tif') as file:
        assert 'without scale or north' in file.crs.to_wkt()
        assert np.mean(file.dataset_mask() > 0) > 0.3
    assert 'without scale or north' in (tmp_path / 'mosaic.prj').read_text()
    assert not (tmp_path / 'mosaic.kml').exists()
    assert not (tmp_path / 'mosaic.mbtiles').exists()


def test_local_map_has_the_right_shape(flight):
    """Its camera centres are those of the flight but for a similarity."""
    shots = [(name_of(shot), without_fix(shot), shot.jpeg) for shot in flight]
    _, alignment, _ = aligned(shots)
    found = np.array([complex(*alignment.placements[n].pose.centre[:2]) for n, *_ in shots])
    truth = np.array([complex(*shot.centre[:2]) for shot in flight])
    found, truth = found - found.mean(), truth - truth.mean()
    factor = np.vdot(found, truth) / np.vdot(found, found)
    assert np.abs(found * factor - truth).max() < 0.5


def test_geo_txt_places_photographs(flight, folder, tmp_path):
    """Places of OpenDroneMap's file, here in UTM, put the map where the flight was."""
    lines = ['WGS84 UTM 29N']
    for shot in flight:
        x, y = TO_UTM.transform(*place_of(*shot.centre[:2]))
        lines.append(f'{name_of(shot)} {x:.3f} {y:.3f} 92.0 0 0 0 0.05 0.1')
    path = tmp_path / 'geo.txt'
    path.write_text('\n'.join(lines))
    out = tmp_path / 'map'
    arguments = [str(folder), '--geo', str(path), '-o', str(out), '--only-geotiff']
    assert main(arguments) == EXIT_OK
    with rasterio.open(out / 'mosaic.tif') as file:
        east, north = file.transform @ (file.width / 2, file.height / 2)
    assert np.hypot(*(np.array([east, north]) - TO_UTM.transform(*place_of(0, 0)))) < 3.0


def control_at(path):
    """Read ground control."""
    return read_control(path, ignored)


def places_at(path):
    """Read places of photographs."""
    return read_geolocations(path, ignored)


GCP_ROW = '500000 5900000 60 10 20 DJI_0000.JPG a'
BAD = [
    (control_at, '', 'it is empty'),
    (control_at, 'EPSG:32629\n', 'it has no point'),
    (control_at, 'EPSG:999999\n' + GCP_ROW, "row 1: CRS = 'EPSG:999999'"),
    (control_at, 'WGS84 UTM 61N\n' + GCP_ROW, 'row 1: UTM zone = 61 must be from 1 to 60'),
    (control_at, 'EPSG:32629\n500000 x 60 10 20 a.jpg', "row 2: geo_y = 'x' is no number"),
    (control_at, 'EPSG:32629\n500000 inf 60 10 20 a.jpg', 'row 2: geo_y = inf must be finite'),
    (control_at, 'EPSG:32629\n500000 5900000 60 10 20', 'row 2: image_name is missing'),
    (control_at, f'EPSG:32629\n{GCP_ROW}\n500009 5900000 0 1 2 b.jpg a', 'row 3: a has'),
    (control_at, 'EPSG:4326\n10 95 0 1 2 a.jpg', 'row 2: geo_x = 10, geo_y = 95 lie outside'),
    (places_at, 'EPSG:4326\n', 'it names no photograph'),
    (places_at, 'EPSG:4326\na.jpg 9', "row 2: geo_y = '' is no number"),
    (places_at, 'EPSG:4326\na.jpg 9 53\nA.JPG 9 53', "row 3: image_name = 'A.JPG' stands"),
    (places_at, 'EPSG:4326\na.jpg 9 53 1 0 0 0 -1', 'row 2: horz_accuracy = -1 must be'),
    (read_track, 'lat,lon\n1,2', 'row 1: no column is called time or'),
    (read_track, 'time,lat,lon\nnoon,1,2\n', "row 2: time = 'noon' is neither ISO 8601"),
    (read_track, 'time,lat,lon\n1,91,2\n2,1,2', 'row 2: latitude = 91 must be'),
    (read_track, 'time,lat,lon\n1,1,2', '1 points with a time are no track'),
    (read_track, '<gpx><trk>', 'it is no GPX'),
    (read_track, '<!DOCTYPE x><gpx/>', 'a GPX file has no DOCTYPE'),
    (read_track, '<gpx><trkpt lat="1" lon="b"><time>1</time></trkpt></gpx>',
     "trkpt 1: longitude = 'b' is no number"),
]  # fmt: skip


@pytest.mark.parametrize(('read', 'text', 'says'), BAD)
def test_bad_files_are_refused_by_file_row_and_value(tmp_path, read, text, says):
    """One line tells what is wrong and where."""
    path = tmp_path / 'list.txt'
    path.write_text(text)
    with pytest.raises(MappingError) as caught:
        read(path)
    assert str(caught.value).startswith(str(path))
    assert says in str(caught.value)
    assert '\n' not in str(caught.value)


@pytest.mark.parametrize(
    ('arguments', 'text', 'says'),
    [
        (['--gcp'], 'EPSG:32629\n' + GCP_ROW.replace('59', '69'), 'km from the photographs'),
        (['--gcp'], 'EPSG:4326\n-9.06 53.28 0 500 2 DJI_0000.JPG a', 'im_x = 500 must be from 0'),
        (['--gcp'], 'EPSG:4326\n-9.06 53.28 0 5 2 other.jpg a', 'no photograph is called'),
        (['--geo'], 'EPSG:4326\nother.jpg -9.06 53.28', 'no photograph is called'),
        (['--clock-offset', '5', '--region'], '', '--clock-offset'),
    ],
)
def test_lists_of_another_place_are_refused(flight, tmp_path, capsys, arguments, text, says):
    """The command tells it in one line, without a traceback."""
    for shot in flight[:2]:
        (tmp_path / name_of(shot)).write_bytes(with_exif(shot.jpeg, shot.record))
    path = tmp_path / 'list.txt'
    path.write_text(text)
    assert main([str(tmp_path), *arguments, str(path)]) == EXIT_REFUSED
    errors = capsys.readouterr().err
    assert says in errors
    assert errors.count('\n') == 1


def test_control_points_that_contradict_each_other_forbid_to_trust_the_map(flight, tmp_path):
    """Pixels of another photograph: the map is made, but must not be called georeferenced."""
    lines = gcp_text(flight).splitlines()
    shuffled = [line.split('\t') for line in lines[1:]]
    labels = sorted({words[6] for words in shuffled})
    for words in shuffled:
        other = labels[(labels.index(words[6]) + 2) % len(labels)]
        east, north = POINTS[other]
        x, y = TO_UTM.transform(*place_of(3.0 * east, 3.0 * north))
        words[:2] = [f'{x:.3f}', f'{y:.3f}']
    path = tmp_path / 'gcp_list.txt'
    path.write_text('\n'.join([lines[0], *('\t'.join(words) for words in shuffled)]))
    shots = [(name_of(shot), shot.record, shot.jpeg) for shot in flight]
    maker, alignment, _ = aligned(shots, Survey(control=read_control(path, ignored)))
    reasons = violations(alignment, maker.block.state)
    assert [reason for reason in reasons if 'points are off by' in reason]
