# SPDX-License-Identifier: Apache-2.0
"""Definitions of interfaces as text, those of nested messages indented below their fields.

Comments of nested definitions are left out unless asked for. As in the real command, what is left
of a comment behind a field is its `#`, and a comment that holds only a unit in brackets stays.
"""

import re
from collections.abc import Iterator

from rocsafe_ros2cli.interfaces import interface_file

NUMBERS = (f'{kind}{bits}' for kind in ('int', 'uint') for bits in (8, 16, 32, 64))
PRIMITIVES = {'bool', 'byte', 'char', 'float32', 'float64', 'string', 'wstring', *NUMBERS}
FIELD = re.compile(
    r'(?P<type>[A-Za-z][\w/]*)(<=\d+)?(\[(<=)?\d*\])?\s+(?P<name>\w+)\s*(?P<rest>.*)'
)
UNIT = re.compile(r'\s*\[[^,\]]+\]')


def definition_lines(
    name: str, *, comments: bool, nested_comments: bool, depth: int = 0
) -> Iterator[str]:
    """Yield the lines of a definition.

    Parameters
    ----------
    name : str
        `package/kind/Name`.
    comments, nested_comments : bool
        Whether comments of this definition, and of those below it, are shown.
    depth : int
        How deep this definition is nested.

    Raises
    ------
    CommandError
        If an interface is not there.
    """
    path = interface_file(name)
    for raw in path.read_text(encoding='utf-8').splitlines():
        line = raw.rstrip()
        text = line if comments else _without_comment(line)
        if text or comments:
            yield '\t' * depth + text if text else ''
        nested = None if path.suffix == '.idl' else nested_type(line, name.split('/')[0])
        if nested is not None:
            yield from definition_lines(
                nested, comments=nested_comments, nested_comments=nested_comments, depth=depth + 1
            )


def nested_type(line: str, package: str) -> str | None:
    """Return the message that the field of this line holds; None if it holds none.

    Parameters
    ----------
    line : str
        One line of a definition.
    package : str
        Package of types named without one.
    """
    match = FIELD.fullmatch(line.partition('#')[0].strip())
    if match is None or match['rest'].startswith('=') or match['type'] in PRIMITIVES:
        return None
    owner, _, message = match['type'].rpartition('/')
    return f'{owner or package}/msg/{message}'


def _without_comment(line: str) -> str:
    """Return what is shown of a line without comments; empty: nothing."""
    definition, mark, rest = line.partition('#')
    comment = _comment_text(rest)
    if not mark or not comment:
        return line
    if not definition:
        return ''
    if not definition.strip():
        return line
    start = line.find(comment, len(definition))
    return (line[: start - 1] if start >= 0 else f'{definition}#').strip()


def _comment_text(rest: str) -> str:
    """Return what a comment says besides a unit."""
    units = UNIT.findall(rest)
    text = rest.replace(units[0], '') if len(units) == 1 else rest
    return text.lstrip('#').lstrip()
