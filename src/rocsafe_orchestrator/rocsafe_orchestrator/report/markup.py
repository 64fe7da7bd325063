# SPDX-License-Identifier: Apache-2.0
"""HTML and SVG built from elements, so that no text can be taken for markup.

Whatever is no `Markup` is escaped: names of scenarios, vehicles and sources are user input.
"""

import html
import json
from collections.abc import Iterable, Mapping
from typing import Any

Attribute = str | int | float | bool | None

_VOID = frozenset({'br', 'hr', 'img', 'input', 'link', 'meta'})
_COORDINATE_DIGITS = 2


class Markup(str):
    """Text that is HTML already."""

    __slots__ = ()


Content = Markup | str | int | None


def element(tag: str, *children: Content | Iterable[Content], **attributes: Attribute) -> Markup:
    """Return one element.

    Underscores in attribute names become hyphens, one at the end is dropped (``class_``,
    ``data_id``). None and False leave an attribute out, True gives it without a value.
    """
    opening = f'<{tag}{"".join(_attribute(name, value) for name, value in attributes.items())}>'
    if tag in _VOID:
        return Markup(opening)
    return Markup(f'{opening}{join(children)}</{tag}>')


def join(children: Iterable[Content | Iterable[Content]]) -> Markup:
    """Return `children` one after the other, escaped where they are plain text."""
    return Markup(''.join(_child(child) for child in children))


def json_block(identifier: str, value: Any) -> Markup:
    """Return `value` as an inert script element that the page's own script reads."""
    text = json.dumps(value, separators=(',', ':'), allow_nan=False)
    # Neither an end tag nor a comment can begin without "<".
    safe = text.replace('<', '\\u003c').replace('\u2028', '\\u2028').replace('\u2029', '\\u2029')
    return Markup(
        f'<script type="application/json" id="{html.escape(identifier)}">{safe}</script>'
    )


def number(value: float, digits: int = _COORDINATE_DIGITS) -> str:
    """Return `value` as short as SVG allows: 12.50 is 12.5, -0.00 is 0."""
    text = f'{value:.{digits}f}'
    text = text.rstrip('0').rstrip('.') if '.' in text else text
    return '0' if text == '-0' else text


def style(properties: Mapping[str, str]) -> str:
    """Return CSS properties as the value of a style attribute."""
    return ';'.join(f'{name}:{value}' for name, value in properties.items())


def _child(child: Content | Iterable[Content]) -> str:
    if child is None:
        return ''
    if isinstance(child, Markup):
        return child
    if isinstance(child, (str, int)):
        return html.escape(str(child), quote=False)
    return join(child)


def _attribute(name: str, value: Attribute) -> str:
    if value is None or value is False:
        return ''
    plain = name.rstrip('_').replace('_', '-')
    if value is True:
        return f' {plain}'
    text = number(value) if isinstance(value, float) else str(value)
    return f' {plain}="{html.escape(text)}"'
