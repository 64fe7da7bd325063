# SPDX-License-Identifier: Apache-2.0
"""Messages as text: YAML and comma-separated values, long fields cut short."""

import array
import sys
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from itertools import dropwhile
from typing import Any

import numpy as np
import yaml
from rosidl_parser.definition import (
    AbstractString,
    AbstractWString,
    Array,
    BasicType,
    BoundedSequence,
    NamedType,
    NamespacedType,
    UnboundedSequence,
)

SEQUENCES = (list, tuple, array.array, np.ndarray)
ELLIPSIS = '...'


@dataclass(frozen=True, slots=True, kw_only=True)
class TextStyle:
    """How much of a message is shown.

    Attributes
    ----------
    truncate_length
        Longest array, string or byte string shown whole; None: all are.
    show_arrays, show_strings
        False: their type and length stand for them.
    flow_style
        Arrays on one line.
    """

    truncate_length: int | None = None
    show_arrays: bool = True
    show_strings: bool = True
    flow_style: bool = False

    def is_too_long(self, length: int) -> bool:
        """Return whether something of this length is cut."""
        return self.truncate_length is not None and length > self.truncate_length


WHOLE = TextStyle()


class _MessageDumper(yaml.SafeDumper):
    """Writes messages as blocks in any style: the flow style is for arrays."""

    def represent_mapping(self, tag: str, mapping: Any, flow_style: bool | None = False) -> Any:
        """Return the node of a message."""
        return super().represent_mapping(tag, mapping, flow_style=flow_style)


def yaml_text(message: Any, style: TextStyle = WHOLE) -> str:
    """Return the message as a YAML mapping, fields in the order of their definition."""
    return str(
        yaml.dump(
            _mapping(message, style),
            Dumper=_MessageDumper,
            allow_unicode=True,
            width=sys.maxsize,
            default_flow_style=style.flow_style,
            sort_keys=False,
        )
    )


def csv_text(message: Any, style: TextStyle = WHOLE) -> str:
    """Return the fields of the message and of all messages in it, separated by commas."""
    return _joined(_csv_value(value, slot, style) for _, value, slot in _fields(message))


def _fields(message: Any) -> Iterator[tuple[str, Any, Any]]:
    """Yield name, value and slot type of each field."""
    names = message.get_fields_and_field_types()
    for name, slot in zip(names, message.SLOT_TYPES, strict=True):
        yield name, getattr(message, name), slot


def _mapping(message: Any, style: TextStyle) -> dict[str, Any]:
    """Return the message in terms that YAML knows."""
    return {name: _plain(value, slot, style) for name, value, slot in _fields(message)}


def _plain(value: Any, slot: Any, style: TextStyle) -> Any:
    """Return one value in terms that YAML knows; `slot` is None inside an array."""
    if isinstance(value, bytes):
        return _cut(value.decode('latin-1'), style)
    if isinstance(value, str):
        return _cut(value, style) if style.show_strings else _string_label(value)
    if isinstance(value, SEQUENCES):
        return _plain_sequence(value, slot, style)
    if isinstance(value, np.number):
        return value.item()
    if isinstance(value, bool | float | int):
        return value
    return _mapping(value, style)


def _plain_sequence(values: Any, slot: Any, style: TextStyle) -> Any:
    """Return a sequence as a list, or the label that stands for it."""
    if slot is not None and not style.show_arrays:
        return _array_label(values, slot)
    plain = [_plain(value, None, style) for value in values[: style.truncate_length]]
    return [*plain, ELLIPSIS] if style.is_too_long(len(values)) else plain


def _csv_value(value: Any, slot: Any, style: TextStyle) -> str:
    """Return one value as comma-separated text; `slot` is None inside an array."""
    if isinstance(value, SEQUENCES):
        return _csv_sequence(value, slot, style)
    if isinstance(value, str):
        return _cut(value, style) if style.show_strings else _string_label(value)
    if isinstance(value, bytes):
        is_cut = style.is_too_long(len(value))
        return str(value[: style.truncate_length] + ELLIPSIS.encode() if is_cut else value)
    if isinstance(value, bool | float | int | np.number):
        return str(value)
    return csv_text(value, style)


def _csv_sequence(values: Any, slot: Any, style: TextStyle) -> str:
    """Return a sequence as comma-separated text, or the label that stands for it."""
    if slot is not None and not style.show_arrays:
        return _array_label(values, slot)
    texts = [_csv_value(value, None, style) for value in values[: style.truncate_length]]
    return _joined([*texts, ELLIPSIS] if style.is_too_long(len(values)) else texts)


def _joined(texts: Iterable[str]) -> str:
    """Return the texts with commas between; leading empty ones get none in the real command."""
    return ','.join(dropwhile(lambda text: not text, texts))


def _cut(text: str, style: TextStyle) -> str:
    """Return the text, its end replaced by dots if it is too long."""
    return text[: style.truncate_length] + ELLIPSIS if style.is_too_long(len(text)) else text


def _string_label(text: str) -> str:
    """Return what stands for a string that is not shown."""
    return f'<string length: <{len(text)}>>'


def _array_label(values: Any, slot: Any) -> str:
    """Return what stands for an array that is not shown."""
    name = _type_name(slot.value_type)
    if isinstance(slot, Array):
        return f'<array type: {name}[{slot.size}]>'
    if isinstance(slot, BoundedSequence):
        return f'<sequence type: {name}[{slot.maximum_size}], length: {len(values)}>'
    if isinstance(slot, UnboundedSequence):
        return f'<sequence type: {name}, length: {len(values)}>'
    return 'unknown'


def _type_name(value_type: Any) -> str:
    """Return the name of the type of the elements of an array."""
    if isinstance(value_type, BasicType):
        return str(value_type.typename)
    if isinstance(value_type, AbstractString):
        return 'string'
    if isinstance(value_type, AbstractWString):
        return 'wstring'
    if isinstance(value_type, NamespacedType):
        return '/'.join(value_type.namespaced_name())
    return str(value_type.name) if isinstance(value_type, NamedType) else 'unknown'
