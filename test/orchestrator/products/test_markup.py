# SPDX-License-Identifier: Apache-2.0
"""Whatever is no markup is escaped; whatever is written can be read back."""

import html
import json
from html.parser import HTMLParser

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_orchestrator.report.markup import Markup, element, join, json_block, number


class Parsed(HTMLParser):
    """The tags, attributes and text of a piece of HTML."""

    def __init__(self, source):
        super().__init__()
        self.tags = []
        self.texts = []
        self.feed(source)
        self.close()

    def handle_starttag(self, tag, attrs):
        """Note a tag."""
        self.tags.append((tag, dict(attrs)))

    def handle_data(self, data):
        """Note text."""
        self.texts.append(data)


# Readers of HTML take one kind of line end for another, and no NUL at all.
texts = st.text(st.characters(blacklist_characters='\r\x00', blacklist_categories=('Cs',)))


@given(texts)
def test_text_stays_text(text):
    """Whatever it holds, a text is one text in one element."""
    parsed = Parsed(element('p', text))
    assert [tag for tag, _ in parsed.tags] == ['p']
    assert ''.join(parsed.texts) == text


@given(texts)
def test_attribute_stays_attribute(text):
    """Whatever it holds, a value is the value of its attribute."""
    assert Parsed(element('p', title=text)).tags == [('p', {'title': text})]


@given(st.recursive(texts | st.integers() | st.none(), lambda inner: st.lists(inner)))
def test_data_block_cannot_end_early(value):
    """Data for the script holds no tag, and says what it was given."""
    block = json_block('data', value)
    inner = block.removeprefix('<script type="application/json" id="data">')
    inner = inner.removesuffix('</script>')
    assert '<' not in inner
    assert json.loads(inner) == value


def test_markup_is_not_escaped_again():
    """Elements nest, in lists too, and None leaves no trace."""
    inner = element('b', 'x & y')
    assert element('p', [inner, None, 'z']) == '<p><b>x &amp; y</b>z</p>'
    assert join([inner, 3]) == '<b>x &amp; y</b>3'
    assert isinstance(inner, Markup)


def test_attributes_are_named_as_html_names_them():
    """Reserved words, hyphens, flags and void elements."""
    assert element('input', class_='a', data_id=3, checked=True, disabled=False, title=None) == (
        '<input class="a" data-id="3" checked>'
    )


@pytest.mark.parametrize(
    ('value', 'text'), [(12.5, '12.5'), (-0.001, '0'), (100.0, '100'), (0.126, '0.13'), (7, '7')]
)
def test_coordinates_are_short(value, text):
    """No digit that says nothing."""
    assert number(value) == text


def test_not_a_number_is_refused():
    """JSON has none; a reader would stop."""
    with pytest.raises(ValueError, match='JSON'):
        json_block('data', float('nan'))


def test_escaping_agrees_with_the_standard_library():
    """A known answer."""
    assert element('p', '<a href="x">') == f'<p>{html.escape("<a href=", quote=False)}"x"&gt;</p>'
