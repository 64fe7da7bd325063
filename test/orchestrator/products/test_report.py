# SPDX-License-Identifier: Apache-2.0
"""The report stands alone: one file, no network, nothing of the scenario taken for markup."""

import json
import re
import shutil
import sys
from html.parser import HTMLParser
from pathlib import Path

import pytest

from rocsafe_orchestrator.write_products import write_products

pytestmark = pytest.mark.slow

LARGEST_BYTES = 3_000_000
VOID = {'area', 'br', 'hr', 'img', 'input', 'link', 'meta'}


class Outline(HTMLParser):
    """Collects elements, and checks that they are nested."""

    def __init__(self, text):
        super().__init__()
        self.elements = []
        self.open = []
        self.text = []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        """Note an element."""
        self.elements.append((tag, dict(attrs)))
        if tag not in VOID:
            self.open.append(tag)

    def handle_endtag(self, tag):
        """Close the element that was opened last."""
        assert self.open.pop() == tag

    def handle_data(self, data):
        """Note text that is no script or style."""
        if self.open and self.open[-1] not in ('script', 'style'):
            self.text.append(data)

    def with_class(self, name):
        """Return the attributes of the elements of class `name`."""
        return [a for _, a in self.elements if name in a.get('class', '').split()]


@pytest.fixture(scope='module')
def finished(flown_run, tmp_path_factory):
    """A run with its products."""
    copy = tmp_path_factory.mktemp('finished') / flown_run.name
    shutil.copytree(flown_run, copy)
    write_products(copy)
    return copy


@pytest.fixture(scope='module')
def page(finished):
    """The text of the report."""
    return (finished / 'report.html').read_text(encoding='utf-8')


@pytest.fixture(scope='module')
def outline(page):
    """The elements of the report."""
    return Outline(page)


def test_report_names_no_host(page):
    """Nothing is loaded from, linked to or sent to anywhere."""
    without_pictures = re.sub(r'data:image/[a-z]+;base64,[A-Za-z0-9+/=]+', '', page)
    addresses = set(re.findall(r'(?:[a-z]+:)?//[\w.-]+\.\w+[^\s"\'<)]*', without_pictures))
    # The name of SVG's namespace, which nobody fetches.
    assert addresses <= {'http://www.w3.org/2000/svg'}


def test_report_forbids_itself_the_network(page, outline):
    """Should anything slip in, the policy of the page stops it."""
    policies = [a['content'] for tag, a in outline.elements if tag == 'meta' and 'content' in a]
    policy = next(text for text in policies if 'default-src' in text)
    assert "default-src 'none'" in policy
    assert 'unsafe-inline' not in policy.partition('script-src')[2].partition(';')[0]


def test_script_is_the_one_that_the_policy_allows(page):
    """A changed script would not run: its hash stands in the policy."""
    import base64
    import hashlib

    script = re.search(r'<script>(.*)</script>', page, re.DOTALL)[1]
    digest = base64.b64encode(hashlib.sha256(script.encode()).digest()).decode()
    assert f"script-src 'sha256-{digest}'" in page


def test_report_is_small_enough_to_mail(finished):
    """Pictures are scaled down to be embedded."""
    assert (finished / 'report.html').stat().st_size < LARGEST_BYTES


def test_names_of_the_scenario_are_text(page, outline):
    """A source called ``wreck <1>`` is no element."""
    assert 'wreck <1> (truth)' in outline.text
    assert 'wreck <1>' not in page
    assert not outline.open


def test_map_has_every_layer(outline):
    """Mosaic, region, routes, tracks, readings, photographs, truth and homes are drawn."""
    layers = {a['data-layer'] for a in outline.with_class('layer')}
    assert layers >= {'ground', 'region', 'routes', 'tracks', 'readings', 'photos', 'sources',
                      'homes', 'highest'}  # fmt: skip
    mosaics = [a for tag, a in outline.elements if tag == 'image' and 'transform' in a]
    assert len(mosaics) == 1
    assert len(outline.with_class('track')) == len(outline.with_class('route')) == 3


def test_the_plan_is_drawn_and_told(page, outline):
    """Exclusions, planned footprints, and what the plan promises are on the page."""
    assert len(outline.with_class('exclusion')) == 1
    planned = outline.with_class('survey-footprint')
    assert len(planned) == 3
    # A footprint is four corners, closed.
    assert all(path['d'].count('L') == 3 * path['d'].count('M') for path in planned)
    text = ' '.join(outline.text)
    assert 'longest time' in text
    assert 'by plan' in text


def test_mosaic_lies_where_it_belongs(finished, outline):
    """The picture's corners are those of the GeoTIFF, in metres east and south of the origin."""
    import numpy as np
    import rasterio
    from pyproj import Transformer

    from rocsafe_geo.frame import LocalFrame
    from rocsafe_scenario.scenario_file import read_scenario

    image = next(a for tag, a in outline.elements if tag == 'image')
    a, b, c, d, e, f = map(float, re.findall(r'-?[\d.]+(?:e-?\d+)?', image['transform']))
    width, height = float(image['width']), float(image['height'])
    drawn = np.array([(e, f), (a * width + c * height + e, b * width + d * height + f)])
    frame = LocalFrame(read_scenario(finished / 'scenario.yaml').origin_position())
    with rasterio.open(finished / 'mosaic.tif') as raster:
        left, bottom, right, top = raster.bounds
        to_wgs84 = Transformer.from_crs(raster.crs, 4326, always_xy=True)
    longitudes, latitudes = to_wgs84.transform([left, right], [top, bottom])
    enu = frame.to_enu(latitudes, longitudes, [frame.origin.altitude_m] * 2)
    # A map of 250 m is affine within a millimetre.
    assert np.abs(drawn - np.column_stack([enu[:, 0], -enu[:, 1]])).max() < 0.01


def test_payload_holds_every_reading_and_photograph(finished, page):
    """What can be selected on the map is what was recorded."""
    payload = json.loads(re.search(r'id="report-data">(.*?)</script>', page, re.DOTALL)[1])
    summary = json.loads((finished / 'summary.json').read_text(encoding='utf-8'))
    assert len(payload['readings']['d']) == summary['reading_count']
    assert len(payload['photos']) == summary['images_stored']


def test_footprint_of_a_photograph_is_the_ground_below_it(page):
    """At 32 m and 60 degrees the image's width shows 2 * 32 m * tan 30 deg = 36.95 m."""
    payload = json.loads(re.search(r'id="report-data">(.*?)</script>', page, re.DOTALL)[1])
    x, y, *_, footprint = payload['photos']['rav1-00000']
    corners = [tuple(map(float, pair.split(','))) for pair in footprint.split()]
    assert max(east for east, _ in corners) - x == pytest.approx(18.475, abs=0.15)
    assert y - min(south for _, south in corners) == pytest.approx(13.856, abs=0.15)


def test_everything_can_be_reached_by_keyboard(outline):
    """Buttons are buttons, and each has words."""
    for tag, attributes in outline.elements:
        assert 'onclick' not in attributes
        if tag == 'img':
            assert attributes['alt']
    assert next(a for t, a in outline.elements if 'map' in a.get('class', '').split())['tabindex']


@pytest.fixture
def unlocalized(monkeypatch):
    """Leave out the estimate of sources, which takes seconds and does not matter here."""
    module = sys.modules[write_products.__module__]
    monkeypatch.setattr(module, 'estimate_sources', lambda *_: None)


LOSSES = {
    'plan': ['plan.json'],
    'images': ['images'],
    'mosaic': ['mosaic.tif'],
    'scenario': ['scenario.yaml'],
    'recording': ['mission.part-0.mcap'],
    'run facts': ['run.json'],
    'everything': ['plan.json', 'images', 'mosaic.tif', 'scenario.yaml', 'mission.part-0.mcap',
                   'run.json'],
}  # fmt: skip


@pytest.mark.parametrize('lost', LOSSES.values(), ids=LOSSES)
def test_report_of_a_partial_run_tells_what_is_missing(flown_run, tmp_path, lost, unlocalized):
    """A run cut off anywhere still gives a report, and says what it lacks."""
    run = tmp_path / 'run'
    shutil.copytree(flown_run, run)
    for name in lost:
        path = run / name
        if path.is_dir():
            shutil.rmtree(path)
        else:
            path.unlink()
    summary = write_products(run)
    assert summary.missing
    outline = Outline((run / 'report.html').read_text(encoding='utf-8'))
    assert not outline.open
    assert outline.with_class('warning')
    assert 'nan' not in ' '.join(outline.text).lower().split()


@pytest.mark.parametrize('name', ['plan.json', 'run.json', 'scenario.yaml', 'mosaic.tif'])
def test_damaged_file_is_reported_not_fatal(flown_run, tmp_path, name, unlocalized):
    """A file full of rubbish counts as missing."""
    run = tmp_path / 'run'
    shutil.copytree(flown_run, run)
    (run / name).write_bytes(b'\x00rubbish{')
    assert any(name in line for line in write_products(run).missing)


def test_report_is_written_from_an_installed_package():
    """Templates, style and script are package data."""
    sources = Path(__file__).parents[3] / 'src'
    report = (sources / 'rocsafe_orchestrator/setup.py').read_text(encoding='utf-8')
    view = (sources / 'rocsafe_view/setup.py').read_text(encoding='utf-8')
    assert 'templates/*.html' in report
    assert all(f'*.{suffix}' in view for suffix in ('html', 'css', 'js'))
