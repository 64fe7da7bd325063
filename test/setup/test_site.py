# SPDX-License-Identifier: Apache-2.0
"""The documentation site: complete, without network, and spelled right."""

import os
import re
import shutil
import subprocess
import sys
import textwrap
from html import unescape
from pathlib import Path
from urllib.parse import unquote

import pytest

from documentation.scenario_keys import _models, _unit, scenario_page
from rocsafe_scenario.scenario_file import read_scenario

ROOT = Path(__file__).resolve().parents[2]
LIMIT_S = 240.0
FOLDERS = ('config', 'docs', 'examples', 'src', 'tools')
TEXTS = (
    'README.md',
    'CONTRIBUTING.md',
    'CHANGELOG.md',
    'docs',
    'examples',
    'src',
    'tools',
    'config',
)


@pytest.fixture(scope='module')
def site(tmp_path_factory):
    """The site, built with warnings as errors: a broken link or a page outside the menu fails."""
    pytest.importorskip('mkdocs', reason='no mkdocs: make setup installs it for development')
    folder = tmp_path_factory.mktemp('site')
    # With `-q`, mkdocs would not count its warnings, and would never fail.
    command = [sys.executable, '-m', 'mkdocs', 'build', '--strict', '-d', str(folder)]
    done = subprocess.run(
        command, cwd=ROOT, env={**os.environ, 'NO_MKDOCS_2_WARNING': '1'}, capture_output=True,
        text=True, timeout=LIMIT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout + done.stderr
    return folder


@pytest.mark.slow
def test_nothing_is_loaded_from_elsewhere(site):
    """No script, style, font or picture of another host."""
    for page in site.rglob('*.html'):
        text = page.read_text()
        foreign = re.findall(r'<(?:script|img|iframe)[^>]*src="https?:[^"]*"', text)
        styles = re.findall(r'<link[^>]*rel="(?:stylesheet|preconnect)"[^>]*https?:', text)
        assert foreign + styles == [], page


@pytest.mark.slow
def test_an_address_that_there_is_not_is_answered_by_a_page_that_leads_on(site):
    """In the style of the site, by addresses from its root: it is sent for any folder."""
    text = (site / '404.html').read_text()
    _, _, article = text.partition('<article')
    links = re.findall(r'href="(/[^"#]*)"', text)
    assert all((site / link.lstrip('/')).is_file() for link in links)
    assert any(link.endswith('site.css') for link in links)
    assert len(re.findall(r'<li><a href="/', article)) == 5


@pytest.mark.slow
def test_every_link_leads_to_a_file_and_a_heading_of_the_site(site):
    """Also those that mkdocs only remarks upon, such as files that begin with a dot."""
    texts = {page: page.read_text() for page in site.rglob('*.html') if page.name != '404.html'}
    places = {page: set(re.findall(r'\bid="?([^"\s>]+)', text)) for page, text in texts.items()}
    missing, seen = [], 0
    for page, text in texts.items():
        for link in set(re.findall(r'(?:href|src)="?([^"\s>]+)', text)):
            if re.match(r'(?:https?|mailto|javascript|data):', link):
                continue
            seen += 1
            path, _, place = unquote(unescape(link)).partition('#')
            target = (page.parent / path).resolve() if path else page
            target = target / 'index.html' if target.is_dir() else target
            found = target.is_file() and (not place or place in places.get(target, {place}))
            missing += [] if found else [f'{page.relative_to(site)}: {link}']
    assert missing == []
    assert seen > 1000


@pytest.mark.slow
def test_no_command_is_shown_as_a_line_of_text(site):
    """As one is that is indented below a list: it belongs to the last item there."""
    command = re.compile(r'<(?:p|li)>\s*((?:rocsafe|ros2|make|python3?|source) [^<]*--?\w[^<]*)<')
    found = {str(page): command.findall(page.read_text()) for page in site.rglob('*.html')}
    assert {name: lines for name, lines in found.items() if lines} == {}


@pytest.mark.slow
def test_every_page_of_the_menu_is_there_and_searchable(site):
    """The index of the search names it."""
    menu = re.findall(r': ([\w/-]+)\.md$', (ROOT / 'mkdocs.yml').read_text(), re.M)
    index = (site / 'search/search_index.js').read_text()
    assert [page for page in menu if not (site / f'{page}.html').exists()] == []
    assert [page for page in menu if f'"{page}.html' not in index] == []


@pytest.mark.slow
def test_functions_of_users_are_on_the_reference_pages(site):
    """With their parameters from the docstrings."""
    page = (site / 'reference/python/planning.html').read_text()
    assert 'id="rocsafe_planner.region_plan.plan_region"' in page
    assert 'Height of the camera above the ground' in page


@pytest.mark.all
def test_no_table_is_cut_off_on_paper(site):
    """Paper does not scroll: each table of each page is as narrow as a page of A4."""
    playwright = pytest.importorskip('playwright.sync_api', reason='playwright is not installed')
    chromium = shutil.which('chromium') or pytest.skip('no chromium on this machine')
    wide = """[...document.querySelectorAll('article table')]
        .filter(one => one.getBoundingClientRect().right > document.documentElement.clientWidth)
        .map(one => one.innerText.slice(0, 40))"""
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(executable_path=chromium, args=['--no-sandbox'])
        page = browser.new_page(viewport={'width': 794, 'height': 1123})
        page.emulate_media(media='print')
        cut = {}
        for path in site.rglob('*.html'):
            page.goto(path.as_uri())
            cut[path.name] = page.evaluate(wide)
        browser.close()
    assert {name: tables for name, tables in cut.items() if tables} == {}


def test_every_key_of_a_scenario_is_in_the_reference():
    """With a limit and a unit where the model has them."""
    text = scenario_page()
    for _, model in _models():
        assert [key for key in model.model_fields if f'| `{key}` |' not in text] == []
    assert '| `height_agl_m` | number | **required** | m | > 0, ≤ 500 |' in text
    assert "| `stability` | `A` or `B` or `C` or `D` or `E` or `F` | `'D'` |" in text


@pytest.mark.parametrize(
    ('key', 'unit'),
    [('acceleration_mps2', 'm/s²'), ('rate_g_s', 'g/s'), ('budget_s', 's'), ('grid', '')],
)
def test_the_longest_end_of_a_name_tells_the_unit(key, unit):
    """An acceleration is not a time."""
    assert _unit(key) == unit


def test_the_mission_of_the_tutorial_is_valid(tmp_path):
    """Region, scenario and additions of `Your own place`, as a reader copies them."""
    text = (ROOT / 'docs/tutorials/your-place.md').read_text()
    blocks = re.findall(r'^( *)```(\w+)\n(.*?)^ *```', text, re.M | re.S)
    (region,) = (body for _, kind, body in blocks if kind == 'json')
    first, *more = (textwrap.dedent(body) for _, kind, body in blocks if kind == 'yaml')
    (tmp_path / 'field.geojson').write_text(region)
    (tmp_path / 'my.yaml').write_text(first + ''.join(more))
    scenario = read_scenario(tmp_path / 'my.yaml')
    assert scenario.vehicle_names == ('rav1', 'rav2')
    assert scenario.radiation.sources


def test_spelling():
    """No known misspelling in documents; names of the field are in pyproject.toml."""
    typos = Path(sys.executable).parent / 'typos'
    if not typos.exists():
        pytest.skip('no typos: make setup installs it for development')
    done = subprocess.run(
        [typos, '--format', 'brief', *TEXTS], cwd=ROOT, capture_output=True, text=True,
        timeout=LIMIT_S, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stdout
