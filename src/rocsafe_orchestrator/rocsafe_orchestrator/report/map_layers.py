# SPDX-License-Identifier: Apache-2.0
"""The layers of the map, each a group of SVG in map coordinates.

Lines keep their width at every zoom (``non-scaling-stroke``); marks keep their size through the
custom property ``--k``, metres of the map in one pixel of the screen.
"""

import math
from collections.abc import Iterable, Iterator, Mapping, Sequence

from rocsafe_orchestrator.products.summary import HighestReading
from rocsafe_orchestrator.report import formats
from rocsafe_orchestrator.report.map_data import DosePoint, MapData, SourcePoint
from rocsafe_orchestrator.report.markup import Markup, element, number, style
from rocsafe_orchestrator.report.palette import DoseScale, ramp_colour
from rocsafe_orchestrator.report.pictures import GroundPicture
from rocsafe_orchestrator.report.plan_data import Point

COLOUR_STEPS = 32
# Readings further apart in time are not joined: nothing was measured between them.
MOST_GAP_S = 2.5
MOST_LABELLED_VEHICLES = 10
_METRE_DIGITS = 1


def ground_layer(picture: GroundPicture | None) -> Markup:
    """Return the mosaic."""
    if picture is None:
        return layer('ground')
    matrix = ' '.join(f'{value:.9g}' for value in picture.matrix)
    image = element(
        'image',
        href=picture.data_uri,
        width=picture.width_px,
        height=picture.height_px,
        transform=f'matrix({matrix})',
        preserveAspectRatio='none',
    )
    return layer('ground', image)


def region_layer(data: MapData) -> Markup:
    """Return the outline of the region and of its holes."""
    rings = ' '.join(f'{_polyline(ring)}Z' for ring in data.region)
    return layer(
        'region',
        element('path', class_='region-casing', d=rings),
        element('path', class_='region', d=rings),
    )


def exclusions_layer(data: MapData) -> Markup:
    """Return the zones that no leg crosses."""
    rings = ' '.join(f'{_polyline(ring)}Z' for ring in data.exclusions)
    zones = [element('path', class_='exclusion', d=rings)] if rings else []
    return layer('exclusions', zones)


def planned_layer(data: MapData, colours: Mapping[str, str]) -> Markup:
    """Return the ground that the photographs are planned to show, by vehicle."""
    return layer(
        'planned',
        (
            element(
                'path',
                class_='survey-footprint',
                d=''.join(f'{_polyline(ring)}Z' for ring in rings),
                stroke=colours[name],
                fill=colours[name],
            )
            for name, rings in data.planned.items()
            if rings
        ),
    )


def routes_layer(data: MapData) -> Markup:
    """Return the planned routes, dashed."""
    return layer(
        'routes',
        (
            element('path', class_='route', d=_polyline(route), data_vehicle=name)
            for name, route in data.routes.items()
        ),
    )


def tracks_layer(data: MapData, colours: Mapping[str, str]) -> Markup:
    """Return the flown tracks, solid, in the colours of the vehicles."""
    lines = [(name, _polyline(track)) for name, track in data.tracks.items()]
    return layer(
        'tracks',
        (element('path', class_='track-casing', d=line) for _, line in lines),
        (
            element('path', class_='track', d=line, stroke=colours[name], data_vehicle=name)
            for name, line in lines
        ),
    )


def readings_layer(data: MapData, scale: DoseScale) -> Markup:
    """Return the dose rates along the tracks: one path for each of some colours."""
    strokes: dict[int, list[str]] = {}
    for step, line in _coloured_lines(data.readings, scale):
        strokes.setdefault(step, []).append(_polyline(line))
    return layer(
        'readings',
        (
            element(
                'path', d=''.join(strokes[step]), stroke=ramp_colour(step / (COLOUR_STEPS - 1))
            )
            for step in sorted(strokes)
        ),
    )


def photos_layer(data: MapData) -> Markup:
    """Return a mark for each photograph."""
    return layer(
        'photos',
        (
            pin(
                (photo.x, photo.y),
                element('rect', class_='photo-mark', x=-5, y=-4, width=10, height=8, rx=1.5),
                element('circle', class_='photo-lens', r=1.9),
                class_='photo',
                data_shot=photo.shot_id,
            )
            for photo in data.photos
        ),
    )


def sources_layer(data: MapData) -> Markup:
    """Return the true sources of the scenario, labelled as truth."""
    return layer(
        'sources',
        (
            pin(
                (source.x, source.y),
                element('circle', class_='source-disc', r=10),
                (element('path', class_='source-blade', d=_BLADE, transform=f'rotate({angle})')
                 for angle in (0, 120, 240)),
                element('circle', class_='source-core', r=1.8),
                _label(f'{source.name} (truth)', 21),
                class_='source',
            )
            for source in data.sources
        ),
    )  # fmt: skip


def estimates_layer(data: MapData) -> Markup:
    """Return the estimated sources, each with the ellipse that holds it with 95 %."""
    ellipses = (
        element(
            'ellipse',
            class_='estimate-ellipse',
            rx=number(source.half_axes_m[0]),
            ry=number(source.half_axes_m[1]),
            transform=f'translate({number(source.x)} {number(source.y)}) '
            f'rotate({number(-source.angle_deg)})',
        )
        for source in data.estimates
    )
    marks = (
        pin(
            (source.x, source.y),
            element('path', class_='estimate', d='M-15 0H-4M4 0H15M0 -15V-4M0 4V15'),
            _label(f'source {index} (estimated)', 20, side='left'),
        )
        for index, source in enumerate(data.estimates, 1)
    )
    return layer('estimates', ellipses, marks)  # fmt: skip


def homes_layer(data: MapData, colours: Mapping[str, str]) -> Markup:
    """Return where the vehicles start and land, named unless there are too many."""
    is_named = len(data.homes) <= MOST_LABELLED_VEHICLES
    return layer(
        'homes',
        (
            pin(
                place,
                element('circle', class_='home', r=6, stroke=colours[name]),
                _label(f'{name} home', 12) if is_named else None,
            )
            for name, place in data.homes.items()
        ),
    )


def labels_layer(data: MapData, colours: Mapping[str, str]) -> Markup:
    """Return the name of each vehicle where its survey begins, unless there are too many."""
    if len(data.viewpoints) > MOST_LABELLED_VEHICLES:
        return layer('labels')
    return layer(
        'labels',
        (
            pin(
                viewpoints[0],
                element(
                    'rect', class_='tag', x=-_tag_width(name) / 2, y=-29, width=_tag_width(name),
                    height=17, rx=8.5, fill=colours[name],
                ),
                element('path', class_='tag', d='M-4 -13H4L0 -7Z', fill=colours[name]),
                element('text', name, class_='tag-text', y=-17),
            )
            for name, viewpoints in data.viewpoints.items()
            if viewpoints
        ),
    )  # fmt: skip


def highest_layer(
    highest: HighestReading | None, place: Point | None, sources: Sequence[SourcePoint] = ()
) -> Markup:
    """Return a ring around the place of the highest reading, its name away from the sources'."""
    if highest is None or place is None:
        return layer('highest')
    text = f'highest {formats.spaced(formats.dose_rate(highest.dose_rate_usvh))}'
    return layer(
        'highest',
        pin(
            place,
            element('circle', class_='highest-casing', r=16),
            element('circle', class_='highest', r=16),
            _label(text, 20, side=_free_side(place, sources)),
        ),
    )


def _free_side(place: Point, sources: Sequence[SourcePoint]) -> str:
    """Return above or below: names of sources stand beside these. South is down: y grows."""
    nearest = min(
        sources, key=lambda one: math.hypot(one.x - place[0], one.y - place[1]), default=None
    )
    return 'above' if nearest is not None and place[1] < nearest.y else 'below'


def replay_layer(data: MapData, colours: Mapping[str, str]) -> Markup:
    """Return a mark for each vehicle that the replay moves."""
    return layer(
        'replay',
        (
            pin((0.0, 0.0), element('circle', class_='drone', r=7, fill=colours[name]),
                class_='drone-pin', data_vehicle=name)
            for name in data.replay
        ),
    )  # fmt: skip


def layer(name: str, *content: Markup | Iterable[Markup]) -> Markup:
    """Return a group that the page can show and hide by `name`."""
    return element('g', *content, class_=f'layer layer-{name}', data_layer=name)


def pin(
    place: Point, *content: Markup | Iterable[Markup] | None, class_: str = '', **attributes: str
) -> Markup:
    """Return a mark at `place` whose content is in pixels of the screen."""
    transform = f'translate({number(place[0])}px,{number(place[1])}px) scale(var(--k))'
    return element(
        'g',
        *content,
        class_=f'pin {class_}'.strip(),
        style=style({'transform': transform}),
        **attributes,
    )


# A blade of the trefoil: 60 degrees of a ring about the centre.
_BLADE = 'M-1.5 -2.6L-4 -6.93A8 8 0 0 1 4 -6.93L1.5 -2.6A3 3 0 0 0 -1.5 -2.6Z'


def _label(text: str, offset: int, *, side: str = 'right') -> Markup:
    """Return a text on one side of a mark: right, left, above or below."""
    if side in ('above', 'below'):
        y = offset + 11 if side == 'below' else -offset
        return element('text', text, class_='label label-middle', y=y)
    if side == 'left':
        return element('text', text, class_='label label-left', x=-offset, y=4)
    return element('text', text, class_='label', x=offset, y=4)


def _tag_width(name: str) -> float:
    return 7.2 * len(name) + 14.0


def _polyline(line: Sequence[Point]) -> str:
    """Return path data through `line`; a single point becomes a dot of a round-capped stroke."""
    if not line:
        return ''
    steps = [f'{number(x, _METRE_DIGITS)} {number(y, _METRE_DIGITS)}' for x, y in line]
    distinct = [
        step for step, before in zip(steps, [None, *steps], strict=False) if step != before
    ]
    return f'M{"L".join(distinct)}' if len(distinct) > 1 else f'M{distinct[0]}h0'


def _coloured_lines(
    points: Sequence[DosePoint], scale: DoseScale
) -> Iterator[tuple[int, list[Point]]]:
    """Yield lines of one colour: each reading reaches half-way to its neighbours in time."""
    line: list[Point] = []
    step = -1
    neighbours = zip((None, *points), points, (*points[1:], None), strict=False)
    for before, point, after in neighbours:
        own = round(scale.fraction(point.dose_rate_usvh) * (COLOUR_STEPS - 1))
        start = _middle(before, point)
        if own != step or start is None:
            if line:
                yield step, line
            line, step = [start or (point.x, point.y)], own
        line.append((point.x, point.y))
        end = _middle(point, after)
        if end is not None:
            line.append(end)
    if line:
        yield step, line


def _middle(a: DosePoint | None, b: DosePoint | None) -> Point | None:
    """Return the middle between two readings that belong together, else None."""
    if a is None or b is None or a.vehicle != b.vehicle or b.time_s - a.time_s > MOST_GAP_S:
        return None
    return (a.x + b.x) / 2.0, (a.y + b.y) / 2.0
