# SPDX-License-Identifier: Apache-2.0
"""A gimbal's last order on disk, so that a killed process keeps pointing its camera."""

import json
from dataclasses import asdict
from pathlib import Path

from rocsafe_geo.storage.durable import replace_whole
from rocsafe_sim.cameras.gimbal import Direction, GimbalOrder
from rocsafe_sim.errors import JournalError


def write_gimbal(folder: Path, camera: str, order: GimbalOrder) -> None:
    """Write the order of the gimbal of a camera into a vehicle's spool, atomically."""
    folder.mkdir(parents=True, exist_ok=True)
    replace_whole(_path(folder, camera), json.dumps(asdict(order)).encode())


def read_gimbal(folder: Path, camera: str) -> GimbalOrder | None:
    """Return the order that `write_gimbal` wrote; None if it never did.

    Raises
    ------
    JournalError: if the file is not such an order.
    """
    path = _path(folder, camera)
    try:
        fields = json.loads(path.read_text())
        return GimbalOrder(
            start_ns=int(fields['start_ns']),
            start=Direction(**fields['start']),
            target=Direction(**fields['target']),
        )
    except FileNotFoundError:
        return None
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise JournalError(f'{path}: not the order of a gimbal: {error!r}') from error


def _path(folder: Path, camera: str) -> Path:
    # The spool's photographs are <vehicle>-<number>.json: no such name ends in .gimbal.
    return folder / f'{camera}.gimbal'
