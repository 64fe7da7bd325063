# SPDX-License-Identifier: Apache-2.0
"""A position in the forms that responders use: decimal degrees, DMS, UTM and MGRS.

MGRS after NGA.STND.0037 (2014): the letters of a 100 km square follow from the UTM coordinates;
near the poles, where UPS would be used, there are no UTM and MGRS.
"""

import math
from dataclasses import asdict, dataclass
from functools import lru_cache
from itertools import product

from pyproj import Transformer

from rocsafe_geo.position import GeoPosition

_BANDS = 'CDEFGHJKLMNPQRSTUVWX'
NORTHERN_BANDS = _BANDS[_BANDS.index('N') :]
_COLUMNS = ('ABCDEFGH', 'JKLMNPQR', 'STUVWXYZ')
_ROWS = ('ABCDEFGHJKLMNPQRSTUV', 'FGHJKLMNPQRSTUVABCDE')
_SOUTHERN_LIMIT_DEG, _NORTHERN_LIMIT_DEG = -80.0, 84.0
_SQUARE_M = 100_000
# About 40 km, by which grids are printed beyond their zone.
_OVERLAPS_DEG = (-0.4, 0.0, 0.4)


@dataclass(frozen=True, slots=True, kw_only=True)
class Coordinates:
    """One position in all forms; `utm` and `mgrs` are empty near the poles."""

    decimal: str
    dms: str
    utm: str
    mgrs: str


def coordinates_of(latitude_deg: float, longitude_deg: float) -> Coordinates:
    """Return a WGS84 position in all forms, each to a metre or finer.

    Raises
    ------
    ValueError
        If the position is not on the earth.
    """
    if not is_on_earth(latitude_deg, longitude_deg):
        raise ValueError(
            f'latitude {latitude_deg}, longitude {longitude_deg}: must be within -90 and 90, '
            '-180 and 180 degrees'
        )
    utm, mgrs = _grid(latitude_deg, longitude_deg)
    return Coordinates(
        decimal=f'{latitude_deg:.6f}, {longitude_deg:.6f}',
        dms=f'{_dms(latitude_deg, "NS")} {_dms(longitude_deg, "EW")}',
        utm=utm,
        mgrs=mgrs,
    )


def is_on_earth(latitude_deg: float, longitude_deg: float) -> bool:
    """Return whether there is such a position; NaN is none."""
    return -90.0 <= latitude_deg <= 90.0 and -180.0 <= longitude_deg <= 180.0


def forms_of(latitude_deg: float, longitude_deg: float) -> dict[str, str] | None:
    """Return a position in all forms, fit for JSON; None if it is unknown or impossible."""
    if not is_on_earth(latitude_deg, longitude_deg):
        return None
    return asdict(coordinates_of(latitude_deg, longitude_deg))


def position_of_ecef(x_m: float, y_m: float, z_m: float) -> GeoPosition:
    """Return the WGS84 position of earth-centred coordinates in metres."""
    longitude, latitude, altitude = _from_ecef().transform(x_m, y_m, z_m)
    return GeoPosition(latitude, longitude, altitude)


def _dms(value_deg: float, letters: str) -> str:
    """Return degrees, minutes and seconds to a hundredth, never 60 of them."""
    hundredths = round(abs(value_deg) * 360_000)
    degrees, rest = divmod(hundredths, 360_000)
    minutes, rest = divmod(rest, 6_000)
    return f'{degrees}°{minutes:02d}\u2032{rest / 100:05.2f}\u2033{letters[value_deg < 0.0]}'


def zone_of(latitude_deg: float, longitude_deg: float) -> int:
    """Return the UTM zone, with the exceptions of Norway and Svalbard."""
    zone = min(int((longitude_deg + 180.0) // 6.0) + 1, 60)
    if 56.0 <= latitude_deg < 64.0 and 3.0 <= longitude_deg < 12.0:
        return 32
    if latitude_deg >= 72.0 and 0.0 <= longitude_deg < 42.0:
        return next(z for z, east in ((31, 9.0), (33, 21.0), (35, 33.0), (37, 42.0))
                    if longitude_deg < east)  # fmt: skip
    return zone


def _grid(latitude_deg: float, longitude_deg: float) -> tuple[str, str]:
    if not _SOUTHERN_LIMIT_DEG <= latitude_deg <= _NORTHERN_LIMIT_DEG:
        return '', ''
    zone = zone_of(latitude_deg, longitude_deg)
    band = _band(latitude_deg)
    east, north = _to_utm(zone, band < 'N').transform(longitude_deg, latitude_deg)
    # Truncated and not rounded, as MGRS demands: a square keeps its points.
    east_m, north_m = math.floor(east), max(math.floor(north), 0)
    column = _COLUMNS[(zone - 1) % 3][east_m // _SQUARE_M - 1]
    row = _ROWS[(zone - 1) % 2][north_m // _SQUARE_M % 20]
    square = f'{east_m % _SQUARE_M:05d} {north_m % _SQUARE_M:05d}'
    return f'{zone}{band} {east_m} {north_m}', f'{zone}{band} {column}{row} {square}'


def from_utm(zone: int, bands: str, east_m: float, north_m: float) -> tuple[float, float]:
    """Return latitude and longitude of UTM coordinates, degrees.

    Parameters
    ----------
    bands
        Letters of MGRS, of which it must be one.

    Raises
    ------
    ValueError
        If they lie outside of the zone or the band: a figure or a letter is wrong, and the place
        may be a thousand kilometres away.
    """
    if not 1 <= zone <= 60:
        raise ValueError(f'zone {zone}: must be 1 to 60')
    to_utm = _to_utm(zone, bands < 'N')
    longitude, latitude = to_utm.transform(east_m, north_m, direction='INVERSE')
    if not _is_in(zone, bands, latitude, longitude):
        raise ValueError(f'{east_m:.0f} {north_m:.0f} m are not in zone {zone}, band {bands[0]}')
    return latitude, longitude


def _is_in(zone: int, bands: str, latitude_deg: float, longitude_deg: float) -> bool:
    """Return whether a place lies in a zone and one of some bands, or close to both."""
    if not _SOUTHERN_LIMIT_DEG <= round(latitude_deg, 3) <= _NORTHERN_LIMIT_DEG:
        return False
    latitudes = [latitude_deg + one for one in _OVERLAPS_DEG]
    wider = 1.0 / math.cos(math.radians(latitude_deg))
    longitudes = [(longitude_deg + wider * one + 180.0) % 360.0 - 180.0 for one in _OVERLAPS_DEG]
    zones = {zone_of(*place) for place in product(latitudes, longitudes)}
    return zone in zones and any(_band(latitude) in bands for latitude in latitudes)


def _band(latitude_deg: float) -> str:
    return _BANDS[min(max(int((latitude_deg + 80.0) // 8.0), 0), len(_BANDS) - 1)]


def square_corner_m(zone: int, band: str, column: str, row: str) -> tuple[float, float]:
    """Return UTM east and north of the corner of a 100 km square of MGRS, metres.

    Raises
    ------
    ValueError
        If the zone has no such square.
    """
    columns, rows = _COLUMNS[(zone - 1) % 3], _ROWS[(zone - 1) % 2]
    if column not in columns or row not in rows:
        raise ValueError(f'MGRS {zone}{band} {column}{row}: there is no such square')
    east_m = (columns.index(column) + 1) * _SQUARE_M
    # Rows repeat each 2000 km: the one that the band begins in, or the next.
    south_deg = -80.0 + 8.0 * _BANDS.index(band)
    middle_deg = zone * 6.0 - 183.0
    _, least_m = _to_utm(zone, band < 'N').transform(middle_deg, south_deg)
    north_m = rows.index(row) * _SQUARE_M
    while north_m + _SQUARE_M <= least_m:
        north_m += len(rows) * _SQUARE_M
    return float(east_m), float(north_m)


@lru_cache(maxsize=8)
def _to_utm(zone: int, is_south: bool) -> Transformer:
    code = (32700 if is_south else 32600) + zone
    return Transformer.from_crs('EPSG:4326', f'EPSG:{code}', always_xy=True)


@lru_cache(maxsize=1)
def _from_ecef() -> Transformer:
    return Transformer.from_crs('EPSG:4978', 'EPSG:4979', always_xy=True)
