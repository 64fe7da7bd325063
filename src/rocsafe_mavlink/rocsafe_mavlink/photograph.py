# SPDX-License-Identifier: Apache-2.0
"""Photographs of a real vehicle, kept until somebody else has them safe."""

import json
import os
from collections.abc import Iterator
from dataclasses import asdict, dataclass
from hashlib import sha256
from pathlib import Path
from typing import Any

from rocsafe_geo.position import GeoPosition

Quaternion = tuple[float, float, float, float]
# One without a receipt is sent again after this long, but not more than so many at once.
RESEND_S = 1.0
RESEND_BURST = 20
_NEXT = 'next.json'


@dataclass(frozen=True, slots=True, kw_only=True)
class Photograph:
    """One photograph with all that is needed to place it.

    Attributes
    ----------
    vehicle: that took it.
    sequence: of the vehicle, from 0, without gaps.
    viewpoint_id: of the plan it was taken at.
    time_ns: of the exposure, in the time of the mission.
    position: of the camera; altitude above the ellipsoid, NaN if not known.
    horizontal_std_m, vertical_std_m: of it; NaN if not known.
    height_m: above home, which is taken for the ground.
    quaternion_xyzw: rotates the optical frame into east-north-up.
    width_px, height_px: of the image.
    jpeg: the image file.
    """

    vehicle: str
    sequence: int
    viewpoint_id: int
    time_ns: int
    position: GeoPosition
    horizontal_std_m: float
    vertical_std_m: float
    height_m: float
    quaternion_xyzw: Quaternion
    width_px: int
    height_px: int
    jpeg: bytes

    @property
    def shot_id(self) -> str:
        """Unique in a mission."""
        return f'{self.vehicle}-{self.sequence:05d}'

    @property
    def sha256(self) -> str:
        """Of the image file, 64 hexadecimal digits."""
        return sha256(self.jpeg).hexdigest()


class PhotographStore:
    """Photographs without a receipt, in memory and, if a folder is given, on disk."""

    def __init__(self, folder: Path | None = None) -> None:
        self._folder = folder
        self._sent_s: dict[str, float] = {}
        self._waiting: dict[str, Photograph] = {}
        self.next_sequence = 0
        if folder is not None:
            folder.mkdir(parents=True, exist_ok=True)
            self._waiting = {photograph.shot_id: photograph for photograph in _stored(folder)}
            if (folder / _NEXT).exists():
                self.next_sequence = int(json.loads((folder / _NEXT).read_text())['next'])

    def __len__(self) -> int:
        """Return how many wait for a receipt."""
        return len(self._waiting)

    def add(self, photograph: Photograph) -> None:
        """Keep `photograph`: once this returns, a kill does not lose it."""
        self._waiting[photograph.shot_id] = photograph
        self.next_sequence = photograph.sequence + 1
        if self._folder is None:
            return
        record = {name: value for name, value in asdict(photograph).items() if name != 'jpeg'}
        _write(self._folder / f'{photograph.shot_id}.jpg', photograph.jpeg)
        _write(self._folder / f'{photograph.shot_id}.json', json.dumps(record).encode())
        _write(self._folder / _NEXT, json.dumps({'next': self.next_sequence}).encode())

    def take_receipt(self, shot_id: str, digest: str) -> bool:
        """Forget a photograph that is safe elsewhere; return whether it was one kept here."""
        photograph = self._waiting.get(shot_id)
        if photograph is None or photograph.sha256 != digest:
            return False
        del self._waiting[shot_id]
        self._sent_s.pop(shot_id, None)
        if self._folder is not None:
            (self._folder / f'{shot_id}.json').unlink(missing_ok=True)
            (self._folder / f'{shot_id}.jpg').unlink(missing_ok=True)
        return True

    def overdue(self, now_s: float) -> list[Photograph]:
        """Return the photographs to send now, oldest first, and note that they were sent."""
        due = [
            photograph
            for shot_id, photograph in self._waiting.items()
            if now_s - self._sent_s.get(shot_id, -RESEND_S) >= RESEND_S
        ][:RESEND_BURST]
        self._sent_s.update({photograph.shot_id: now_s for photograph in due})
        return due


def _write(path: Path, content: bytes) -> None:
    scratch = path.with_name(path.name + '.new')
    with scratch.open('wb') as file:
        file.write(content)
        file.flush()
        os.fsync(file.fileno())
    scratch.replace(path)


def _stored(folder: Path) -> Iterator[Photograph]:
    for path in sorted(folder.glob('*-*.json')):
        record: dict[str, Any] = json.loads(path.read_bytes())
        record['position'] = GeoPosition(**record['position'])
        record['quaternion_xyzw'] = tuple(record['quaternion_xyzw'])
        yield Photograph(**record, jpeg=path.with_suffix('.jpg').read_bytes())
