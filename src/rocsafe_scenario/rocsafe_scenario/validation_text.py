# SPDX-License-Identifier: Apache-2.0
"""Errors of pydantic as one line each: key path, value, limit."""

import difflib
from collections.abc import Mapping
from datetime import date
from typing import Any

from pydantic import BaseModel, ValidationError
from pydantic_core import ErrorDetails

LONGEST_VALUE = 60
MOVED_KEYS = {
    **{f'survey.{key}': f'survey.effort.{key}' for key in ('method', 'objective', 'budget_s')},
    **{
        f'survey.{key}': f'survey.airspace.{key}'
        for key in ('clearance_m', 'terrain_clearance_m', 'wind_mps')
    },
    'survey.separation_m': 'survey.separation.distance_m',
    'survey.separation_by': 'survey.separation.by',
}
"""Where keys of older scenarios are found now."""


def error_lines(name: str, error: ValidationError, model: type[BaseModel]) -> list[str]:
    """Return one line for each mistake; `name` is the file's, `model` what it was read into.

    Examples
    --------
    ``derailment.yaml: vehicles[1].home[0] = 95.3: latitude must be within -90 to 90``
    """
    return [f'{name}: {_line(detail, model)}' for detail in error.errors(include_url=False)]


def key_path(location: tuple[int | str, ...]) -> str:
    """Return ``vehicles[1].home[0]`` for ``('vehicles', 1, 'home', 0)``."""
    parts = [f'[{key}]' if isinstance(key, int) else f'.{key}' for key in location]
    return ''.join(parts).removeprefix('.')


def value_text(value: Any) -> str:
    """Return `value` as in the file, shortened; empty for a whole block."""
    if isinstance(value, (Mapping, BaseModel)):
        return ''
    text = value.isoformat() if isinstance(value, date) else repr(_as_lists(value))
    return text if len(text) <= LONGEST_VALUE else text[: LONGEST_VALUE - 3] + '...'


def _as_lists(value: Any) -> Any:
    return [_as_lists(element) for element in value] if isinstance(value, tuple) else value


def _line(detail: ErrorDetails, model: type[BaseModel]) -> str:
    path = key_path(detail['loc'])
    kind = detail['type']
    if kind == 'extra_forbidden' and path in MOVED_KEYS:
        return f'{path}: is now {MOVED_KEYS[path]}'
    if kind == 'extra_forbidden':
        return f'{path}: unknown key{_suggestion(detail["loc"], model)}'
    if kind == 'missing':
        return f'{path}: is missing'
    value = value_text(detail['input'])
    place = f'{path} = {value}' if path and value else path or 'file'
    return f'{place}: {_limit(detail)}'


def _limit(detail: ErrorDetails) -> str:
    context = detail.get('ctx', {})
    kind = detail['type']
    if kind == 'too_short':
        return f'must have at least {context["min_length"]}, has {context["actual_length"]}'
    if kind == 'too_long':
        return f'must have at most {context["max_length"]}, has {context["actual_length"]}'
    if kind in ('model_type', 'model_attributes_type'):
        return 'must be a block of keys'
    if kind == 'string_pattern_mismatch':
        return f'must match {context["pattern"]}'
    text = detail['msg'].removeprefix('Value error, ')
    return text.replace('Input should be', 'must be').replace('tuple', 'list')


def _suggestion(location: tuple[int | str, ...], model: type[BaseModel]) -> str:
    """Return the known key that is most like the unknown one."""
    known = _known_keys(model, location[:-1])
    near = difflib.get_close_matches(str(location[-1]), known, n=1)
    if near:
        return f' (did you mean {near[0]}?)'
    return f' (known: {", ".join(known)})' if known else ''


def _known_keys(model: type[BaseModel], location: tuple[int | str, ...]) -> list[str]:
    """Return the keys of the model at `location` below `model`."""
    for key in location:
        if isinstance(key, int):
            continue
        field = model.model_fields.get(key)
        inner = _model_in(field.annotation) if field is not None else None
        if inner is None:
            return []
        model = inner
    return list(model.model_fields)


def _model_in(annotation: Any) -> type[BaseModel] | None:
    """Return the model in ``Model``, ``Model | None`` or ``tuple[Model, ...]``."""
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return annotation
    for argument in getattr(annotation, '__args__', ()):
        found = _model_in(argument)
        if found is not None:
            return found
    return None
