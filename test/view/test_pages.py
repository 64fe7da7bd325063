# SPDX-License-Identifier: Apache-2.0
"""Pages escape every text, allow their own script alone, and hold data that can be read back."""

import json
import re
from html.parser import HTMLParser

import jinja2
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_view.pages import json_text, render
from rocsafe_view.svg import number, polygons, polyline

# Readers of HTML take one kind of line end for another, and no NUL at all.
texts = st.text(st.characters(blacklist_characters='\r\x00', blacklist_categories=('Cs',)))


class Parsed(HTMLParser):
    """Tags with attributes, and the text between them."""

    def __init__(self, source):
        super().__init__()
        self.tags, self.texts = [], []
        self.feed(source)
        self.close()

    def handle_starttag(self, tag, attrs):
        """Note a tag."""
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        """Note text."""
        self.texts.append(data)


@given(texts)
def test_data_block_cannot_end_early(text):
    """Data for the script holds no tag, and says what it was given."""
    held = json_text({'name': text})
    assert '<' not in held
    assert json.loads(held) == {'name': text}


def test_not_a_number_is_refused():
    """JSON has none; a reader would stop."""
    with pytest.raises(ValueError, match='JSON'):
        json_text(float('nan'))


def test_texts_stay_texts_in_every_page():
    """A name that looks like markup is neither an element nor the end of one."""
    name = '<b>"&\'</script>'
    page = Parsed(render('page.html', data={'name': name}))
    assert 'b' not in [tag for tag, _ in page.tags]
    held = next(text for text in page.texts if text.startswith('{"name"'))
    assert json.loads(held) == {'name': name}


def test_page_allows_its_own_script_and_no_network():
    """The policy names the hash of the script; everything else is refused."""
    policy = next(
        attributes['content']
        for tag, attributes in Parsed(render('page.html', data={})).tags
        if tag == 'meta' and 'default-src' in attributes.get('content', '')
    )
    assert policy.startswith("default-src 'none';")
    assert re.search(r"script-src 'sha256-[\w+/]+='", policy)


def test_missing_value_is_an_error():
    """A page with a hole in it is not written."""
    with pytest.raises(jinja2.UndefinedError, match='map'):
        render('map.html')


@pytest.mark.parametrize(
    ('value', 'text'), [(12.5, '12.5'), (-0.001, '0'), (100.0, '100'), (0.126, '0.13'), (7, '7')]
)
def test_coordinates_are_short(value, text):
    """No digit that says nothing."""
    assert number(value) == text


def test_paths_close_and_skip_what_repeats():
    """Points that round to the same decimetre are one; a single point is a dot."""
    assert polyline([(0.0, 0.0), (0.01, 0.0), (5.0, 2.25)]) == 'M0 0L5 2.2'
    assert polyline([(1.0, 1.0)]) == 'M1 1h0'
    assert polyline([]) == ''
    assert polygons([[(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)]]) == 'M0 0L1 0L0 1Z'
