# SPDX-License-Identifier: Apache-2.0
"""A field of an options class that is a ROS parameter."""

from dataclasses import field
from typing import Any


def option(default: Any, doc: str, low: float | None = None, high: float | None = None) -> Any:
    """Return a field whose metadata describe a ROS parameter.

    Parameters
    ----------
    default
        Value where nobody sets one.
    doc
        Its meaning with its unit, as `ros2 param describe` shows it.
    low, high
        Range of a number, both ends included.
    """
    limits = {name: value for name, value in (('min', low), ('max', high)) if value is not None}
    return field(default=default, metadata={'doc': doc, **limits})
