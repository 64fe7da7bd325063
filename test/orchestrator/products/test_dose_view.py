# SPDX-License-Identifier: Apache-2.0
"""The report draws the dose map where it lies, with cordons, stay times and sources."""

import dataclasses
import json
import re

import numpy as np
import pytest
import rasterio
from rasterio.transform import from_origin

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.products.source_estimates import SourceEstimate, SourceEstimates
from rocsafe_orchestrator.report.dose_view import dose_view
from rocsafe_orchestrator.report.run_facts import estimate_facts
from rocsafe_view.formats import latitude_longitude
from rocsafe_view.pages import render

ORIGIN = GeoPosition(53.28, -9.06, 66.0)
# The map's own origin lies 30 m east and 20 m north of the mission's.
MAP_ORIGIN = LocalFrame(ORIGIN).position_of([30.0, 20.0, 0.0])


@pytest.fixture
def folder(tmp_path):
    """Give a folder with a map of 40 x 30 m and a cordon about its middle."""
    values = np.full((30, 40), 0.1)
    values[15, 20] = 5000.0
    crs = (
        f'+proj=tmerc +lat_0={MAP_ORIGIN.latitude_deg!r} +lon_0={MAP_ORIGIN.longitude_deg!r} '
        '+k=1 +x_0=0 +y_0=0 +ellps=WGS84 +units=m'
    )
    with rasterio.open(
        tmp_path / 'dose_map.tif', 'w', driver='GTiff', width=40, height=30, count=3,
        dtype='float32', crs=crs, transform=from_origin(-20.0, 15.0, 1.0, 1.0),
    ) as raster:  # fmt: skip
        for band, factor in ((1, 1.0), (2, 0.1), (3, 1.2)):
            raster.write((values * factor).astype(np.float32), band)
    frame = LocalFrame(MAP_ORIGIN)
    ring = [frame.position_of([x, y, 0.0]) for x, y in ((-5, -5), (5, -5), (0, 5), (-5, -5))]
    cordon = {
        'type': 'Feature',
        'geometry': {
            'type': 'MultiPolygon',
            'coordinates': [[[[p.longitude_deg, p.latitude_deg] for p in ring]]],
        },
        'properties': {
            'level_usv_h': 100.0, 'confidence': 'mean', 'area_m2': 50.0,
            'name': 'inner cordon <IAEA>',
            'stay_time_h': {'public_year_1_msv': 10.0, 'worker_year_20_msv': 200.0},
        },
    }  # fmt: skip
    (tmp_path / 'cordons.geojson').write_text(json.dumps({'features': [cordon]}))
    return tmp_path


def estimates():
    """Return one source at the middle of the map."""
    return SourceEstimates(
        sources=(
            SourceEstimate(
                position=MAP_ORIGIN,
                ellipse_95_m=(3.0, 2.0),
                ellipse_angle_from_east_deg=30.0,
                dose_rate_at_1m_usvh=5000.0,
                dose_rate_at_1m_95_usvh=(4000.0, 6000.0),
            ),
        ),
        source_count_probability=(0.0, 0.99, 0.01),
        background_usvh=0.1,
        reading_count=441,
        is_enough=True,
        verdict='1 source, placed within 3.0 m (95 %)',
        doubts=('the background is uneven', 'a < b'),
    )


def section(folder):
    """Return the section of the report."""
    view = dose_view(folder, LocalFrame(ORIGIN), estimates())
    return render('dose.html', 'rocsafe_orchestrator.report', dose=view)


def test_a_source_that_may_not_be_there_is_given_no_more_than_its_chance():
    """That of the second is that there are two."""
    found = dataclasses.replace(estimates(), source_count_probability=(0.0, 0.4, 0.5, 0.1))
    assert [round(found.probability_of(number), 6) for number in (1, 2, 3)] == [1.0, 0.6, 0.1]


def test_map_cordon_and_source_lie_where_they_are(folder):
    """In metres of the mission's frame, whatever the frame of the file."""
    page = section(folder)
    image = re.search(r'<image [^>]*x="([-\d.]+)" y="([-\d.]+)" width="([\d.]+)"', page)
    west, top, width = map(float, image.groups())
    assert (west, top, width) == pytest.approx((10.0, -35.0, 40.0), abs=0.02)
    (start,) = re.findall(r'<path d="M([-\d.]+) ([-\d.]+)L[^"]*" class="cordon"', page)
    assert tuple(map(float, start)) == pytest.approx((25.0, -15.0), abs=0.1)
    (mark,) = set(re.findall(r'translate\(([-\d.]+) ([-\d.]+)\)', page))
    assert tuple(map(float, mark)) == pytest.approx((30.0, -20.0), abs=0.02)
    assert page.count('<figure') == 2


def test_tables_say_how_long_one_may_stay_and_what_was_found(folder):
    """With names escaped, the verdict, and the strength with its interval."""
    page = section(folder)
    text = plain(re.sub(r'<[^>]+>', ' ', page))
    assert 'inner cordon &lt;IAEA&gt;' in page
    assert '10 h' in text
    assert '8.3 d' in text
    assert '4.00 mSv/h to 6.00 mSv/h' in text
    assert 'The evidence is enough: 1 source, placed within 3.0 m (95 %).' in text
    assert 'over 99.9 %' in text.split('Sources found')[1].split('Cordons')[0]
    assert 'Not as assumed: the background is uneven; a &lt; b.' in text


def test_facts_and_table_tell_a_source_alike(folder):
    """Its place, its ellipse and its strength are the same words in both."""
    (_, chances), (name, fact) = estimate_facts(estimates())
    assert (name, plain(chances)) == ('Source 1', '0: below 0.1 %, 1: 99.0 %, 2: 1 %')
    page = section(folder)
    words = '5.00 mSv/h (4.00 mSv/h to 6.00 mSv/h)', '3 × 2 m'
    assert all(part in plain(fact) and part in plain(page) for part in words)
    assert fact.startswith(latitude_longitude(MAP_ORIGIN.latitude_deg, MAP_ORIGIN.longitude_deg))


def plain(text):
    """Return text with plain spaces."""
    return text.replace('\u202f', ' ').replace('\xa0', ' ')


def test_without_a_map_there_is_no_section(folder, tmp_path):
    """Nor without estimates or a frame; without cordons there is a map still."""
    frame = LocalFrame(ORIGIN)
    assert dose_view(tmp_path / 'none', frame, estimates()) is None
    assert dose_view(folder, None, estimates()) is None
    assert dose_view(folder, frame, None) is None
    (folder / 'cordons.geojson').write_text('{')
    assert dose_view(folder, frame, estimates()).cordon_rows == []


def test_map_and_readings_have_one_scale(folder):
    """A colour means one dose rate on the whole page, and readings still differ in colour."""
    frame = LocalFrame(ORIGIN)
    view = dose_view(folder, frame, estimates(), [5.0, 20.0, 94.0])
    assert view.scale.low_usvh == 5.0
    assert view.scale.high_usvh == 1000.0
    assert view.scale.fraction(94.0) - view.scale.fraction(5.0) > 0.5
    assert dose_view(folder, frame, estimates()).scale.low_usvh <= 0.5
