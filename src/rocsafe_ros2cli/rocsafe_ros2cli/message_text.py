# SPDX-License-Identifier: Apache-2.0
"""Messages as YAML text, with long fields cut short."""

import array
import sys
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
import yaml
from rosidl_parser.definition import AbstractString, AbstractWString, Array, BasicType

SEQUENCES = (list, tuple, array.array, np.ndarray)
ELLIPSIS = '...'


@dataclass(frozen=True, slots=True, kw_only=True)
class TextStyle:
    """How much of a message is shown.

    Attributes
    ----------
    truncate_length
        Longest array, string or byte string that is shown whole; None: no limit.
    show_arrays
        False: their type and length are shown instead.
    """

    truncate_length: int | None = None
    show_arrays: bool = True

    def is_too_long(self, length: int) -> bool:
        """Return whether something of this length is cut."""
        return self.truncate_length is not None and length > self.truncate_length


WHOLE = TextStyle()


def yaml_text(message: Any, style: TextStyle = WHOLE) -> str:
    """Return the message as a YAML mapping, fields in the order of their definition."""
    return yaml.dump(
        _mapping(message, style),
        Dumper=yaml.SafeDumper,
        allow_unicode=True,
        width=sys.maxsize,
        default_flow_style=False,
        sort_keys=False,
    )


def _fields(message: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield name, value and slot type of each field."""
    names = message.get_fields_and_field_types()
    for name, slot in zip(names, message.SLOT_TYPES, strict=True):
        yield name, getattr(message, name), slot


def _mapping(message: Any, style: TextStyle) -> dict[str, Any]:
    """Return the message in types that YAML knows."""
    return {name: _plain(value, slot, style) for name, value, slot in _fields(message)}


def _plain(value: Any, slot: Any, style: TextStyle) -> Any:
    """Return one value in types that YAML knows; `slot` is None inside an array."""
    if isinstance(value, bytes):
        return _cut(value.decode('latin-1'), style)
    if isinstance(value, str):
        return _cut(value, style)
    if isinstance(value, SEQUENCES):
        return _plain_sequence(value, slot, style)
    if isinstance(value, np.number):
        return value.item()
    if isinstance(value, bool | float | int):
        return value
    return _mapping(value, style)


def _plain_sequence(values: Any, slot: Any, style: TextStyle) -> Any:
    """Return a sequence as a list, or its type and length as text."""
    if slot is not None and not style.show_arrays:
        return _array_label(values, slot)
    plain = [_plain(value, None, style) for value in values[: style.truncate_length]]
    return [*plain, ELLIPSIS] if style.is_too_long(len(values)) else plain


def _cut(text: str, style: TextStyle) -> str:
    """Return the text, its end replaced by dots if it is too long."""
    return text[: style.truncate_length] + ELLIPSIS if style.is_too_long(len(text)) else text


def _array_label(values: Any, slot: Any) -> str:
    """Return type and length of an array that is not shown."""
    name = _type_name(slot.value_type)
    if isinstance(slot, Array):
        return f'<array type: {name}[{slot.size}]>'
    bound = f'[{slot.maximum_size}]' if hasattr(slot, 'maximum_size') else ''
    return f'<sequence type: {name}{bound}, length: {len(values)}>'


def _type_name(value_type: Any) -> str:
    """Return the name of the type of the elements of an array."""
    if isinstance(value_type, BasicType):
        return str(value_type.typename)
    if isinstance(value_type, AbstractString):
        return 'string'
    if isinstance(value_type, AbstractWString):
        return 'wstring'
    return '/'.join(value_type.namespaced_name())
