# SPDX-License-Identifier: Apache-2.0
"""Messages filled from YAML, as the user writes them on the command line."""

import array
import importlib
import sys
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np
import yaml
from rosidl_parser.definition import AbstractNestedType, NamespacedType

from rocsafe_ros2cli.command import CommandError

StampSetter = Callable[[Any], None]


def read_values(text: str) -> Any:
    """Return what the YAML text means.

    Raises
    ------
    CommandError
        If the text is not YAML.
    """
    try:
        return yaml.safe_load(text)
    except yaml.YAMLError as error:
        reason = ' '.join(str(error).split())
        raise CommandError(f'The passed value is not YAML: {reason}') from error


def values_text(argument: str, *, from_stdin: bool) -> str:
    """Return the YAML text: the argument, or standard input up to its end."""
    return sys.stdin.read() if from_stdin else argument


def new_message(kind: Any) -> Any:
    """Return a message of this class that refuses values beyond the limits of its fields.

    Without that rclpy reads past the end of an array that is too short.
    """
    return kind(check_fields=True)


def fill(message: Any, values: Any, *, with_clock: bool = False) -> list[StampSetter]:
    """Set the fields of a message.

    Parameters
    ----------
    message
        The message; fields without a value keep theirs.
    values : dict
        Value of each field by name; nested messages as dictionaries.
    with_clock : bool
        Take `auto` as a std_msgs/Header and `now` as a builtin_interfaces/Time to mean the time
        of publishing.

    Returns
    -------
    list of StampSetter
        To be called with the time before each publishing.

    Raises
    ------
    AttributeError, TypeError, ValueError, AssertionError
        If a field is not there or does not take its value.
    """
    filler = _Filler(with_clock)
    filler.fill(message, values)
    return filler.stamp_setters


class _Filler:
    """Fills a message and the messages in it; collects what waits for the time."""

    def __init__(self, with_clock: bool) -> None:
        self._with_clock = with_clock
        self.stamp_setters: list[StampSetter] = []

    def fill(self, message: Any, values: Any) -> None:
        """Set each named field of a message."""
        if not isinstance(values, dict):
            kind = type(values).__name__
            raise TypeError(f"Value '{values}' is expected to be a dictionary but is a {kind}")
        for name, value in values.items():
            current = getattr(message, name)
            if not (self._with_clock and self._waits_for_time(message, name, value)):
                setattr(message, name, self._converted(current, value, _slot(message, name)))

    def _waits_for_time(self, message: Any, name: str, value: Any) -> bool:
        """Note a field that gets the time of publishing; return whether this is one."""
        field = getattr(message, name)
        kind = f'{type(field).__module__}.{type(field).__name__}'
        if kind == 'std_msgs.msg._header.Header' and value == 'auto':
            self.stamp_setters.append(partial(setattr, field, 'stamp'))
            return True
        if kind == 'builtin_interfaces.msg._time.Time' and value == 'now':
            self.stamp_setters.append(partial(setattr, message, name))
            return True
        return False

    def _converted(self, current: Any, value: Any, slot: Any) -> Any:
        """Return the value as the type that the field holds now."""
        if isinstance(current, array.array):
            return array.array(current.typecode, value)
        if isinstance(current, np.ndarray):
            return np.array(value, dtype=current.dtype)
        if type(value) is not type(current):
            value = self._cast(type(current), value)
        element = _element_class(slot)
        return value if element is None else [self._nested(element, item) for item in value]

    def _cast(self, kind: Any, value: Any) -> Any:
        """Return the value as one of this class; a message takes none but fields."""
        try:
            return kind(value)
        except TypeError:
            return self._nested(kind, value)

    def _nested(self, kind: Any, values: Any) -> Any:
        """Return a message of this class filled with the values."""
        message = new_message(kind) if hasattr(kind, 'SLOT_TYPES') else kind()
        self.fill(message, values)
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
