# SPDX-License-Identifier: Apache-2.0
"""Label images beside a store: kept with the photographs they belong to, read again as classes.

``labels/<shot_id>.png`` has a number for each pixel, 8 or 16 bits; ``labels/table.json``, where
there is one, tells the class and colour of each number. Labels come from the simulator; they are
not evidence and need no receipt.
"""

import json
from collections import OrderedDict
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.storage.durable import write_whole
from rocsafe_geo.storage.named_file import require_file
from rocsafe_mapping.errors import StoreError

LABELS, TABLE = 'labels', 'table.json'
# Label images and photographs that wait for each other, of one vehicle.
MOST_WAITING = 16
MOST_CLASSES, NUMBERS = 255, 2**16
Labels = NDArray[np.uint8]
Numbers = NDArray[np.uint16]
_GREY = (160, 160, 160)


@dataclass(frozen=True, slots=True)
class LabelClass:
    """A class: its value in maps, its name and its colour (red, green, blue)."""

    value: int
    name: str
    colour: tuple[int, int, int]


class LabelKeeper:
    """Writes the label images of photographs: those with the stamp of a photograph.

    Parameters
    ----------
    store
        Folder of the image store.
    """

    def __init__(self, store: Path) -> None:
        self._folder = store / LABELS
        self._images: dict[str, OrderedDict[int, Numbers]] = {}
        self._shots: dict[str, OrderedDict[int, str]] = {}
        self._rows: dict[int, dict[str, Any]] = {}

    def add_table(self, text: str) -> None:
        """Keep a vehicle's table of numbers: a JSON list of number, class, colour.

        Raises
        ------
        StoreError
            If it is no such list, or cannot be written.
        """
        try:
            rows = {int(row['number']): row for row in json.loads(text)}
        except (ValueError, TypeError, KeyError) as error:
            raise StoreError(f'label table is not understood: {error!r}') from error
        if rows.items() <= self._rows.items():
            return
        self._rows |= rows
        ordered = [self._rows[number] for number in sorted(self._rows)]
        self._write(TABLE, json.dumps(ordered, indent=1).encode() + b'\n')

    def add_image(self, vehicle: str, time_ns: int, numbers: Numbers) -> None:
        """Take a label image; it is written if a photograph of that moment is or will be there.

        Raises
        ------
        StoreError
            If it cannot be written.
        """
        shot_id = self._shots.setdefault(vehicle, OrderedDict()).pop(time_ns, None)
        if shot_id is not None:
            self._write_image(shot_id, numbers)
        else:
            _remember(self._images.setdefault(vehicle, OrderedDict()), time_ns, numbers)

    def add_shot(self, vehicle: str, time_ns: int, shot_id: str) -> None:
        """Note a stored photograph. Raises StoreError if its labels cannot be written."""
        numbers = self._images.setdefault(vehicle, OrderedDict()).pop(time_ns, None)
        if numbers is not None:
            self._write_image(shot_id, numbers)
        else:
            _remember(self._shots.setdefault(vehicle, OrderedDict()), time_ns, shot_id)

    def _write_image(self, shot_id: str, numbers: Numbers) -> None:
        self._write(f'{shot_id}.png', bytes(cv2.imencode('.png', numbers)[1]))

    def _write(self, name: str, content: bytes) -> None:
        try:
            self._folder.mkdir(parents=True, exist_ok=True)
            write_whole(self._folder / name, content)
        except OSError as error:
            raise StoreError(f'cannot keep labels at {self._folder / name}: {error}') from error


class LabelImages:
    """The label images of a folder as classes, 0 where nothing is known.

    Without a table the numbers are the classes.

    Raises
    ------
    StoreError
        If the table is not understood or has too many classes.
    """

    def __init__(self, folder: Path) -> None:
        self._folder = folder
        self.classes: tuple[LabelClass, ...] = ()
        self._lookup: Labels | None = None
        path = folder / TABLE
        if path.exists():
            try:
                require_file(path)
                self._take(json.loads(path.read_text()))
            except (OSError, ValueError, TypeError, KeyError, AttributeError) as error:
                raise StoreError(f'label table {path} is not understood: {error!r}') from error

    def of(self, name: str) -> Labels | None:
        """Return the classes of a photograph by the name of its file, None if there are none.

        Raises
        ------
        StoreError
            If the file is no label image.
        """
        path = self._folder / f'{name}.png'
        if not path.is_file():
            return None
        numbers = cv2.imread(str(path), cv2.IMREAD_UNCHANGED)
        if numbers is None or numbers.ndim != 2 or numbers.dtype not in (np.uint8, np.uint16):
            raise StoreError(f'{path} is no picture of 8 or 16 bit numbers')
        if self._lookup is not None:
            return np.asarray(self._lookup[numbers])
        if numbers.dtype == np.uint16:
            raise StoreError(f'{path} has 16 bit numbers, and {TABLE} is missing beside it')
        return np.asarray(numbers)

    def _take(self, rows: list[Mapping[str, Any]]) -> None:
        colours = {
            str(row['class']): (*map(int, row.get('colour') or _GREY),) for row in reversed(rows)
        }
        if len(colours) > MOST_CLASSES:
            raise ValueError(f'{len(colours)} classes exceed {MOST_CLASSES}')
        self.classes = tuple(
            LabelClass(value, name, (colours[name][0], colours[name][1], colours[name][2]))
            for value, name in enumerate(sorted(colours), start=1)
        )
        values = {label.name: label.value for label in self.classes}
        self._lookup = np.zeros(NUMBERS, np.uint8)
        for row in rows:
            if 0 <= int(row['number']) < NUMBERS:
                self._lookup[int(row['number'])] = values[str(row['class'])]


def _remember(kept: OrderedDict[int, Any], time_ns: int, value: object) -> None:
    kept[time_ns] = value
    while len(kept) > MOST_WAITING:
        kept.popitem(last=False)
