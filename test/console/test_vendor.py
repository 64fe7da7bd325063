# SPDX-License-Identifier: Apache-2.0
"""What the page is made of: its own files and libraries that are as released, no other host."""

import gzip
import hashlib
import json
import re

import pytest

from rocsafe_console.picture import frame_bytes
from rocsafe_console.picture.vehicle import STATE_NAMES
from rocsafe_console.web.server import STATIC, VIEW
from rocsafe_view.palette import VEHICLE_COLOURS

OWN = [path for path in STATIC.iterdir() if path.is_file()]
SCRIPTS = sorted(path for path in OWN if path.suffix == '.js')


def test_libraries_are_as_released():
    """Each file of static/vendor by its hash, with version, licence and origin."""
    manifest = json.loads((STATIC / 'vendor' / 'manifest.json').read_text())
    files = {
        str(path.relative_to(STATIC / 'vendor')): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in (STATIC / 'vendor').rglob('*')
        if path.is_file() and path.name != 'manifest.json'
    }
    assert files == {name: sha for one in manifest.values() for name, sha in one['files'].items()}
    for one in manifest.values():
        assert one['version']
        assert one['origin']
        assert one['licence'] == 'BSD-2-Clause'


@pytest.mark.parametrize('path', OWN, ids=lambda path: path.name)
def test_no_file_of_the_page_names_another_host(path):
    """Neither scheme nor //host; namespaces of SVG are names and not addresses."""
    text = path.read_text().replace('http://www.w3.org/2000/svg', '')
    assert not re.search(r'https?://|[\'"(]//\w', text)
    assert '<style' not in text
    assert ' style="' not in text
    assert not re.search(r'\son\w+="', text)
    assert 'innerHTML' not in text


def test_every_text_is_in_the_catalogue_and_is_used():
    """A key without a text would end the page; a text without use rots."""
    catalogue = set(re.findall(r"(?:^|[{,]\s*)(\w+): '", (STATIC / 'texts.js').read_text(), re.M))
    used = ''.join(path.read_text() for path in OWN if path.name != 'texts.js')
    named = set(re.findall(r"\bt\('(\w+)'", used)) | set(
        re.findall(r'data-(?:text|label|hint)="(\w+)"', used)
    )
    assert named - catalogue == set()
    prefixes = (*re.findall(r'\bt\(`(\w+_)\$\{', used), 'trend_')
    bare = {'critical', 'warning', 'theme_dark', 'theme_light', 'sound_on', 'sound_off'}
    choices = set(re.findall(r"'(\w+)'", used))
    unused = {k for k in catalogue - named - bare - choices if not k.startswith(prefixes)}
    assert unused == set()


def test_the_page_reads_frames_as_they_are_written():
    """Sizes and the letter; offsets are those of the module's text."""
    text = (STATIC / 'link.js').read_text()
    assert f'HEAD_BYTES = {frame_bytes.HEAD.size}' in text
    assert f'VEHICLE_BYTES = {frame_bytes.VEHICLE.size}' in text
    offsets = [int(n) for n in re.findall(r'get\w+\(at \+ (\d+)', text)]
    assert offsets == [2, 3, 4, 8, 12, 14, 16, 17, 18, 20]


def test_the_page_has_the_colours_and_states_of_the_report():
    """One palette; every state has a text."""
    colours = re.search(r'VEHICLE_COLOURS = \[(.*?)\]', (STATIC / 'map.js').read_text())
    assert tuple(re.findall(r"'(#\w+)'", colours[1])) == VEHICLE_COLOURS
    states = re.search(r'const STATES = \[(.*?)\]', (STATIC / 'facts.js').read_text())
    names = [name.replace('_', ' ') for name in re.findall(r"'(\w+)'", states[1])]
    assert tuple(names) == STATE_NAMES


def test_the_page_is_small():
    """250 kB with compression, without tiles."""
    files = [
        *OWN,
        *(STATIC / 'vendor').rglob('*.js'),
        *(STATIC / 'vendor').rglob('*.css'),
        VIEW / 'tokens.css',
    ]
    assert sum(len(gzip.compress(path.read_bytes())) for path in files) < 250_000
