# SPDX-License-Identifier: Apache-2.0
"""Dotted paths of scenario keys, such as ``vehicles[*].cruise_speed_mps``."""

import re
from collections.abc import Mapping, Sequence
from typing import Any

from rocsafe_campaign.errors import CampaignError

EVERY = '*'
_PART = re.compile(r'([A-Za-z_][A-Za-z0-9_]*)((?:\[(?:\d+|\*)\])*)')
Part = str | int


def parts_of(path: str) -> tuple[Part, ...]:
    """Return ``('vehicles', 1, 'name')`` for ``vehicles[1].name``; ``*`` stands for every entry.

    Raises
    ------
    CampaignError
        If it is no path.
    """
    parts: list[Part] = []
    for text in path.split('.'):
        found = _PART.fullmatch(text)
        if found is None:
            raise CampaignError(f'{path!r}: must be a key such as vehicles[0].cruise_speed_mps')
        parts.append(found[1])
        indices = re.findall(r'\[(\d+|\*)\]', found[2])
        parts.extend(EVERY if index == EVERY else int(index) for index in indices)
    return tuple(parts)


def with_value(content: Any, path: str, value: object) -> Any:
    """Return the content of a scenario file with another value at `path`; blocks are made.

    Raises
    ------
    CampaignError
        If the path names an entry of a list that is not there.
    """
    return _with(content, parts_of(path), value, path)


def _with(content: Any, parts: tuple[Part, ...], value: object, path: str) -> Any:
    if not parts:
        return value
    part, *rest = parts
    below = tuple(rest)
    if part == EVERY or isinstance(part, int):
        return _with_entry(content, part, below, value, path)
    block = {} if content is None else content
    if not isinstance(block, Mapping):
        raise CampaignError(f'{path}: {part} is no key of a block in the scenario')
    return {**block, part: _with(block.get(part), below, value, path)}


def _with_entry(
    content: Any, part: Part, below: tuple[Part, ...], value: object, path: str
) -> tuple[Any, ...]:
    entries = content if isinstance(content, Sequence) and not isinstance(content, str) else ()
    if not entries or (isinstance(part, int) and part >= len(entries)):
        raise CampaignError(f'{path}: [{part}]: the scenario has {len(entries)} entries there')
    return tuple(
        _with(entry, below, value, path) if part in (EVERY, index) else entry
        for index, entry in enumerate(entries)
    )
