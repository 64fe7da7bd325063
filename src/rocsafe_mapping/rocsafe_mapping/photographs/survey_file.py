# SPDX-License-Identifier: Apache-2.0
"""Text files of places in OpenDroneMap's form: a line that names the CRS, then rows of words.

Format: OpenDroneMap's documentation, "Ground Control Points" and "Image Geolocation Files".
"""

import math
import re
import warnings
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from pyproj import CRS, Transformer
from pyproj.exceptions import ProjError
from pyproj.transformer import TransformerGroup

from rocsafe_geo.storage.named_file import require_file
from rocsafe_mapping.errors import MappingError

MOST_BYTES = 64 * 2**20
WGS84_EPSG, UTM_ZONES = 4326, 60
MOVING_FRAME_M = 1.0
"""PROJ's accuracy for frames that a plate carries away from WGS84, as ETRS89: not counted, for
who corrects fixes from a network of stations there has them in that frame."""

_UTM = re.compile(r'WGS84\s+UTM\s+(\d{1,2})\s*([NS])', re.IGNORECASE)


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """A row of a file.

    Attributes
    ----------
    where
        File and number of the row, for messages.
    words
        Its values.
    """

    where: str
    words: Sequence[str]

    def number(
        self, index: int, name: str, low: float = -math.inf, high: float = math.inf
    ) -> float:
        """Return a value that must be a finite number within limits.

        Raises
        ------
        MappingError
            If it is not; the message names file, row, value and limits.
        """
        text = self.words[index] if index < len(self.words) else ''
        try:
            value = float(text)
        except ValueError:
            raise MappingError(f'{self.where}: {name} = {text!r} is no number') from None
        if not (math.isfinite(value) and low <= value <= high):
            limits = f'finite and from {low:g} to {high:g}' if math.isfinite(low) else 'finite'
            raise MappingError(f'{self.where}: {name} = {text} must be {limits}')
        return value

    def height(self, index: int) -> float:
        """Return a height, NaN where the row has none or says NaN."""
        text = self.words[index] if index < len(self.words) else 'nan'
        return math.nan if text.lower() == 'nan' else self.number(index, 'geo_z')


@dataclass(frozen=True, slots=True, kw_only=True)
class Places:
    """Turns the coordinates of a file into positions.

    Attributes
    ----------
    crs
        As the file names it.
    to_wgs84
        From that CRS.
    """

    crs: str
    to_wgs84: Transformer

    @property
    def datum_error_m(self) -> float:
        """How exactly the last position is known in WGS84, metres; 0 where PROJ does not say.

        A national CRS with a datum of its own is known to some metres where PROJ has not the grid
        of its shifts. All points of one CRS are off alike.
        """
        found = float(self.to_wgs84.accuracy)
        if found < 0.0:  # there are several ways: that of the last position
            found = float(self.to_wgs84.get_last_used_operation().accuracy)
        return found if found > MOVING_FRAME_M else 0.0

    @property
    def missing_grids(self) -> tuple[str, ...]:
        """Files with which PROJ would know positions more exactly than it does."""
        source = self.to_wgs84.source_crs
        with warnings.catch_warnings():
            warnings.simplefilter('ignore', UserWarning)
            group = TransformerGroup(source, WGS84_EPSG, always_xy=True)
        if group.best_available or not group.unavailable_operations:
            return ()
        return tuple(grid.short_name for grid in group.unavailable_operations[0].grids)

    def position(self, row: Row, x_index: int) -> tuple[float, float]:
        """Return latitude and longitude of a row, whose x and y stand from `x_index`.

        Raises
        ------
        MappingError
            If they are no numbers or lie outside the CRS.
        """
        x, y = row.number(x_index, 'geo_x'), row.number(x_index + 1, 'geo_y')
        longitude, latitude = self.to_wgs84.transform(x, y)
        if not (abs(latitude) <= 90.0 and abs(longitude) <= 180.0):
            raise MappingError(f'{row.where}: geo_x = {x:g}, geo_y = {y:g} lie outside the CRS')
        return latitude, longitude


def read_text(path: Path) -> str:
    """Return the text of a file.

    Raises
    ------
    MappingError
        If it cannot be read, is too large or no UTF-8.
    """
    try:
        require_file(path)
        size = path.stat().st_size
        if size > MOST_BYTES:
            raise MappingError(f'{path}: {size} bytes exceed {MOST_BYTES}')
        return path.read_text('utf-8-sig')
    except OSError as error:
        raise MappingError(f'{path}: {error.strerror}') from error
    except UnicodeDecodeError as error:
        raise MappingError(f'{path}: byte {error.start + 1} is no UTF-8') from error


def read_rows(path: Path) -> tuple[Places, tuple[Row, ...]]:
    """Return what turns the file's coordinates into positions, and its rows.

    Raises
    ------
    MappingError
        If the file cannot be read or its first line names no CRS.
    """
    lines = [(number, line.split()) for number, line in enumerate(read_text(path).splitlines(), 1)]
    lines = [(number, words) for number, words in lines if words and not words[0].startswith('#')]
    if not lines:
        raise MappingError(f'{path}: it is empty')
    number, words = lines[0]
    places = _places(f'{path}: row {number}', ' '.join(words))
    return places, tuple(
        Row(where=f'{path}: row {number}', words=words) for number, words in lines[1:]
    )


def inexactness(places: Places, path: Path) -> str | None:
    """Return a line on coordinates that are known to metres only, None if they are exact.

    `places` has turned a row of the file at `path`.
    """
    if not places.datum_error_m:
        return None
    line = f'{path}: {places.crs} is known in WGS84 to {places.datum_error_m:g} m only'
    if grids := places.missing_grids:
        line += f"; with PROJ's {' and '.join(grids)} it would be exact (PROJ_NETWORK=ON gets it)"
    return line


def _places(where: str, text: str) -> Places:
    """Return what turns coordinates of the CRS called `text` into positions."""
    found = _UTM.fullmatch(text)
    try:
        if found is not None:
            zone = int(found[1])
            if not 1 <= zone <= UTM_ZONES:
                raise MappingError(f'{where}: UTM zone = {zone} must be from 1 to {UTM_ZONES}')
            south = ' +south' if found[2].upper() == 'S' else ''
            text = f'+proj=utm +zone={zone}{south} +datum=WGS84'
        crs = CRS.from_user_input(text)
        with warnings.catch_warnings():  # `missing_grids` tells it
            warnings.simplefilter('ignore', UserWarning)
            to_wgs84 = Transformer.from_crs(crs, WGS84_EPSG, always_xy=True)
        return Places(crs=text, to_wgs84=to_wgs84)
    except ProjError as error:
        raise MappingError(
            f'{where}: CRS = {text[:80]!r} is not known (EPSG:..., +proj=... or WGS84 UTM 16N)'
        ) from error
