# SPDX-License-Identifier: Apache-2.0
"""Settings of nodes in YAML files: what is read, and how mistakes are named."""

import os
from dataclasses import dataclass
from datetime import datetime, timezone
from enum import Enum
from pathlib import Path
from typing import Literal

import pytest

from rocsafe_geo.limits import require_positive
from rocsafe_geo.storage.value_file import ValueFileError, read_values, values_of
from rocsafe_geo.storage.yaml_source import YamlError, parse_yaml, read_yaml


@dataclass(frozen=True, slots=True, kw_only=True)
class Thing:
    """Settings of one thing."""

    name: str
    size_m: float = 1.0
    count: int = 1
    kind: Literal['box', 'ball'] = 'box'
    place: tuple[float, float] | None = None
    made: datetime | None = None

    def __post_init__(self) -> None:
        require_positive('size_m', self.size_m, 'm')


@dataclass(frozen=True, slots=True, kw_only=True)
class Things:
    """Settings of a node."""

    things: tuple[Thing, ...] = ()
    is_open: bool = False


def things_of(text: str) -> Things:
    """Return the settings that a text holds."""
    return values_of(parse_yaml(text, 'things.yaml'), Things, 'things.yaml')


def test_reads_what_is_written(tmp_path: Path):
    """Nested blocks, lists, pairs, choices, times; what is left out has its default."""
    path = tmp_path / 'things.yaml'
    path.write_text(
        'things:\n'
        '- {name: a, size_m: 2, kind: ball, place: [53.2, -9], made: 2026-03-04T10:00:00Z}\n'
        '- name: b\n'
        'is_open: true\n'
    )
    made = datetime(2026, 3, 4, 10, tzinfo=timezone.utc)
    first = Thing(name='a', size_m=2.0, kind='ball', place=(53.2, -9.0), made=made)
    assert read_values(path, Things) == Things(things=(first, Thing(name='b')), is_open=True)
    assert type(read_values(path, Things).things[0].size_m) is float


def test_empty_file_has_defaults():
    """A file may say nothing where nothing must be said."""
    assert things_of('') == Things()


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        ('things: 3', 'things = 3: must be a list'),
        ('- 3', 'file = [3]: must be a block of keys'),
        ('things: [3]', 'things[0] = 3: must be a block of keys'),
        ('things: [{}]', 'things[0].name: is missing'),
        ('things: [{name: 5}]', 'things[0].name = 5: must be a text'),
        ('things: [{name: a, size_m: low}]', "things[0].size_m = 'low': must be a number"),
        ('things: [{name: a, size_m: true}]', 'things[0].size_m = True: must be a number'),
        ('things: [{name: a, size_m: -1}]', 'things[0]: size_m is -1 m: must be above 0'),
        ('things: [{name: a, count: 1.5}]', 'things[0].count = 1.5: must be a whole number'),
        ('things: [{name: a, kind: cube}]', "things[0].kind = 'cube': must be one of: box, ball"),
        ('things: [{name: a, place: [1]}]', 'things[0].place: must have 2 entries, has 1'),
        ('things: [{name: a, made: soon}]', "things[0].made = 'soon': must be a time such as"),
        ('things: [{name: a, siz_m: 2}]', 'things[0].siz_m: unknown key (did you mean size_m?)'),
        ('is_open: maybe', "is_open = 'maybe': must be true or false"),
        ('is_open: true\nis_open: false', "line 2: key 'is_open' is given twice"),
    ],
)
def test_mistake_is_named(text: str, line: str):
    """One line: file, key path, value, limit."""
    with pytest.raises((ValueFileError, YamlError)) as caught:
        things_of(text)
    assert str(caught.value).startswith(f'things.yaml: {line}')
    assert len(str(caught.value).splitlines()) == 1


def test_every_mistake_has_its_line():
    """A user mends all at once."""
    with pytest.raises(ValueFileError) as caught:
        things_of('things: [{name: 1}, {size_m: x}]\nopen: 1')
    assert len(str(caught.value).splitlines()) == 4


def test_missing_file_is_named(tmp_path: Path):
    """And not a traceback."""
    with pytest.raises(ValueFileError, match='no such file'):
        read_values(tmp_path / 'none.yaml', Things)


class Light(Enum):
    """An enumeration, written by its values."""

    RED = 'red'
    GREEN = 'green'


@dataclass(frozen=True, slots=True, kw_only=True)
class Signal:
    """A block with an enumeration."""

    light: Light = Light.RED


def test_enumerations_are_written_by_their_values():
    """Any other value is refused with the list of those that are allowed."""
    assert values_of({'light': 'green'}, Signal, 'signal.yaml').light is Light.GREEN
    with pytest.raises(ValueFileError, match=r"light = 'blue': must be one of: red, green"):
        values_of({'light': 'blue'}, Signal, 'signal.yaml')


def test_a_pipe_is_refused(tmp_path: Path):
    """It would wait for a writer that never comes."""
    os.mkfifo(tmp_path / 'pipe')
    with pytest.raises(YamlError, match='must be a file'):
        read_yaml(tmp_path / 'pipe')


def test_a_time_is_a_text_where_a_text_is_wanted():
    """YAML makes a time of it; a whole number that no float holds is named."""
    (thing,) = things_of('things: [{name: 2026-05-01T14:05:00Z}]').things
    assert thing.name == '2026-05-01T14:05:00+00:00'
    with pytest.raises(ValueFileError, match=r'things\[0\].size_m: must be a number below'):
        things_of('things: [{name: a, size_m: 1' + '0' * 400 + '}]')
