# SPDX-License-Identifier: Apache-2.0
"""What the report says of releases of gas."""

from dataclasses import dataclass

from markupsafe import Markup

from rocsafe_orchestrator.products.release_estimates import Release, ReleaseEstimates, Zone
from rocsafe_view import formats


@dataclass(frozen=True, slots=True, kw_only=True)
class GasView:
    """The sentence, the moving figure, and the rows of the tables of releases and zones."""

    sentence: str
    figure: Markup
    release_rows: tuple[tuple[str, ...], ...]
    zone_rows: tuple[tuple[str, ...], ...]


def gas_view(found: ReleaseEstimates | None) -> GasView | None:
    """Return what to show, None without estimates."""
    if found is None:
        return None
    end = 'enough' if found.is_enough else 'not enough'
    return GasView(
        sentence=f'{found.agent}, read by {found.sensor}: {found.verdict} ({end}).',
        # Made by our own process, which puts no text of others into it.
        figure=Markup(found.figure),  # noqa: S704
        release_rows=tuple(_release(number, one) for number, one in enumerate(found.releases, 1)),
        zone_rows=tuple(map(_zone, found.zones)),
    )


def _release(number: int, release: Release) -> tuple[str, ...]:
    low, high = release.rate_95_g_s
    return (
        f'{number}',
        f'{release.latitude_deg:.6f}, {release.longitude_deg:.6f}',
        formats.area(release.region_95_m2),
        f'{release.rate_g_s:.3g} g/s ({low:.3g} to {high:.3g})',
    )


def _zone(zone: Zone) -> tuple[str, ...]:
    outer = formats.area(zone.outer_95_m2)
    return (
        zone.level,
        f'{zone.ppm:g} ppm',
        formats.area(zone.expected_m2),
        f'at least {outer}' if zone.is_cut_by_the_map else outer,
    )
