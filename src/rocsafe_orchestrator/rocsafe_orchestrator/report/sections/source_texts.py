# SPDX-License-Identifier: Apache-2.0
"""An estimated source in words: position, probability, strength."""

from rocsafe_orchestrator.products.source_estimates import SourceEstimate, SourceEstimates
from rocsafe_view import formats

# Positions are not surveyed better, whatever the readings say.
_LEAST_SHOWN_M = 0.1


def strongest(found: SourceEstimates | None) -> SourceEstimate | None:
    """Return the strongest of the sources found, None if there is none."""
    sources = found.sources if found else ()
    return max(sources, key=lambda source: source.dose_rate_at_1m_usvh, default=None)


def place_of(source: SourceEstimate) -> str:
    """Return where it is."""
    return formats.latitude_longitude(source.position.latitude_deg, source.position.longitude_deg)


def half_axes_of(source: SourceEstimate) -> str:
    """Return the half axes of the ellipse in which it is with 95 %."""
    long_m, short_m = source.ellipse_95_m
    if long_m < _LEAST_SHOWN_M:
        return f'below {_LEAST_SHOWN_M:g}{formats.GAP}m'
    return f'{formats.about(long_m)} × {formats.about(short_m)}{formats.GAP}m'


def dose_rate_of(source: SourceEstimate, *, is_range: bool = False) -> str:
    """Return its dose rate at 1 m, with the bounds between which that is with 95 %.

    With `is_range` the bounds alone.
    """
    low, mean, high = (
        formats.spaced(formats.dose_rate(rate))
        for rate in (
            source.dose_rate_at_1m_95_usvh[0],
            source.dose_rate_at_1m_usvh,
            source.dose_rate_at_1m_95_usvh[1],
        )
    )
    return f'{low} to {high}' if is_range else f'{mean} ({low} to {high})'
