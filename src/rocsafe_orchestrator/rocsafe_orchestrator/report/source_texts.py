# SPDX-License-Identifier: Apache-2.0
"""A source as estimated in words: where it is, how surely, how strong."""

from rocsafe_orchestrator.products.source_estimates import SourceEstimate
from rocsafe_view import formats


def place_of(source: SourceEstimate) -> str:
    """Return where it is."""
    return formats.latitude_longitude(source.position.latitude_deg, source.position.longitude_deg)


def half_axes_of(source: SourceEstimate) -> str:
    """Return the half axes of the ellipse in which it is with 95 %."""
    long_m, short_m = source.ellipse_95_m
    return f'{long_m:.2g} × {short_m:.2g}{formats.GAP}m'


def dose_rate_of(source: SourceEstimate) -> str:
    """Return its dose rate at 1 m, with the bounds between which that is with 95 %."""
    low, mean, high = (
        formats.spaced(formats.dose_rate(rate))
        for rate in (
            source.dose_rate_at_1m_95_usvh[0],
            source.dose_rate_at_1m_usvh,
            source.dose_rate_at_1m_95_usvh[1],
        )
    )
    return f'{mean} ({low} to {high})'
