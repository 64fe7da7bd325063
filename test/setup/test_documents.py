# SPDX-License-Identifier: Apache-2.0
"""The documents agree with the code."""

import re
from pathlib import Path

import pytest
from PIL import Image

ROOT = Path(__file__).resolve().parents[2]
DOCUMENTS = [*sorted(ROOT.glob('*.md')), *sorted((ROOT / 'docs').rglob('*.md'))]


def test_tables_are_current():
    """``make docs`` would change nothing."""
    pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
    import interface_tables

    text = interface_tables.DOCUMENT.read_text()
    assert interface_tables.with_tables(text) == text


@pytest.mark.parametrize('document', DOCUMENTS, ids=lambda path: path.name)
def test_named_targets_paths_and_links_exist(document):
    """Every make target, file and folder of this repository that is named exists."""
    text = document.read_text()
    targets = set(re.findall(r'^([a-z-]+):', (ROOT / 'Makefile').read_text(), re.M))
    assert set(re.findall(r'(?:`|^    |&& )make ([a-z-]+)', text, re.M)) <= targets
    paths = re.findall(r'`((?:src|config|test|benchmarks|requirements|tools)/[\w./-]*)`', text)
    assert [path for path in paths if not (ROOT / path).exists()] == []
    # Pages in reference/ are made from the code when the site is built.
    links = re.findall(r'\]\((?!https?:|#|(?:\.\./)?reference/)([^)#]+)', text)
    assert [link for link in links if not (document.parent / link).exists()] == []


@pytest.mark.parametrize('document', DOCUMENTS, ids=lambda path: path.name)
def test_links_to_headings_lead_to_one(document):
    """Of the same and of other documents, as the code host and the site make them."""
    pages = re.findall(r'\]\((?!https?:)([^)#]*\.md|)#([^)]+)\)', document.read_text())
    missing = [
        f'{page}#{heading}'
        for page, heading in pages
        if heading not in headings(document.parent / page if page else document)
    ]
    assert missing == []


def headings(document):
    """Return the anchors of the headings of a document."""
    lines = re.findall(r'^#+ (.*)$', document.read_text(), re.M)
    return {re.sub(r'[^\w\s-]', '', line).strip().lower().replace(' ', '-') for line in lines}


def test_every_document_is_in_the_menu_of_the_site():
    """`make site` would fail without."""
    menu = (ROOT / 'mkdocs.yml').read_text().partition('nav:')[2]
    pages = [str(path.relative_to(ROOT / 'docs')) for path in (ROOT / 'docs').rglob('*.md')]
    assert [page for page in pages if f' {page}\n' not in menu] == []


def test_readme_is_short_and_says_what_has_not_flown():
    """At most 120 lines; a reader must not believe that hardware was flown."""
    text = (ROOT / 'README.md').read_text()
    assert len(text.splitlines()) <= 120
    assert 'No hardware has been flown' in text


def test_the_pictures_of_the_readme_move_and_are_small():
    """A mission, the console and a scene; together below 3 MB."""
    text = (ROOT / 'README.md').read_text()
    pictures = [ROOT / name for name in re.findall(r'!\[[^]]*\]\(([^)]+)\)', text)]
    assert len(pictures) == 3
    for path in pictures:
        with Image.open(path) as picture:
            assert picture.n_frames > 20
    assert sum(path.stat().st_size for path in pictures) < 3e6


def test_exit_codes_are_those_of_the_command():
    """The table of exit codes has every code of ``rocsafe --help``."""
    from rocsafe_orchestrator.cli import EPILOG

    told = set(re.findall(r'\b(\d+)\b', EPILOG.split('exit codes:')[1]))
    commands = (ROOT / 'docs/commands.md').read_text()
    table = commands.split('| exit code | means |')[1].split('\n\n')[0]
    first_columns = ' '.join(re.findall(r'^\| ([\d, ]+) \|', table, re.M))
    assert set(re.findall(r'\d+', first_columns)) == told
