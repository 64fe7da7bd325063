# SPDX-License-Identifier: Apache-2.0
"""Interface types by name: their Python classes and their definitions as text."""

import importlib
import re
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from ament_index_python import has_resource

from rocsafe_ros2cli.command import CommandError

PARTS = {
    'msg': ('SLOT_TYPES',),
    'srv': ('Request', 'Response'),
    'action': ('Goal', 'Result', 'Feedback'),
}
"""Attributes that the classes of each kind of interface have."""

NUMBERS = (f'{kind}{bits}' for kind in ('int', 'uint') for bits in (8, 16, 32, 64))
PRIMITIVES = {'bool', 'byte', 'char', 'float32', 'float64', 'string', 'wstring', *NUMBERS}
FIELD = re.compile(
    r'(?P<type>[A-Za-z][\w/]*)(<=\d+)?(\[(<=)?\d*\])?\s+(?P<name>\w+)\s*(?P<rest>.*)'
)
UNIT = re.compile(r'\s*\[[^,\]]+\]')


def interface_class(name: str, kind: str, complaint: str, other_kind: str = '') -> Any:
    """Return the class of an interface.

    Parameters
    ----------
    name
        `package/Name` or `package/kind/Name`.
    kind
        `msg`, `srv` or `action`.
    complaint
        Error text if there is no such interface.
    other_kind
        Error text if it is an interface of another kind; empty: the same.

    Raises
    ------
    CommandError
        With `complaint` or `other_kind`.
    """
    *folders, last = name.split('/')
    if len(folders) == 1:
        folders.append(kind)
    try:
        found = getattr(importlib.import_module('.'.join(folders)), last)
    except (AttributeError, ModuleNotFoundError, ValueError) as error:
        raise CommandError(complaint) from error
    if not all(hasattr(found, part) for part in PARTS[kind]):
        raise CommandError(other_kind or complaint)
    return found


def message_class(name: str) -> Any:
    """Return the class of a message."""
    return interface_class(name, 'msg', 'The passed message type is invalid')


def definition_lines(name: str, *, comments: bool = True, depth: int = 0) -> Iterator[str]:
    """Yield the definition of `package/kind/Name`, nested messages indented below their fields.

    As in the real command, nested definitions have no comments. What is left of a comment behind
    a field is its `#`, and a comment that holds only a unit in brackets stays.

    Raises
    ------
    CommandError
        If an interface does not exist.
    """
    path = _interface_file(name)
    for raw in path.read_text(encoding='utf-8').splitlines():
        line = raw.rstrip()
        text = line if comments else _without_comment(line)
        if text or comments:
            yield '\t' * depth + text if text else ''
        nested = None if path.suffix == '.idl' else nested_type(line, name.split('/')[0])
        if nested is not None:
            yield from definition_lines(nested, comments=False, depth=depth + 1)


def nested_type(line: str, package: str) -> str | None:
    """Return the message type of the field in this line; None if it holds no message.

    Parameters
    ----------
    line
        One line of a definition.
    package
        Package of types that are named without one.
    """
    match = FIELD.fullmatch(line.partition('#')[0].strip())
    if match is None or match['rest'].startswith('=') or match['type'] in PRIMITIVES:
        return None
    owner, _, message = match['type'].rpartition('/')
    return f'{owner or package}/msg/{message}'


def _without_comment(line: str) -> str:
    """Return the line as it is shown without comments; empty: not at all."""
    definition, mark, rest = line.partition('#')
    units = UNIT.findall(rest)
    comment = (rest.replace(units[0], '') if len(units) == 1 else rest).lstrip('#').lstrip()
    if not mark or not comment:
        return line
    if not definition:
        return ''
    if not definition.strip():
        return line
    start = line.find(comment, len(definition))
    return (line[: start - 1] if start >= 0 else f'{definition}#').strip()


def _interface_file(name: str) -> Path:
    """Return the file that defines the interface `package/kind/Name`."""
    parts = name.split('/')
    if len(parts) != 3:
        raise CommandError(f"Invalid name '{name}'. Expected three parts separated by '/'")
    if not all(parts):
        raise CommandError(f"Invalid name '{name}'. Must not contain empty parts")
    if '..' in parts:
        raise CommandError(f"Invalid name '{name}'. Must not contain '..'")
    package, kind, _ = parts
    prefix = has_resource('packages', package)
    if not prefix:
        raise CommandError(f"Unknown package '{package}'")
    stem = Path(prefix) / 'share' / name
    candidates = [stem.with_name(stem.name + suffix) for suffix in (f'.{kind}', '.idl')]
    for candidate in candidates:
        if candidate.exists():
            return candidate
    raise CommandError(f"Could not find the interface '{candidates[-1]}'")
