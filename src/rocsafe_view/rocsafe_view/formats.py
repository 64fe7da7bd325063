# SPDX-License-Identifier: Apache-2.0
"""Quantities as text: three significant figures and a unit, a dash for what is unknown."""

import math
from datetime import datetime, timezone

from rocsafe_geo.time_units import NS_PER_S

UNKNOWN = '–'
# Between a number and its unit, so that no line breaks there.
GAP = '\u00a0'
_THIN_GAP = '\u202f'
_DOSE_RATE_UNITS = ((1e6, 'Sv/h'), (1e3, 'mSv/h'), (1.0, 'µSv/h'))
_DOSE_UNITS = ((1e6, 'Sv'), (1e3, 'mSv'), (1.0, 'µSv'))
_LEAST_SHOWN = 0.001
_H_PER_YEAR = 8766.0
_CERTAIN = 0.999


def figures(value: float, count: int = 3) -> str:
    """Return `value` with `count` significant figures, thousands apart, never as 1e5."""
    if not math.isfinite(value):
        return UNKNOWN
    if value == 0.0:
        return '0'
    rounded = float(f'{value:.{count - 1}e}')
    digits = max(count - 1 - math.floor(math.log10(abs(rounded))), 0)
    return f'{rounded:,.{digits}f}'.replace(',', _THIN_GAP)


def dose_rate(value_usvh: float | None) -> tuple[str, str]:
    """Return number and unit of a dose rate in microsievert per hour."""
    return _scaled(value_usvh, _DOSE_RATE_UNITS)


def dose(value_usv: float | None) -> tuple[str, str]:
    """Return number and unit of a dose in microsievert."""
    return _scaled(value_usv, _DOSE_UNITS)


def spaced(parts: tuple[str, str]) -> str:
    """Return number and unit as one text that does not break."""
    return GAP.join(part for part in parts if part)


def about(value: float) -> str:
    """Return `value` with two significant figures and without zeros that promise more."""
    text = figures(value, 2)
    return text.rstrip('0').rstrip('.') if '.' in text else text


def stay(hours: float) -> str:
    """Return a time of stay, as ``36 s``, ``12 min``, ``20 h`` or ``330 d``."""
    for limit_h, per_h, unit in ((1 / 60, 3600.0, 's'), (1.0, 60.0, 'min'), (72.0, 1.0, 'h')):
        if hours < limit_h:
            return f'{about(hours * per_h)}{GAP}{unit}'
    return f'{about(hours / 24.0)}{GAP}d' if hours < 10 * _H_PER_YEAR else f'over 10{GAP}years'


def probability(share: float) -> str:
    """Return a probability in per cent; what is not certain is not shown as 100 or 0."""
    if share >= _CERTAIN:
        return f'over {100.0 * _CERTAIN:.1f}{GAP}%'
    if share <= 1.0 - _CERTAIN:
        return f'below {100.0 * (1.0 - _CERTAIN):.1f}{GAP}%'
    percent = 100.0 * share
    # Two figures would make 100 of 99.6.
    text = about(percent) if percent < 99.0 else f'{math.floor(10.0 * percent) / 10.0:.1f}'
    return f'{text}{GAP}%'


def duration(seconds: float | None) -> str:
    """Return a duration as ``6 min 05 s``, ``42.0 s`` or ``1 h 02 min``."""
    if seconds is None or not math.isfinite(seconds):
        return UNKNOWN
    if seconds < 59.95:
        return f'{seconds:.1f}{GAP}s'
    whole = round(seconds)
    if whole < 3600:
        return f'{whole // 60}{GAP}min{GAP}{whole % 60:02d}{GAP}s'
    minutes = round(seconds / 60)
    return f'{minutes // 60}{GAP}h{GAP}{minutes % 60:02d}{GAP}min'


def clock(seconds: float) -> str:
    """Return a time as ``06:05``, from an hour on as ``1:06:05``."""
    minutes, rest = divmod(round(seconds), 60)
    hours, minutes = divmod(minutes, 60)
    return f'{hours}:{minutes:02}:{rest:02}' if hours else f'{minutes:02}:{rest:02}'


def gas_unit(unit: str) -> str:
    """Return the unit of a gas sensor in words."""
    return {'mg_m3': 'mg/m³', 'ppm_m': 'ppm m'}.get(unit, unit)


def length(metres: float | None) -> str:
    """Return a distance in metres, or in kilometres from 10 km on."""
    return _in_units(metres, 'm', 1000.0, 'km')


def _in_units(value: float | None, unit: str, larger: float, larger_unit: str) -> str:
    if value is None or not math.isfinite(value):
        return UNKNOWN
    if value >= 10_000.0:
        return f'{figures(value / larger)}{GAP}{larger_unit}'
    return f'{value:,.0f}'.replace(',', _THIN_GAP) + f'{GAP}{unit}'


_POINTS = ('N', 'NE', 'E', 'SE', 'S', 'SW', 'W', 'NW')


def compass(degrees: float) -> str:
    """Return the nearest of eight directions for an angle clockwise from north."""
    return _POINTS[round(degrees / 45.0) % 8]


def area(square_metres: float | None) -> str:
    """Return an area in square metres, or in hectares from 1 ha on."""
    return _in_units(square_metres, 'm²', 10_000.0, 'ha')


def percent(fraction: float | None, digits: int = 1) -> str:
    """Return a fraction in per cent; only what is all is shown as 100."""
    if fraction is None or not math.isfinite(fraction):
        return UNKNOWN
    if fraction == 1.0:
        return f'100{GAP}%'
    text = f'{100.0 * fraction:.{digits}f}'
    if fraction < 1.0 and float(text) >= 100.0:
        text = f'{100.0 - 10.0**-digits:.{digits}f}'
    return f'{text}{GAP}%'


def upper_percent(fraction: float | None) -> str:
    """Return a fraction in per cent, rounded up to a tenth: a limit stays one."""
    if fraction is None or not math.isfinite(fraction):
        return UNKNOWN
    # A rounding error above a whole tenth does not round up.
    return f'{math.ceil(1000.0 * fraction - 1e-6) / 10.0:.1f}{GAP}%'


def size(count: int) -> str:
    """Return a number of bytes in decimal units."""
    for limit, unit in ((1_000_000, 'MB'), (1_000, 'kB')):
        if count >= limit:
            return f'{figures(count / limit)}{GAP}{unit}'
    return f'{count}{GAP}B'


def whole(count: int | None) -> str:
    """Return a count with thousands apart."""
    return UNKNOWN if count is None else f'{count:,}'.replace(',', _THIN_GAP)


def latitude_longitude(latitude_deg: float, longitude_deg: float) -> str:
    """Return a position in decimal degrees, to a metre, as ``53.27985° N, 9.06330° W``."""
    if not math.isfinite(latitude_deg + longitude_deg):
        return UNKNOWN
    north = 'N' if latitude_deg >= 0.0 else 'S'
    east = 'E' if longitude_deg >= 0.0 else 'W'
    return f'{abs(latitude_deg):.5f}°{GAP}{north}, {abs(longitude_deg):.5f}°{GAP}{east}'


def moment(time_ns: int) -> str:
    """Return a time in UTC as ``1 June 2025, 10:00:00 UTC``."""
    at = datetime.fromtimestamp(time_ns // NS_PER_S, tz=timezone.utc)
    return f'{at.day} {at:%B %Y, %H:%M:%S} UTC'


def sentence_list(parts: list[str]) -> str:
    """Return ``a``, ``a and b`` or ``a, b and c``."""
    return ' and '.join(filter(None, [', '.join(parts[:-1]), parts[-1]])) if parts else ''


def _scaled(value: float | None, units: tuple[tuple[float, str], ...]) -> tuple[str, str]:
    if value is None or not math.isfinite(value):
        return UNKNOWN, ''
    for limit, unit in units:
        if value >= limit:
            return figures(value / limit), unit
    small = units[-1][1]
    if 0.0 < value < _LEAST_SHOWN:
        return f'< {_LEAST_SHOWN}', small
    return figures(value, 2), small
