# SPDX-License-Identifier: Apache-2.0
"""Mistakes in a scenario: which field each one names, and on which line of the text it stands."""

import re
from collections.abc import Iterator
from dataclasses import dataclass

import yaml

# As `rocsafe check` prints them: a path such as vehicles[1].home, mostly with its value.
_LINE = re.compile(r'^rocsafe: [^:]+\.yaml: (?P<rest>.+)$')
_FIELD = re.compile(r'(?P<field>[A-Za-z_][\w.\[\]-]*)(?: = .*?)??: (?P<text>.+)$')
_SYNTAX = re.compile(r'line (?P<line>\d+): (?P<text>.+)$')
_PART = re.compile(r'[^.\[\]]+')


@dataclass(frozen=True, slots=True, kw_only=True)
class Fault:
    """A mistake in a scenario.

    Attributes
    ----------
    field
        Path of the field; empty: none is named.
    line
        Line of the text, from 1 on: of the field, or of the last part of its path that is there;
        0: of none.
    text
        What is wrong.
    """

    field: str
    line: int
    text: str


def faults_of(output: str, text: str) -> tuple[Fault, ...]:
    """Return the mistakes that `rocsafe check` has printed about a scenario.

    Parameters
    ----------
    output
        What it printed.
    text
        The scenario.
    """
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError:
        root = None
    return tuple(_faults(output, root))


def _faults(output: str, root: yaml.Node | None) -> Iterator[Fault]:
    for line in output.splitlines():
        found = _LINE.match(line.strip())
        if found is None:
            continue
        rest = found['rest']
        if syntax := _SYNTAX.match(rest):
            yield Fault(field='', line=int(syntax['line']), text=syntax['text'])
        elif named := _FIELD.match(rest):
            yield Fault(
                field=named['field'],
                line=line_of(named['field'], root),
                text=rest.removeprefix(named['field']).lstrip(' :'),
            )
        else:
            yield Fault(field='', line=0, text=rest)


def line_of(field: str, root: yaml.Node | None) -> int:
    """Return the line of a field, or of the last part of its path that is there; 0: of none."""
    line = 0
    node = root
    for part in _PART.findall(field):
        found = _child(node, part)
        if found is None:
            break
        mark, node = found
        line = mark.line + 1
    return line


def _child(node: yaml.Node | None, part: str) -> tuple[yaml.Mark, yaml.Node] | None:
    """Return where a part of a path stands, and its value."""
    if isinstance(node, yaml.MappingNode):
        for key, value in node.value:
            if key.value == part:
                return key.start_mark, value
    if isinstance(node, yaml.SequenceNode) and part.isdecimal() and int(part) < len(node.value):
        value = node.value[int(part)]
        return value.start_mark, value
    return None
