# SPDX-License-Identifier: Apache-2.0
"""Parameters of a call as clients give them; what is of another kind is refused by its name."""

import inspect
import math
from collections.abc import Awaitable, Callable, Mapping
from typing import Any

from rocsafe_airsim.errors import AirsimError

_LONGEST_SHOWN = 80


def number(value: Any, name: str, *, is_finite: bool = True) -> float:
    """Return a number; raises `AirsimError` if it is none, or is not finite where it must be."""
    if isinstance(value, int | float) and (math.isfinite(value) or not is_finite):
        return float(value)
    raise AirsimError(f'{name} is {shown(value)}: must be a {"finite " * is_finite}number')


def text(value: Any, name: str) -> str:
    """Return a text; raises `AirsimError` if it is none."""
    if isinstance(value, str):
        return value
    raise AirsimError(f'{name} is {shown(value)}: must be a text')


def table(value: Any, name: str) -> Mapping[str, Any]:
    """Return a map, such as a Vector3r; raises `AirsimError` if it is none."""
    if isinstance(value, dict):
        return value
    raise AirsimError(f'{name} is {shown(value)}: must be a map')


def sequence(value: Any, name: str) -> list[Any]:
    """Return an array; raises `AirsimError` if it is none."""
    if isinstance(value, list | tuple):
        return list(value)
    raise AirsimError(f'{name} is {shown(value)}: must be an array')


def shown(value: Any) -> str:
    """Return a value as a refusal tells it, cut to a length."""
    told = repr(value)
    return told if len(told) <= _LONGEST_SHOWN else f'{told[:_LONGEST_SHOWN]}...'


def call_with(method: Callable[..., Awaitable[Any]], arguments: tuple[Any, ...]) -> Awaitable[Any]:
    """Call a method; raises `AirsimError` if it takes fewer or more parameters."""
    kinds = inspect.signature(method).parameters.values()
    most = math.inf if any(one.kind is one.VAR_POSITIONAL for one in kinds) else len(kinds)
    least = sum(one.default is one.empty and one.kind is not one.VAR_POSITIONAL for one in kinds)
    if least <= len(arguments) <= most:
        return method(*arguments)
    limit = f'{least}' if least == most else f'{least} to {most}'
    raise AirsimError(f'{len(arguments)} parameters: must be {limit}')
