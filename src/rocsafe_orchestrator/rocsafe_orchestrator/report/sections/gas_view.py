# SPDX-License-Identifier: Apache-2.0
"""What the report says of releases of gas."""

from collections.abc import Sequence
from dataclasses import dataclass

from markupsafe import Markup

from rocsafe_orchestrator.products.release_estimates import Release, ReleaseEstimates, Zone
from rocsafe_view import formats
from rocsafe_view.map_marks import GasZone

# Levels from this number on may do lasting harm: AEGL-2 and ERPG-2.
LASTING_HARM = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class GasView:
    """Sentences, the moving figure, and the rows of the tables of releases and zones."""

    sentence: str
    leave: str
    figure: Markup
    release_rows: tuple[tuple[str, ...], ...]
    zone_rows: tuple[tuple[str, ...], ...]


def gas_view(found: ReleaseEstimates | None, zones: Sequence[GasZone]) -> GasView | None:
    """Return what to show, None without estimates."""
    if found is None:
        return None
    end = 'enough' if found.is_enough else 'not enough'
    told = f'{found.agent}, read by {found.sensor_name}: {found.verdict} ({end}).'
    return GasView(
        sentence=f'{told} {_wind(found)}',
        leave=_leave(zones),
        # Made by our own process, which puts no text of others into it.
        figure=Markup(found.figure),  # noqa: S704
        release_rows=tuple(_release(number, one) for number, one in enumerate(found.releases, 1)),
        zone_rows=tuple(map(_zone, found.zones)),
    )


def _wind(found: ReleaseEstimates) -> str:
    wind = found.wind
    return (
        f'Wind as measured in flight, on average: {wind.speed_mps:.1f}{formats.GAP}m/s from '
        f'{wind.from_deg:.0f}°.'
    )


def _leave(zones: Sequence[GasZone]) -> str:
    """Return where people leave; empty where no level of lasting harm may be exceeded."""
    if (zone := next((one for one in zones if one.number == LASTING_HARM), None)) is None:
        return ''
    return (
        f'People leave the ground within the outer bound of {zone.level} ({zone.ppm:g} ppm over '
        f'{zone.minutes:g} minutes: lasting harm, or too ill to leave). It reaches '
        f'{zone.reach_text} of the release, and is on the map, over the photographs.'
    )


def _release(number: int, release: Release) -> tuple[str, ...]:
    low, high = release.rate_95
    return (
        f'{number}',
        f'{release.latitude_deg:.6f}, {release.longitude_deg:.6f}',
        formats.area(release.region_95_m2),
        f'{release.rate:.3g} {release.rate_unit} ({low:.3g} to {high:.3g})',
    )


def _zone(zone: Zone) -> tuple[str, ...]:
    outer = formats.area(zone.outer_95_m2)
    return (
        zone.level,
        f'{zone.ppm:g} ppm',
        formats.area(zone.expected_m2),
        f'at least {outer}' if zone.is_cut_by_the_map else outer,
    )
