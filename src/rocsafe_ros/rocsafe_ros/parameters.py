# SPDX-License-Identifier: Apache-2.0
"""Options of a node as ROS parameters: declared from, and read into, a frozen dataclass.

A field's default is the parameter's default. Its metadata may hold ``doc`` (what it means, with
the unit), ``min`` and ``max``; they become the parameter's descriptor.
"""

import dataclasses
import difflib
import types
import typing
from collections.abc import Collection, Iterable, Mapping
from typing import Any, TypeVar

from rcl_interfaces.msg import FloatingPointRange, IntegerRange, ParameterDescriptor
from rclpy.exceptions import InvalidParameterValueException
from rclpy.node import Node
from rclpy.parameter import Parameter

OptionsT = TypeVar('OptionsT')

PARAMETER_TYPES: dict[Any, Parameter.Type] = {
    bool: Parameter.Type.BOOL,
    int: Parameter.Type.INTEGER,
    float: Parameter.Type.DOUBLE,
    str: Parameter.Type.STRING,
    tuple[bool, ...]: Parameter.Type.BOOL_ARRAY,
    tuple[int, ...]: Parameter.Type.INTEGER_ARRAY,
    tuple[float, ...]: Parameter.Type.DOUBLE_ARRAY,
    tuple[str, ...]: Parameter.Type.STRING_ARRAY,
}
LARGEST_INTEGER = 2**63 - 1


class ParameterError(ValueError):
    """A parameter is not known, has a wrong type, or a value out of its range."""


def declare_options(node: Node, options_type: type[OptionsT]) -> OptionsT:
    """Declare one read-only parameter a field of `options_type` and return their values.

    `options_type` may have a class variable `MOVED_PARAMETERS`, a mapping from the names of
    parameters of earlier versions to what replaces them. Setting one is an error.

    Raises
    ------
    ParameterError
        Naming the parameter, its value and the limit; or a parameter that was given and that the
        node does not have, which ROS would ignore.
    TypeError
        If a field's type has no parameter type.
    """
    _refuse_moved(node, getattr(options_type, 'MOVED_PARAMETERS', {}))
    types = typing.get_type_hints(options_type)
    fields = dataclasses.fields(options_type)  # type: ignore[arg-type]
    _refuse_unknown(node, [field.name for field in fields])
    values = {field.name: _declare(node, field, types[field.name]) for field in fields}
    try:
        return options_type(**values)
    except ValueError as error:
        raise ParameterError(f'{node.get_name()}: {error}') from error


def _refuse_moved(node: Node, moved: Mapping[str, str]) -> None:
    """Refuse parameters of earlier versions, naming what takes their place."""
    anything = ParameterDescriptor(dynamic_typing=True)
    for name, new in moved.items():
        is_given = node.declare_parameter(name, None, anything).value is not None
        node.undeclare_parameter(name)
        if is_given:
            raise ParameterError(f'{node.get_name()}: parameter {name} is now {new}')


def _refuse_unknown(node: Node, known: Collection[str]) -> None:
    """Refuse parameters that `node` was given and that are neither of `known` nor ROS's own."""
    # rclpy has no public name for what it was given.
    given = node._parameter_overrides
    unknown = [name for name in given if name not in known and not node.has_parameter(name)]
    if unknown:
        raise ParameterError(f'{node.get_name()}: no parameter {with_nearest(unknown, known)}')


def with_nearest(names: Iterable[str], known: Collection[str]) -> str:
    """Return names, each with the one of `known` that is most like it, as text."""
    nearest = {name: difflib.get_close_matches(name, known, n=1, cutoff=0.0)[0] for name in names}
    return ', '.join(f'{name} (did you mean {nearest[name]}?)' for name in sorted(nearest))


def _declare(node: Node, field: 'dataclasses.Field[Any]', field_type: Any) -> Any:
    """Declare `field` and return its value, as the field's own type."""
    if field_type not in PARAMETER_TYPES:
        raise TypeError(f'option {field.name}: no parameter type for {field_type}')
    # First without a type: a parameter file may say 8 where 8.0 is meant, and an empty list has
    # no type of its own.
    anything = ParameterDescriptor(dynamic_typing=True)
    given = node.declare_parameter(field.name, _default(field), anything).value
    node.undeclare_parameter(field.name)
    value = _converted(field, field_type, given)
    descriptor = _descriptor(field, PARAMETER_TYPES[field_type])
    descriptor.dynamic_typing = value == []
    try:
        node.declare_parameter(field.name, value, descriptor, ignore_override=True)
    except InvalidParameterValueException as error:
        raise ParameterError(_range_text(node, field, value)) from error
    return tuple(value) if isinstance(value, list) else value


def _default(field: 'dataclasses.Field[Any]') -> Any:
    default = field.default
    if default is dataclasses.MISSING:
        raise TypeError(f'option {field.name} has no default')
    return list(default) if isinstance(default, tuple) else default


def _converted(field: 'dataclasses.Field[Any]', field_type: Any, value: Any) -> Any:
    """Return `value` in `field_type`; integers are taken as floats, other types are refused."""
    if typing.get_origin(field_type) is tuple:
        element_type = typing.get_args(field_type)[0]
        if value is None:
            return []
        if isinstance(value, (str, bytes)) or not hasattr(value, '__iter__'):
            raise ParameterError(_type_text(field, field_type, value))
        return [_converted(field, element_type, element) for element in value]
    if field_type is float and isinstance(value, int) and not isinstance(value, bool):
        return float(value)
    if type(value) is not field_type:
        raise ParameterError(_type_text(field, field_type, value))
    return value


def _type_text(field: 'dataclasses.Field[Any]', field_type: Any, value: Any) -> str:
    is_plain = isinstance(field_type, type) and not isinstance(field_type, types.GenericAlias)
    name = field_type.__name__ if is_plain else str(field_type)
    return f'parameter {field.name} = {value!r} must be of type {name}'


def _range_text(node: Node, field: 'dataclasses.Field[Any]', value: Any) -> str:
    low = field.metadata.get('min', '-inf')
    high = field.metadata.get('max', 'inf')
    name = f'{node.get_name()}: parameter {field.name}'
    return f'{name} = {value!r} must be within {low} to {high}'


def _descriptor(field: 'dataclasses.Field[Any]', kind: Parameter.Type) -> ParameterDescriptor:
    descriptor = ParameterDescriptor(
        description=str(field.metadata.get('doc', '')), read_only=True
    )
    if 'min' not in field.metadata and 'max' not in field.metadata:
        return descriptor
    if kind in (Parameter.Type.DOUBLE, Parameter.Type.DOUBLE_ARRAY):
        low = float(field.metadata.get('min', float('-inf')))
        high = float(field.metadata.get('max', float('inf')))
        descriptor.floating_point_range = [FloatingPointRange(from_value=low, to_value=high)]
    elif kind in (Parameter.Type.INTEGER, Parameter.Type.INTEGER_ARRAY):
        low_int = int(field.metadata.get('min', -LARGEST_INTEGER))
        high_int = int(field.metadata.get('max', LARGEST_INTEGER))
        descriptor.integer_range = [IntegerRange(from_value=low_int, to_value=high_int, step=1)]
    return descriptor
