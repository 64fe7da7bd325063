# SPDX-License-Identifier: Apache-2.0
"""Mistakes in files are told by key path, value and limit."""

from datetime import datetime, timezone

import pytest
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from rocsafe_scenario.validation_text import error_lines, key_path, value_text


class Inner(BaseModel):
    """A block."""

    model_config = ConfigDict(extra='forbid')
    height_m: float = Field(default=1.0, gt=0.0)
    name: str = Field(default='a', pattern='^[a-z]+$')


class Outer(BaseModel):
    """A file."""

    model_config = ConfigDict(extra='forbid')
    inner: Inner | None = None
    rows: tuple[Inner, ...] = Field(default=(), max_length=2)


def lines(content: object) -> list[str]:
    """Return the lines for a file with mistakes."""
    with pytest.raises(ValidationError) as caught:
        Outer.model_validate(content)
    return error_lines('f.yaml', caught.value, Outer)


@pytest.mark.parametrize(
    ('content', 'line'),
    [
        ({'inner': {'height_m': -1.0}}, 'inner.height_m = -1.0: must be greater than 0'),
        ({'rows': [{}, {'name': 'A'}]}, "rows[1].name = 'A': must match ^[a-z]+$"),
        ({'rows': [{'hight_m': 1}]}, 'rows[0].hight_m: unknown key (did you mean height_m?)'),
        ({'inner': {'zzz': 1}}, 'inner.zzz: unknown key (known: height_m, name)'),
        ({'rows': [{}, {}, {}]}, 'must have at most 2, has 3'),
        ({'inner': 3}, 'inner = 3: must be a block of keys'),
        (7, 'must be a block of keys'),
    ],
)
def test_mistake_is_one_line(content: object, line: str) -> None:
    """The line begins with the file, and names the key path as it is written."""
    (told,) = lines(content)
    assert told.startswith('f.yaml: ')
    assert line in told


def test_paths_are_written_as_in_the_documentation() -> None:
    """Indices in brackets, keys with dots."""
    assert key_path(('vehicles', 1, 'home', 0)) == 'vehicles[1].home[0]'
    assert key_path(()) == ''


def test_long_values_are_shortened() -> None:
    """A line stays readable, and lists are written as lists."""
    assert value_text((1, (2, 3))) == '[1, [2, 3]]'
    assert value_text({'a': 1}) == ''
    year = datetime(1066, 1, 1, tzinfo=timezone.utc)
    assert value_text(year) == '1066-01-01T00:00:00+00:00'
    text = value_text('x' * 500)
    assert len(text) == 60
    assert text.endswith('...')
