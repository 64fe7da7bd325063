# SPDX-License-Identifier: Apache-2.0
"""A map of labelled ground: which class each pixel is, and the names of the classes."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_ground.drivable.ground_classes import GroundClass
from rocsafe_ground.drivable.raster import Bands, read_bands
from rocsafe_ground.errors import NoMapError

# Labels that can be driven; all others are obstacles. Names are those of `rocsafe map --labels`.
DRIVEN_LABELS = {
    'asphalt': GroundClass.ROAD,
    'gravel': GroundClass.ROAD,
    'concrete': GroundClass.ROAD,
    'grass': GroundClass.GRASS,
    'meadow': GroundClass.GRASS,
    'soil': GroundClass.SOIL,
    'scorch': GroundClass.SOIL,
}


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class LabelMap:
    """Classes of pixels.

    Attributes
    ----------
    bands
        One band of values; NaN where nothing is known.
    names
        Name of the class of each value.
    """

    bands: Bands
    names: Mapping[int, str]

    def shows(self, name: str) -> BoolArray:
        """Return which pixels have the class of a name, (rows, columns)."""
        values = [value for value, other in self.names.items() if other == name]
        return np.asarray(np.isin(self.bands.values[0], values))

    def classes(self) -> FloatArray:
        """Return the `GroundClass` of each pixel, 0 where unknown, (rows, columns)."""
        found = np.zeros(self.bands.values[0].shape)
        for value, name in self.names.items():
            kind = DRIVEN_LABELS.get(name, GroundClass.OBJECT)
            found[self.bands.values[0] == value] = float(kind)
        return found


def read_labels(path: Path) -> LabelMap:
    """Return the labels of a GeoTIFF; the names are in a ``.json`` file of the same name.

    Raises
    ------
    NoMapError
        If one of the two files is missing or not what it should be.
    """
    bands = read_bands(path)
    table = path.with_suffix('.json')
    try:
        rows = json.loads(table.read_text(encoding='utf-8'))['classes']
        names = {int(row['value']): str(row['class']) for row in rows}
    except OSError as error:
        raise NoMapError(f'{table}: {error.strerror}') from error
    except (KeyError, TypeError, ValueError) as error:
        raise NoMapError(f'{table}: is no table of labels: {error!r}') from error
    return LabelMap(bands=bands, names=names)
