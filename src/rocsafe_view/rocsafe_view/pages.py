# SPDX-License-Identifier: Apache-2.0
"""Pages from Jinja2 templates: one HTML file with its style and script, no network needed."""

import base64
import hashlib
import json
from importlib import resources
from typing import Any

from jinja2 import ChoiceLoader, Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from rocsafe_view import charts, formats, palette, svg


def render(template: str, package: str | None = None, **values: Any) -> str:
    """Return the page of `template` with `values`; every text is escaped.

    A page that extends ``page.html`` carries the shared style and script in itself, and a policy
    that allows this script only.

    Parameters
    ----------
    template
        File name in `package` or in this package.
    package
        Package with a folder ``templates`` that is searched first.
    """
    loaders = [PackageLoader(name) for name in (package, __package__) if name]
    environment = Environment(
        loader=ChoiceLoader(loaders),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.globals.update(charts=charts, formats=formats, palette=palette, static=_StaticFile)
    environment.filters.update(
        n=svg.number, polyline=svg.polyline, polygons=svg.polygons, json_text=json_text
    )
    return environment.get_template(template).render(values)


def json_text(value: Any) -> Markup:
    """Return `value` as JSON that a script element can hold.

    Raises
    ------
    ValueError
        If it holds a number that JSON cannot tell, such as NaN.
    """
    text = json.dumps(value, separators=(',', ':'), allow_nan=False)
    # Neither an end tag nor a comment can begin without "<".
    safe = text.replace('<', '\\u003c').replace('\u2028', '\\u2028').replace('\u2029', '\\u2029')
    return Markup(safe)  # noqa: S704 - nothing in it can end the element


class _StaticFile:
    """A style sheet or script of this package."""

    def __init__(self, name: str) -> None:
        folder = resources.files(__package__).joinpath('static')
        self._text = folder.joinpath(name).read_text(encoding='utf-8')

    @property
    def text(self) -> Markup:
        """Its content, written by this package."""
        return Markup(self._text)  # noqa: S704 - no input

    @property
    def policy_hash(self) -> str:
        """Its hash as a content security policy names it."""
        digest = hashlib.sha256(self._text.encode()).digest()
        return f'sha256-{base64.b64encode(digest).decode()}'
