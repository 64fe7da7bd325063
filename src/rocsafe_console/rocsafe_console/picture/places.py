# SPDX-License-Identifier: Apache-2.0
"""Reads a place as somebody types it or a radio tells it: degrees, DMS, UTM or MGRS."""

import math
import re

from rocsafe_console.picture.coordinates import (
    NORTHERN_BANDS,
    coordinates_of,
    from_utm,
    square_corner_m,
)

MOST_LETTERS = 80
_NUMBER = r'[+-]?\d+(?:\.\d+)?'
_DECIMAL = re.compile(
    rf'({_NUMBER})\s*°?\s*([NS])?[\s,;]+({_NUMBER})\s*°?\s*([EW])?', re.IGNORECASE
)
_ANGLE = (
    r'(\d{1,3})\s*[°\s]\s*(\d{1,2}(?:\.\d+)?)\s*[\u2032\x27\s]?\s*'
    r'(?:(\d{1,2}(?:\.\d+)?)\s*(?:[\u2033"]|\x27\x27)?)?\s*'
)
_DMS = re.compile(rf'{_ANGLE}([NS])[\s,;]*{_ANGLE}([EW])', re.IGNORECASE)
_UTM = re.compile(
    r'(\d{1,2})([C-HJ-NP-X])\s+(\d{6,7}(?:\.\d+)?)\s+(\d{1,8}(?:\.\d+)?)', re.IGNORECASE
)
_MGRS = re.compile(
    r'(\d{1,2})([C-HJ-NP-X])\s*([A-HJ-NP-Z])([A-HJ-NP-V])\s*(\d{1,5})\s*(\d{1,5})', re.IGNORECASE
)
_MGRS_CLOSED = re.compile(
    r'(\d{1,2})([C-HJ-NP-X])\s*([A-HJ-NP-Z])([A-HJ-NP-V])\s*((?:\d\d){1,5})', re.IGNORECASE
)
# As receivers show it: the letters first.
_LETTERS_FIRST = re.compile(r'([NS])\s*([^NSEW]+?)[\s,;]*([EW])\s*([^NSEW]+)', re.IGNORECASE)
# A number with a comma is refused: it may be one decimal number, or two numbers.
_COMMA = re.compile(r'[+-]?\d+,\d+')
_FORMS = '53.2800, -9.0633; 53°16\u203248\u2033N 9°03\u203248\u2033W; 29U MV 29125 03560'


def place_of_text(text: str) -> tuple[float, float]:
    """Return latitude and longitude of a place, WGS84 degrees.

    Parameters
    ----------
    text
        Decimal degrees, degrees with minutes and seconds, UTM or MGRS.

    Raises
    ------
    ValueError
        If it is none of these, or not on the earth.
    """
    text = text.strip()[:MOST_LETTERS]
    if _COMMA.fullmatch(text):
        raise ValueError(f'place {text!r}: write a point for decimals, and two numbers')
    if letters := _LETTERS_FIRST.fullmatch(text):
        text = '{1} {0} {3} {2}'.format(*letters.groups())
    for form, read in (
        (_DMS, _of_dms), (_DECIMAL, _of_decimal), (_MGRS_CLOSED, _of_closed_mgrs),
        (_MGRS, _of_mgrs), (_UTM, _of_utm),
    ):  # fmt: skip
        found = form.fullmatch(text)
        if found is not None:
            latitude_deg, longitude_deg = read(*found.groups())
            coordinates_of(latitude_deg, longitude_deg)
            return latitude_deg, longitude_deg
    raise ValueError(f'place {text!r}: must be like {_FORMS}')


def _of_decimal(
    latitude: str, north: str | None, longitude: str, east: str | None
) -> tuple[float, float]:
    return _signed(float(latitude), north), _signed(float(longitude), east)


def _of_dms(*parts: str | None) -> tuple[float, float]:
    latitude, longitude = (_of_angle(*angle) for angle in (parts[:4], parts[4:]))
    return latitude, longitude


def _of_angle(
    degrees: str | None, minutes: str | None, seconds: str | None, letter: str | None
) -> float:
    parts = [float(part or 0) for part in (minutes, seconds)]
    if max(parts) >= 60.0:
        raise ValueError(f'{minutes}\u2032 {seconds or 0}\u2033: must be below 60')
    return _signed(float(degrees or 0) + parts[0] / 60.0 + parts[1] / 3600.0, letter)


def _of_utm(zone: str, band: str, east_m: str, north_m: str) -> tuple[float, float]:
    # Programs of maps write N for the northern half, whatever the band.
    bands = NORTHERN_BANDS if band.upper() == 'N' else band.upper()
    return from_utm(int(zone), bands, float(east_m), float(north_m))


def _of_closed_mgrs(
    zone: str, band: str, column: str, row: str, digits: str
) -> tuple[float, float]:
    half = len(digits) // 2
    return _of_mgrs(zone, band, column, row, digits[:half], digits[half:])


def _of_mgrs(
    zone: str, band: str, column: str, row: str, east: str, north: str
) -> tuple[float, float]:
    """Return the middle of a square of MGRS; both numbers must have as many digits."""
    if len(east) != len(north):
        raise ValueError(f'MGRS {east} {north}: both numbers must have as many digits')
    corner_m = square_corner_m(int(zone), band.upper(), column.upper(), row.upper())
    step_m = 10.0 ** (5 - len(east))
    # A square of a metre is named by its corner; a coarser one is meant as a whole.
    middle_m = step_m / 2.0 if step_m > 1.0 else 0.0
    east_m, north_m = (
        corner + int(digits) * step_m + middle_m
        for corner, digits in zip(corner_m, (east, north), strict=True)
    )
    return from_utm(int(zone), band.upper(), east_m, north_m)


def _signed(value: float, letter: str | None) -> float:
    return (
        -abs(value)
        if letter is not None and letter.upper() in 'SW'
        else math.copysign(1, value) * abs(value)
    )
