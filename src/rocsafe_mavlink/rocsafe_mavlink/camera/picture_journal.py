# SPDX-License-Identifier: Apache-2.0
"""Camera triggers and their photographs, in files that survive a kill of the bridge.

``shots.csv`` has a row for each trigger, ``pictures.csv`` one for each photograph. The row of a
photograph is written before the photograph is kept, so it counts only once its number was used.
"""

import csv
import io
import math
from collections import Counter
from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.durable import AppendOnlyFile
from rocsafe_mavlink.camera.camera_trigger import CameraTrigger
from rocsafe_mavlink.camera.pairing import ImagePair
from rocsafe_mavlink.knowledge.telemetry import Attitude

SHOTS, PICTURES = 'shots.csv', 'pictures.csv'
SHOT_COLUMNS = (
    *('index', 'unix_s', 'latitude_deg', 'longitude_deg', 'altitude_ellipsoid_m'),
    *('height_above_home_m', 'roll_rad', 'pitch_rad', 'yaw_rad', 'source', 'is_interpolated'),
    *('position_std_m', 'plan_id'),
)
PICTURE_COLUMNS = ('sequence', 'index', 'unix_s', 'name', 'image_unix_s')
# Names a trigger: a camera that was switched off counts from 0 again.
TriggerKey = tuple[int, str]


@dataclass(frozen=True, slots=True, kw_only=True)
class Taken:
    """What was noted of earlier photographs.

    Attributes
    ----------
    waiting
        Triggers of the last flight without a photograph, in order.
    last
        Last trigger; None: there was none.
    names
        Names of the images that were used.
    offset_s
        Clock of the camera less that of the autopilot; None: not known.
    """

    waiting: tuple[CameraTrigger, ...] = ()
    last: CameraTrigger | None = None
    names: frozenset[str] = frozenset()
    offset_s: float | None = None


class PictureJournal:
    """Keeps triggers and photographs of one vehicle.

    Parameters
    ----------
    folder
        Folder of the files; None: memory only.
    next_sequence
        Number of the next photograph: rows with this or a higher number were never kept.

    Attributes
    ----------
    taken
        What was noted by an earlier process.

    Raises
    ------
    ValueError
        If a file is damaged, or was written by another version.
    """

    def __init__(self, folder: Path | None = None, next_sequence: int = 0) -> None:
        self._counts: Counter[str] = Counter()
        self._shots = self._pictures = None
        self.taken = Taken()
        if folder is None:
            return
        folder.mkdir(parents=True, exist_ok=True)
        self._shots, shots = _opened(folder / SHOTS, SHOT_COLUMNS)
        self._pictures, pictures = _opened(folder / PICTURES, PICTURE_COLUMNS)
        try:
            self._read(shots, pictures, next_sequence)
        except (TypeError, ValueError) as error:
            raise ValueError(f'{folder}: {SHOTS} or {PICTURES} is damaged: {error}') from error

    @property
    def shot_count(self) -> int:
        """Number of triggers."""
        return self._counts.total()

    def count_of(self, plan_id: str) -> int:
        """Return the number of triggers in the flight of a plan."""
        return self._counts[plan_id]

    def add_shot(self, trigger: CameraTrigger, plan_id: str) -> None:
        """Note a trigger.

        Raises
        ------
        OSError
            If it cannot be written; it is counted all the same.
        """
        self._counts[plan_id] += 1
        if self._shots is not None:
            self._shots.append(_line([*_row(trigger), plan_id]))

    def add_picture(self, sequence: int, pair: ImagePair) -> None:
        """Note that a photograph is about to be kept.

        Raises
        ------
        OSError
            If it cannot be written.
        """
        if self._pictures is not None:
            number, moment = key_of(pair.guessed or pair.trigger)
            row = [sequence, number, moment, pair.image.name, f'{pair.image.unix_s:.3f}']
            self._pictures.append(_line(row))

    def _read(
        self, shots: list[dict[str, str]], pictures: list[dict[str, str]], next_sequence: int
    ) -> None:
        self._counts.update(row['plan_id'] for row in shots)
        last_plan = shots[-1]['plan_id'] if shots else ''
        triggers = [_trigger(row) for row in shots if row['plan_id'] == last_plan]
        kept = {int(row['sequence']): row for row in pictures}
        used = [row for sequence, row in kept.items() if sequence < next_sequence]
        done = {(int(row['index']), row['unix_s']) for row in used}
        offset_s = None
        if used:
            offset_s = float(used[-1]['image_unix_s']) - float(used[-1]['unix_s'])
        self.taken = Taken(
            waiting=tuple(one for one in triggers if key_of(one) not in done),
            last=triggers[-1] if triggers else None,
            names=frozenset(row['name'] for row in used),
            offset_s=offset_s,
        )


def key_of(trigger: CameraTrigger) -> TriggerKey:
    """Return what names a trigger in the files."""
    return trigger.index, f'{trigger.unix_s:.3f}'


def _opened(path: Path, columns: tuple[str, ...]) -> tuple[AppendOnlyFile, list[dict[str, str]]]:
    file = AppendOnlyFile(path)
    lines = [line.decode('utf-8', 'replace').rstrip('\r') for line in file.lines()]
    if not lines:
        file.append(_line(columns))
        return file, []
    if lines[0] != ','.join(columns):
        file.close()
        raise ValueError(f'{path} has other columns than this version writes: move it away')
    return file, list(csv.DictReader(lines))


def _line(row: list[object] | tuple[str, ...]) -> bytes:
    text = io.StringIO()
    csv.writer(text, lineterminator='').writerow(row)
    return text.getvalue().replace('\n', ' ').encode()


def _row(trigger: CameraTrigger) -> list[object]:
    place, attitude = trigger.position, trigger.attitude
    angles = ['', '', '']
    if attitude is not None:
        radians = (attitude.roll_rad, attitude.pitch_rad, attitude.yaw_rad)
        angles = [f'{angle:.5f}' for angle in radians]
    return [
        *key_of(trigger),
        f'{place.latitude_deg:.7f}',
        f'{place.longitude_deg:.7f}',
        f'{place.altitude_m:.3f}',
        f'{trigger.height_m:.3f}',
        *angles,
        trigger.source,
        int(trigger.is_interpolated),
        f'{trigger.position_std_m:.3f}',
    ]


def _trigger(row: dict[str, str]) -> CameraTrigger:
    latitude_deg, longitude_deg = float(row['latitude_deg']), float(row['longitude_deg'])
    altitude_m = float(row['altitude_ellipsoid_m'] or math.nan)
    attitude = None
    if row['yaw_rad']:
        attitude = Attitude(
            roll_rad=float(row['roll_rad']),
            pitch_rad=float(row['pitch_rad']),
            yaw_rad=float(row['yaw_rad']),
        )
    return CameraTrigger(
        index=int(row['index']),
        unix_s=float(row['unix_s']),
        position=GeoPosition(latitude_deg, longitude_deg, altitude_m),
        height_m=float(row['height_above_home_m']),
        attitude=attitude,
        source=row['source'],
        is_interpolated=row['is_interpolated'] == '1',
        position_std_m=float(row['position_std_m']),
    )
