# SPDX-License-Identifier: Apache-2.0
"""Positions of photographs from OpenDroneMap's image geolocation file, ``geo.txt``.

Rows are ``name x y [z] [yaw] [pitch] [roll] [horz accuracy] [vert accuracy]``. The angles are not
used: there 0 also means that an angle is not known.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_mapping.photographs.survey_file import inexactness, read_rows

HORIZONTAL, VERTICAL = 7, 8
LEAST_ACCURACY_M, LARGEST_ACCURACY_M = 1e-4, 1e5


@dataclass(frozen=True, slots=True, kw_only=True)
class Geolocation:
    """Place at which a photograph was taken.

    Attributes
    ----------
    latitude_deg, longitude_deg, altitude_m
        WGS84; the altitude as it stands in the file, NaN if unknown.
    covariance_m2
        East, north, up, row major; zeros where unknown.
    datum_error_m
        How exactly its CRS is known in WGS84: all places of a file are off alike.
    """

    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    covariance_m2: tuple[float, ...]
    datum_error_m: float

    def of(self, record: ShotRecord) -> ShotRecord:
        """Return `record` with this position."""
        return dataclasses.replace(
            record,
            latitude_deg=self.latitude_deg,
            longitude_deg=self.longitude_deg,
            altitude_m=self.altitude_m,
            position_covariance_m2=self.covariance_m2,
        )


def read_geolocations(path: Path, notice: Callable[[str], None]) -> dict[str, Geolocation]:
    """Return the positions of a ``geo.txt`` by file name in lower case.

    `notice` is told of a CRS that is known to some metres only.

    Raises
    ------
    MappingError
        If it cannot be read; the message names file, row and value.
    """
    places, rows = read_rows(path)
    found: dict[str, Geolocation] = {}
    for row in rows:
        name = row.words[0].lower()
        if name in found:
            raise MappingError(f'{row.where}: image_name = {row.words[0]!r} stands there twice')
        latitude, longitude = places.position(row, 1)
        variances = [
            row.number(index, kind, LEAST_ACCURACY_M, LARGEST_ACCURACY_M) ** 2
            if len(row.words) > index
            else 0.0
            for index, kind in ((HORIZONTAL, 'horz_accuracy'), (VERTICAL, 'vert_accuracy'))
        ]
        found[name] = Geolocation(
            latitude_deg=latitude,
            longitude_deg=longitude,
            altitude_m=row.height(3),
            covariance_m2=(
                variances[0], 0.0, 0.0, 0.0, variances[0], 0.0, 0.0, 0.0, variances[1],
            ),
            datum_error_m=places.datum_error_m,
        )  # fmt: skip
    if not found:
        raise MappingError(f'{path}: it names no photograph')
    if line := inexactness(places, path):
        notice(line)
    return found


def located(
    records: Mapping[str, ShotRecord],
    found: Mapping[str, Geolocation],
    notice: Callable[[str], None],
) -> dict[str, ShotRecord]:
    """Return the records by file name, with the positions of those in `found`.

    `notice` is told of places of photographs that are not there.

    Raises
    ------
    MappingError
        If no photograph is in `found`.
    """
    unknown: Sequence[str] = sorted(set(found) - {name.lower() for name in records})
    if len(unknown) == len(found):
        raise MappingError(f'no photograph is called {unknown[0]!r} or as the other rows say')
    for name in unknown:
        notice(f'no photograph is called {name}: its place is not used')
    return {
        name: found[name.lower()].of(record) if name.lower() in found else record
        for name, record in records.items()
    }
