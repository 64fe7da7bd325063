# SPDX-License-Identifier: Apache-2.0
"""Parameter values and types in words."""

from typing import Any

from rcl_interfaces.msg import ParameterType
from rclpy.parameter import parameter_value_to_python

LABELS = {
    ParameterType.PARAMETER_NOT_SET: 'Parameter not set.',
    ParameterType.PARAMETER_BOOL: 'Boolean value is:',
    ParameterType.PARAMETER_INTEGER: 'Integer value is:',
    ParameterType.PARAMETER_DOUBLE: 'Double value is:',
    ParameterType.PARAMETER_STRING: 'String value is:',
    ParameterType.PARAMETER_BYTE_ARRAY: 'Byte values are:',
    ParameterType.PARAMETER_BOOL_ARRAY: 'Boolean values are:',
    ParameterType.PARAMETER_INTEGER_ARRAY: 'Integer values are:',
    ParameterType.PARAMETER_DOUBLE_ARRAY: 'Double values are:',
    ParameterType.PARAMETER_STRING_ARRAY: 'String values are:',
}

TYPE_NAMES = {
    ParameterType.PARAMETER_NOT_SET: 'not set',
    ParameterType.PARAMETER_BOOL: 'boolean',
    ParameterType.PARAMETER_INTEGER: 'integer',
    ParameterType.PARAMETER_DOUBLE: 'double',
    ParameterType.PARAMETER_STRING: 'string',
    ParameterType.PARAMETER_BYTE_ARRAY: 'byte array',
    ParameterType.PARAMETER_BOOL_ARRAY: 'boolean array',
    ParameterType.PARAMETER_INTEGER_ARRAY: 'integer array',
    ParameterType.PARAMETER_DOUBLE_ARRAY: 'double array',
    ParameterType.PARAMETER_STRING_ARRAY: 'string array',
}

SEPARATOR = '.'


def labelled_value(value: Any) -> tuple[str, Any]:
    """Return the words before a rcl_interfaces/ParameterValue, and the value itself."""
    return LABELS[value.type], parameter_value_to_python(value)


def nested(values: dict[str, Any]) -> dict[str, Any]:
    """Return values with dotted names as dictionaries in dictionaries."""
    root: dict[str, Any] = {}
    for name, value in values.items():
        *folders, last = name.split(SEPARATOR)
        place = root
        for folder in folders:
            place = place.setdefault(folder, {})
        place[last] = value
    return root
