# SPDX-License-Identifier: Apache-2.0
"""Nested settings of a node from one YAML file, checked against dataclasses.

A node that wants sources, cameras or drones is given a file by one parameter. The file is read
into a frozen dataclass whose field types say what is allowed: other dataclasses, ``float``,
``int``, ``bool``, ``str``, ``datetime``, an ``Enum``, ``Literal[...]``, ``X | None``,
``tuple[X, ...]`` and ``tuple[X, Y]``. A dataclass checks its own values in ``__post_init__``.
Needs no pydantic.
"""

import dataclasses
import difflib
import types
import typing
from collections.abc import Iterator, Mapping
from datetime import date, datetime, timezone
from enum import Enum
from pathlib import Path
from typing import Any, Literal, TypeVar

from rocsafe_geo.storage.yaml_source import YamlError, read_yaml

T = TypeVar('T')
LONGEST_VALUE = 60


class ValueFileError(ValueError):
    """A file of settings is wrong; one line for each mistake."""


class _Mistakes(Exception):  # noqa: N818 - a list of lines on its way up, not a fault of its own
    def __init__(self, *lines: str) -> None:
        super().__init__(*lines)
        self.lines = lines


def read_values(path: Path, kind: type[T]) -> T:
    """Return the settings in the YAML file at `path` as a `kind`, a dataclass.

    Raises
    ------
    ValueFileError
        With one line for each mistake, such as
        ``field.yaml: sources[1].height_m = 'low': must be a number``.
    """
    try:
        content = read_yaml(path)
    except YamlError as error:
        raise ValueFileError(str(error)) from error
    return values_of(content, kind, path.name)


def values_of(content: object, kind: type[T], name: str) -> T:
    """Return `content`, as read from a YAML file, as a `kind`.

    Raises
    ------
    ValueFileError
        As `read_values`.
    """
    try:
        return typing.cast('T', _block('', {} if content is None else content, kind))
    except _Mistakes as mistakes:
        raise ValueFileError('\n'.join(f'{name}: {line}' for line in mistakes.lines)) from None


def _block(path: str, content: object, kind: type) -> object:
    """Return a mapping as the dataclass `kind`."""
    if not isinstance(content, Mapping):
        raise _Mistakes(_line(path, content, 'must be a block of keys'))
    types_of = typing.get_type_hints(kind)
    fields = {each.name: each for each in dataclasses.fields(kind) if each.init}
    lines, values = list(_unknown_keys(path, content, list(fields))), {}
    for name, each in fields.items():
        place = f'{path}.{name}'.removeprefix('.')
        try:
            if name in content:
                values[name] = _value(place, content[name], types_of[name])
            elif _is_required(each):
                lines.append(f'{place}: is missing')
        except _Mistakes as mistakes:
            lines.extend(mistakes.lines)
    if lines:
        raise _Mistakes(*lines)
    try:
        return kind(**values)
    except ValueError as error:
        raise _Mistakes(f'{path}: {error}' if path else str(error)) from error


def _is_required(each: 'dataclasses.Field[Any]') -> bool:
    return each.default is dataclasses.MISSING and each.default_factory is dataclasses.MISSING


def _unknown_keys(path: str, content: Mapping[Any, Any], known: list[str]) -> Iterator[str]:
    for key in content:
        if key in known:
            continue
        near = difflib.get_close_matches(str(key), known, n=1)
        hint = f'did you mean {near[0]}?' if near else f'known: {", ".join(known)}'
        yield f'{f"{path}.{key}".removeprefix(".")}: unknown key ({hint})'


def _value(path: str, content: object, kind: Any) -> object:
    """Return `content` as `kind`; whole numbers serve as floats, nothing else is converted."""
    origin = typing.get_origin(kind)
    if origin in (typing.Union, types.UnionType):
        inner = [each for each in typing.get_args(kind) if each is not types.NoneType]
        return None if content is None else _value(path, content, inner[0])
    if origin is Literal:
        return _choice(path, content, typing.get_args(kind))
    if origin is tuple:
        return _list(path, content, typing.get_args(kind))
    if dataclasses.is_dataclass(kind):
        return _block(path, content, typing.cast('type', kind))
    return _single(path, content, kind)


def _choice(path: str, content: object, choices: tuple[object, ...]) -> object:
    if content not in choices:
        raise _Mistakes(_line(path, content, f'must be one of: {", ".join(map(str, choices))}'))
    return content


def _list(path: str, content: object, kinds: tuple[Any, ...]) -> tuple[object, ...]:
    if not isinstance(content, tuple | list):
        raise _Mistakes(_line(path, content, 'must be a list'))
    is_open = len(kinds) == 2 and kinds[1] is Ellipsis
    wanted = [kinds[0]] * len(content) if is_open else list(kinds)
    if len(wanted) != len(content):
        raise _Mistakes(f'{path}: must have {len(wanted)} entries, has {len(content)}')
    values: list[object] = []
    lines: list[str] = []
    for index, (each, kind) in enumerate(zip(content, wanted, strict=True)):
        try:
            values.append(_value(f'{path}[{index}]', each, kind))
        except _Mistakes as mistakes:
            lines.extend(mistakes.lines)
    if lines:
        raise _Mistakes(*lines)
    return tuple(values)


_NAMES = {float: 'a number', int: 'a whole number', bool: 'true or false', str: 'a text'}


def _single(path: str, content: object, kind: type) -> object:
    if kind is float and isinstance(content, int) and not isinstance(content, bool):
        try:
            return float(content)
        except OverflowError:
            raise _Mistakes(f'{path}: must be a number below 1.8e308') from None
    if kind is datetime:
        return _moment(path, content)
    if kind is str and isinstance(content, date):
        # YAML makes a time of a text that looks like one.
        return content.isoformat()
    if issubclass(kind, Enum):
        return kind(_choice(path, content, tuple(each.value for each in kind)))
    if type(content) is not kind:
        raise _Mistakes(_line(path, content, f'must be {_NAMES.get(kind, kind.__name__)}'))
    return content


def _moment(path: str, content: object) -> datetime:
    """Return a time as one with a time zone; UTC where none is given."""
    try:
        moment = content if isinstance(content, datetime) else datetime.fromisoformat(content)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        text = 'must be a time such as 2026-03-04T10:00:00+00:00'
        raise _Mistakes(_line(path, content, text)) from None
    return moment if moment.tzinfo else moment.replace(tzinfo=timezone.utc)


def _line(path: str, content: object, limit: str) -> str:
    if isinstance(content, Mapping):
        return f'{path or "file"}: {limit}'
    text = repr(list(content) if isinstance(content, tuple) else content)
    short = text if len(text) <= LONGEST_VALUE else f'{text[: LONGEST_VALUE - 3]}...'
    return f'{path} = {short}: {limit}' if path else f'file = {short}: {limit}'
