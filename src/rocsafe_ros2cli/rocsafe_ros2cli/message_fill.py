# SPDX-License-Identifier: Apache-2.0
"""Messages filled from YAML, as the user writes them on the command line."""

import array
import importlib
from typing import Any

import numpy as np
import yaml
from rosidl_parser.definition import AbstractNestedType, NamespacedType

from rocsafe_ros2cli.command import CommandError


def filled_message(kind: Any, text: str) -> Any:
    """Return a message of class `kind` with the values of a YAML text.

    Raises
    ------
    CommandError
        If the text is not YAML or does not fit the message.
    """
    try:
        values = yaml.safe_load(text)
    except yaml.YAMLError as error:
        reason = ' '.join(str(error).split())
        raise CommandError(f'The passed value is not YAML: {reason}') from error
    message = _new_message(kind)
    try:
        fill(message, values)
    except Exception as error:  # the setters of messages have no common base of errors
        raise CommandError(f'Failed to populate field: {error}') from error
    return message


def fill(message: Any, values: Any) -> None:
    """Set fields of a message.

    Parameters
    ----------
    message
        The message; fields without a value are not changed.
    values
        Dictionary with the value of each field by name; nested messages as dictionaries.

    Raises
    ------
    AttributeError, TypeError, ValueError, AssertionError
        If a field does not exist or does not take its value.
    """
    if not isinstance(values, dict):
        kind = type(values).__name__
        raise TypeError(f"Value '{values}' is expected to be a dictionary but is a {kind}")
    for name, value in values.items():
        current = getattr(message, name)
        setattr(message, name, _converted(current, value, _slot(message, name)))


def _new_message(kind: Any) -> Any:
    """Return a message of this class that refuses values beyond the limits of its fields.

    Without that rclpy reads past the end of an array that is too short.
    """
    return kind(check_fields=True) if hasattr(kind, 'SLOT_TYPES') else kind()


def _converted(current: Any, value: Any, slot: Any) -> Any:
    """Return the value in the type that the field holds now."""
    if isinstance(current, array.array):
        return array.array(current.typecode, value)
    if isinstance(current, np.ndarray):
        return np.array(value, dtype=current.dtype)
    if type(value) is not type(current):
        value = _cast(type(current), value)
    element = _element_class(slot)
    return value if element is None else [_nested(element, item) for item in value]


def _cast(kind: Any, value: Any) -> Any:
    """Return the value in this class; a message is made from a dictionary of fields only."""
    try:
        return kind(value)
    except TypeError:
        return _nested(kind, value)


def _nested(kind: Any, values: Any) -> Any:
    """Return a message of this class filled with the values."""
    message = _new_message(kind)
    fill(message, values)
    return message


def _slot(message: Any, name: str) -> Any:
    """Return the type of a field."""
    names = message.get_fields_and_field_types()
    return dict(zip(names, message.SLOT_TYPES, strict=True))[name]


def _element_class(slot: Any) -> Any:
    """Return the class of the messages in an array field, None for other fields."""
    if not isinstance(slot, AbstractNestedType) or not isinstance(slot.value_type, NamespacedType):
        return None
    module = importlib.import_module('.'.join(slot.value_type.namespaces))
    return getattr(module, slot.value_type.name)
