# SPDX-License-Identifier: Apache-2.0
"""File of the last turn of a gimbal, with which a restarted process continues it."""

import json
from dataclasses import asdict
from pathlib import Path

from rocsafe_geo.storage.durable import replace_whole
from rocsafe_geo.storage.value_file import values_of
from rocsafe_sim.cameras.gimbal import GimbalTurn
from rocsafe_sim.errors import JournalError


def write_gimbal(folder: Path, camera: str, turn: GimbalTurn) -> None:
    """Write the turn of the gimbal of a camera into the spool of a vehicle, atomically."""
    folder.mkdir(parents=True, exist_ok=True)
    replace_whole(_path(folder, camera), json.dumps(asdict(turn)).encode())


def read_gimbal(folder: Path, camera: str) -> GimbalTurn | None:
    """Return the turn that `write_gimbal` wrote; None if there is no file.

    Raises
    ------
    JournalError
        If the file is not such a turn.
    """
    path = _path(folder, camera)
    try:
        return values_of(json.loads(path.read_text()), GimbalTurn, path.name)
    except FileNotFoundError:
        return None
    except (OSError, ValueError) as error:
        raise JournalError(f'{path}: not the turn of a gimbal: {error!r}') from error


def _path(folder: Path, camera: str) -> Path:
    # Photographs in the spool are called <vehicle>-<number>.json: none ends in .gimbal.
    return folder / f'{camera}.gimbal'
