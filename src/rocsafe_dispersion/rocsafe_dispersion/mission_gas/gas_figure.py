# SPDX-License-Identifier: Apache-2.0
"""A figure of readings and plume over time: one SVG that moves by itself and needs no script."""

import math
import textwrap
from collections.abc import Iterable, Iterator, Sequence

import numpy as np
from shapely.geometry import MultiPolygon

from rocsafe_dispersion.mission_gas.release_assessment import ReleaseAssessment
from rocsafe_dispersion.zones.threat_zones import lines_at
from rocsafe_geo.scale_bar import bar_length_m

# The figure shows the flight in so many seconds, then rests, then begins again.
LASTS_S, RESTS_S = 12.0, 4.0
# The width of a phone's page, so that its letters can be read there.
WIDTH_PX, HEAD_PX = 480.0, 33.0
# Letters that a line of the head holds, and its height.
LINE_LETTERS, LINE_PX = 60, 17.0
LEVEL_COLOURS = ('#e0b000', '#e07000', '#c00000')
# The plume on its way: where the mean wind has carried the gas after these times, seconds.
ISOCHRONES_S = (30.0, 60.0, 120.0, 300.0)
# Within a page the style must reach no other figure.
STYLE = (
    '.gas-figure text{font:13px sans-serif;fill:currentColor}.gas-figure .zone{fill:none}'
    '.gas-figure .way{fill:none;stroke:#777;stroke-dasharray:4 4}'
    '.gas-figure .source{fill:none;stroke:currentColor;stroke-width:2}'
)


def gas_figure(assessment: ReleaseAssessment) -> str:
    """Return the figure: each reading appears at its time, zones and releases lie below.

    The area of a circle grows with the logarithm of the concentration above the noise.
    """
    area = assessment.area
    width, height = area.east_m - area.west_m, area.north_m - area.south_m
    scale = WIDTH_PX / width
    shapes = [*_zones(assessment), *_isochrones(assessment), *_readings(assessment)]
    for release in assessment.found.releases:
        east, north = release.place_m
        radius = max(release.region_radius_m, 1.0)
        shapes.append(
            f'<circle class="source" cx="{east:.1f}" cy="{-north:.1f}" r="{radius:.1f}" '
            'vector-effect="non-scaling-stroke"/>'
        )
    words = f'{assessment.flight.agent.name}: {assessment.verdict.reason}'
    lines = textwrap.wrap(words, LINE_LETTERS)
    key_px = LINE_PX * len(lines)
    head_px = HEAD_PX + key_px + LINE_PX * bool(assessment.zones)
    texts = ''.join(
        f'<text x="4" y="{LINE_PX * number:.0f}">{line}</text>'
        for number, line in enumerate(lines, start=1)
    )
    return (
        f'<svg xmlns="http://www.w3.org/2000/svg" class="gas-figure" viewBox="0 0 {WIDTH_PX:.0f} '
        f'{height * scale + head_px:.0f}" role="img"><title>Readings of gas over time</title>'
        f'<style>{STYLE}</style><svg y="{head_px:.0f}" width="{WIDTH_PX:.0f}" '
        f'height="{height * scale:.0f}" '
        f'viewBox="{area.west_m:.1f} {-area.north_m:.1f} {width:.1f} {height:.1f}">'
        f'{"".join(shapes)}</svg>{texts}'
        f'<g transform="translate(0 {key_px - LINE_PX:.0f})">{_key(assessment, scale)}</g></svg>\n'
    )


def _key(assessment: ReleaseAssessment, scale_px: float) -> str:
    """Return wind and length above the figure, levels below them; `scale_px` is that of 1 m."""
    east, north = assessment.flight.wind_towards_mps
    length_m = bar_length_m(WIDTH_PX / 6.0 / scale_px)
    bar_px = length_m * scale_px
    turn = f'translate(16 38) rotate({_turn_deg(east, north):.0f})'
    parts = [
        f'<path class="source" transform="{turn}" d="M-10 0H10M4 -5L10 0L4 5"/>',
        f'<text x="32" y="42">wind {math.hypot(east, north):.1f} m/s</text>',
        f'<path class="source" d="M150 34V40H{150.0 + bar_px:.1f}V34"/>',
        f'<text x="{156.0 + bar_px:.1f}" y="42">{length_m:g} m</text>',
    ]
    for number, zone in enumerate(assessment.zones):
        x, colour = 6 + 120 * number, LEVEL_COLOURS[int(zone.level.name[-1]) - 1]
        parts.append(f'<path class="zone" stroke="{colour}" stroke-width="3" d="M{x} 55h16"/>')
        parts.append(f'<text x="{x + 26}" y="59">{zone.level.name}</text>')
    return ''.join(parts)


def _turn_deg(east: float, north: float) -> float:
    """Return the angle clockwise from the right, degrees, of an arrow in a figure."""
    return -math.degrees(math.atan2(north, east))


def _readings(assessment: ReleaseAssessment) -> Iterator[str]:
    survey = assessment.flight.survey
    places = survey.places_m.mean(axis=1)
    logs = np.log1p(np.maximum(survey.values_g_m3 / survey.std_g_m3, 0.0))
    share = logs / max(float(logs.max()), 1.0)
    span = max(float(np.ptp(survey.times_s)), 1e-9)
    begins = (survey.times_s - survey.times_s.min()) / span * LASTS_S / (LASTS_S + RESTS_S)
    size = (assessment.area.east_m - assessment.area.west_m) / 100.0
    for place, part, begin in zip(places, share.tolist(), begins.tolist(), strict=True):
        keys = f'0;{max(begin, 1e-4):.4f};{max(begin, 1e-4) + 1e-4:.4f};1'
        yield (
            f'<circle cx="{place[0]:.1f}" cy="{-place[1]:.1f}" '
            f'r="{size * (0.3 + 1.2 * part**0.5):.2f}" fill="{_colour(part)}" '
            'fill-opacity="0.8"><animate attributeName="opacity" repeatCount="indefinite" '
            f'dur="{LASTS_S + RESTS_S:g}s" values="0;0;1;1" keyTimes="{keys}"/></circle>'
        )


def _zones(assessment: ReleaseAssessment) -> Iterator[str]:
    for zone in assessment.zones:
        colour = LEVEL_COLOURS[int(zone.level.name[-1]) - 1]
        for shape, width in ((zone.expected, 2.0), (zone.outer, 0.8)):
            yield (
                f'<path class="zone" stroke="{colour}" stroke-width="{width:g}" '
                f'vector-effect="non-scaling-stroke" d="{_path(shape)}"><title>'
                f'{zone.level.label}</title></path>'
            )


def _isochrones(assessment: ReleaseAssessment) -> Iterator[str]:
    """Yield the lines that the gas has reached after each time."""
    plume = assessment.plume
    if plume is None:
        return
    for time_s in ISOCHRONES_S:
        way = ''.join(map(_line, lines_at(plume.grid, plume.arrival_s, time_s)))
        yield (
            f'<path class="way" vector-effect="non-scaling-stroke" d="{way}">'
            f'<title>{time_s:g} s</title></path>'
        )


def _path(area: MultiPolygon) -> str:
    rings = (ring for part in area.geoms for ring in (part.exterior, *part.interiors))
    return ''.join(_line(ring.coords) + 'Z' for ring in rings)


def _line(points: Iterable[Sequence[float]]) -> str:
    return 'M' + 'L'.join(f'{point[0]:.1f} {-point[1]:.1f}' for point in points)


def _colour(share: float) -> str:
    """Return grey for clean air to dark red for the highest reading."""
    red, green, blue = (
        round(low + share * (high - low)) for low, high in ((190, 160), (190, 0), (190, 30))
    )
    return f'#{red:02x}{green:02x}{blue:02x}'
