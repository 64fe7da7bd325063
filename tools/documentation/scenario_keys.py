# SPDX-License-Identifier: Apache-2.0
"""The reference page of scenario keys, made from the models that check scenarios."""

import inspect
import types
import typing
from collections.abc import Iterator
from datetime import datetime
from typing import Any

import annotated_types
from pydantic import BaseModel
from pydantic.fields import FieldInfo
from pydantic_core import PydanticUndefined

from rocsafe_scenario.scenario import Scenario

_HEAD = """\
# Scenario keys

Every key of a scenario file with its type, default, unit and limits. The page is made from the
models that check scenarios. [Scenarios](../scenarios.md) explains the keys; [Your own
place](../tutorials/your-place.md) shows how to write a file. A key without a default is required.
A value is not converted: `"3"` is not a number. `~` stands for no value.
"""
# Ends of names and their units; the longest end that fits counts.
UNITS = {
    '_usvh': 'µSv/h', '_usv': 'µSv', '_mps2': 'm/s²', '_mps3': 'm/s³', '_mps': 'm/s',
    '_dps': '°/s', '_g_s': 'g/s', '_gbq': 'GBq', '_mbq': 'MBq', '_bq': 'Bq', '_kev': 'keV',
    '_ppm': 'ppm', '_hz': 'Hz', '_deg': '°', '_px': 'pixels', '_per_m': '1/m', '_w': 'W',
    '_kg': 'kg', '_g': 'g', '_ev': 'EV', '_e': 'electrons', '_m': 'm', '_s': 's',
    '_per_s': '1/s', '_usvps': 'µSv/s at 1 m', '_fraction': '0 to 1',
}  # fmt: skip
_LIMITS = (
    (annotated_types.Ge, 'ge', '≥'), (annotated_types.Gt, 'gt', '>'),
    (annotated_types.Le, 'le', '≤'), (annotated_types.Lt, 'lt', '<'),
    (annotated_types.MinLen, 'min_length', 'at least'),
    (annotated_types.MaxLen, 'max_length', 'at most'),
)  # fmt: skip
# From here on short notation would round.
LARGE = 1e6


def scenario_page() -> str:
    """Return the page as Markdown."""
    return _HEAD + ''.join(_section(name, model) for name, model in _models())


def _models() -> Iterator[tuple[str, type[BaseModel]]]:
    """Yield every block once with the path of its keys, in the order of the file."""
    waiting: list[tuple[str, type[BaseModel]]] = [('', Scenario)]
    seen: set[type[BaseModel]] = set()
    while waiting:
        path, model = waiting.pop(0)
        if model in seen:
            continue
        seen.add(model)
        yield path, model
        inner = [
            (f'{path}.{key}'.lstrip('.') + ('[]' if is_list else ''), block)
            for key, field in model.model_fields.items()
            for block, is_list in _blocks(field.annotation)
        ]
        waiting[:0] = inner


def _blocks(annotation: Any, is_list: bool = False) -> Iterator[tuple[type[BaseModel], bool]]:
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        yield annotation, is_list
    within = is_list or typing.get_origin(annotation) in (tuple, list)
    for argument in typing.get_args(annotation):
        yield from _blocks(argument, within)


def _section(path: str, model: type[BaseModel]) -> str:
    title = f'`{path}`' if path else 'Top level'
    rows = ''.join(_row(key, field) for key, field in model.model_fields.items())
    return (
        f'\n## {title}\n\n{_description(model)}\n\n'
        f'| key | type | default | unit | limits |\n|---|---|---|---|---|\n{rows}'
    )


def _description(model: type[BaseModel]) -> str:
    """Return its docstring, the attributes as a list."""
    lines = (inspect.getdoc(model) or '').splitlines()
    if 'Attributes' not in lines:
        return '\n'.join(lines)
    start = lines.index('Attributes')
    text, name = lines[:start], ''
    for line in lines[start + 2 :]:
        if line and not line.startswith(' '):
            name = f'- `{line.replace(", ", "`, `")}`:'
        else:
            text.append(f'{name} {line.strip()}' if name else f'  {line.strip()}')
            name = ''
    return '\n'.join(text)


def _row(key: str, field: FieldInfo) -> str:
    cells = (f'`{key}`', _type(field.annotation), _default(field), _unit(key), _limits(field))
    return f'| {" | ".join(cells)} |\n'


def _unit(key: str) -> str:
    fitting = (end for end in UNITS if key.endswith(end))
    return UNITS.get(max(fitting, key=len, default=''), '')


def _default(field: FieldInfo) -> str:
    value = field.default
    if value is PydanticUndefined:
        return '**required**'
    if isinstance(value, BaseModel):
        return 'see there'
    if value is None:
        return '`~`'
    if isinstance(value, datetime):
        return f'`{value:%Y-%m-%dT%H:%M:%SZ}`'
    if isinstance(value, tuple):
        return f'`{list(value)}`'
    return f'`{value!r}`' if isinstance(value, str) else f'`{value}`'.lower()


def _limits(field: FieldInfo) -> str:
    texts = []
    for limit in field.metadata:
        for kind, name, text in _LIMITS:
            if isinstance(limit, kind):
                value = getattr(limit, name)
                texts.append(f'{text} {value:g}' if value < LARGE else f'{text} {value}')
    return ', '.join(texts)


def _type(annotation: Any) -> str:
    """Return what a user writes for a value of this type."""
    origin, arguments = typing.get_origin(annotation), typing.get_args(annotation)
    if origin is typing.Annotated:
        return _type(arguments[0])
    if origin is typing.Literal:
        return ' or '.join(f'`{value}`' for value in arguments)
    if origin in (typing.Union, types.UnionType):
        return ' or '.join(_type(kind) for kind in arguments if kind is not type(None))
    if origin is tuple:
        if len(arguments) == 2 and arguments[1] is Ellipsis:
            return f'list of {_type(arguments[0])}'
        return f'[{", ".join(_type(kind) for kind in arguments)}]'
    if inspect.isclass(annotation) and issubclass(annotation, BaseModel):
        return 'block'
    plain = {str: 'text', float: 'number', int: 'whole number', bool: 'true or false',
             datetime: 'UTC time'}  # fmt: skip
    return plain.get(annotation, str(annotation))
