# SPDX-License-Identifier: Apache-2.0
"""Vehicles that may be contaminated, kept in a file beside the run directories until cleared.

Who or what comes out of the inner cordoned area counts as contaminated until it was checked (IAEA,
EPR-First Responders).
"""

import json
from collections.abc import Mapping
from pathlib import Path

from rocsafe_geo.storage.durable import replace_whole
from rocsafe_orchestrator.errors import SetupError

FILE_NAME = 'contaminated.json'


def contaminated(folder: Path) -> dict[str, str]:
    """Return the vehicles that may be contaminated, and why.

    Raises
    ------
    SetupError
        If the file cannot be read: then nobody knows.
    """
    path = folder / FILE_NAME
    try:
        content = json.loads(path.read_text(encoding='utf-8'))
    except FileNotFoundError:
        return {}
    except (OSError, ValueError) as error:
        raise SetupError(f'{path}: cannot be read: {error}') from error
    if not isinstance(content, dict) or not all(isinstance(v, str) for v in content.values()):
        raise SetupError(f'{path}: must name vehicles, each with a reason')
    return content


def mark(folder: Path, vehicles: Mapping[str, str]) -> str:
    """Add vehicles with the reason; an earlier reason stays.

    Return why they could not be added, empty if they were: no flight ends by it.
    """
    try:
        if vehicles:
            _write(folder, {**vehicles, **contaminated(folder)})
    except (OSError, SetupError) as error:
        return f'{", ".join(vehicles)} could not be marked as contaminated: {error}'
    return ''


def clear(folder: Path, vehicle: str) -> None:
    """Note that a vehicle was checked and is clean.

    Raises
    ------
    SetupError
        If it was not marked.
    """
    marked = contaminated(folder)
    if vehicle not in marked:
        names = ', '.join(sorted(marked)) or 'none'
        raise SetupError(f'{vehicle}: is not marked in {folder / FILE_NAME}; marked: {names}')
    _write(folder, {name: why for name, why in marked.items() if name != vehicle})


def require_clean(folder: Path, vehicles: tuple[str, ...]) -> None:
    """Refuse to fly vehicles that may be contaminated.

    Raises
    ------
    SetupError
        One line for each.
    """
    marked = contaminated(folder)
    lines = [
        f'{name}: may be contaminated: {marked[name]}; check it, then: rocsafe clear {name} '
        f'--out {folder}'
        for name in vehicles
        if name in marked
    ]
    if lines:
        raise SetupError('\n'.join(lines))


def _write(folder: Path, vehicles: Mapping[str, str]) -> None:
    text = json.dumps(dict(sorted(vehicles.items())), indent=2) + '\n'
    replace_whole(folder / FILE_NAME, text.encode())
