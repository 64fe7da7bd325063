# SPDX-License-Identifier: Apache-2.0
"""The map with its legend, layer switches, replay and details."""

from collections.abc import Iterable, Mapping

from rocsafe_orchestrator.products.summary import HighestReading
from rocsafe_orchestrator.report import formats, map_layers
from rocsafe_orchestrator.report.map_data import MapData
from rocsafe_orchestrator.report.markup import Markup, element, join, number, style
from rocsafe_orchestrator.report.palette import DoseScale, gradient
from rocsafe_orchestrator.report.pictures import GroundPicture
from rocsafe_orchestrator.report.plan_data import Point

Box = tuple[float, float, float, float]
# Layers that can be switched: name, text, and a class for its swatch.
SWITCHES = (
    ('ground', 'Mosaic of the photographs'),
    ('readings', 'Dose-rate readings'),
    ('tracks', 'Flown tracks'),
    ('routes', 'Planned routes'),
    ('planned', 'Footprints planned'),
    ('photos', 'Photographs'),
    ('region', 'Region'),
    ('exclusions', 'Exclusions'),
    ('highest', 'Highest reading'),
    ('sources', 'True sources (scenario)'),
    ('estimates', 'Estimated sources, 95 %'),
    ('homes', 'Homes'),
)
# What each button shows; without script everything but the photographs is visible.
VIEWS = {
    'Everything': 'ground readings tracks routes region exclusions highest sources estimates '
    'homes labels',
    'Radiation': 'ground readings region highest sources estimates',
    'Routes': 'ground tracks routes planned region exclusions homes labels',
    'Photographs': 'ground photos region',
}
HIDDEN_AT_FIRST = frozenset({'photos', 'planned'})
_MARGIN = 0.06
_LEAST_BOX_M = 20.0
# A map of usual width before the script has measured it.
_NOMINAL_WIDTH_PX = 820.0
_GRID_M = 50


def map_section(
    data: MapData,
    picture: GroundPicture | None,
    scale: DoseScale,
    colours: Mapping[str, str],
    highest: HighestReading | None,
) -> Markup:
    """Return the section of the page that holds the map."""
    boxes = view_boxes(data)
    place = _highest_place(data, highest)
    layers = (
        map_layers.ground_layer(picture),
        map_layers.planned_layer(data, colours),
        map_layers.exclusions_layer(data),
        map_layers.readings_layer(data, scale),
        map_layers.tracks_layer(data, colours),
        map_layers.routes_layer(data),
        map_layers.region_layer(data),
        map_layers.photos_layer(data),
        map_layers.homes_layer(data, colours),
        map_layers.highest_layer(highest, place, data.sources),
        map_layers.sources_layer(data),
        map_layers.estimates_layer(data),
        map_layers.labels_layer(data, colours),
        map_layers.replay_layer(data, colours),
    )
    return element(
        'section',
        _heading(),
        element(
            'div',
            element(
                'div',
                element('div', _svg(boxes['region'], layers), _overlays(), class_='map-view'),
                element('div', legend(scale), _scale_bar(), class_='map-foot'),
                class_='map-frame',
            ),
            element('div', _switches(picture), _replay(data), _details(), class_='map-side'),
            class_='map-grid',
        ),
        class_='card map-card',
        id='map',
        aria_labelledby='map-title',
    )


def view_boxes(data: MapData) -> dict[str, Box]:
    """Return what can be brought into view: the region, and all that was flown."""
    region = [point for ring in data.region for point in ring]
    surveyed = [*region, *(p for line in data.viewpoints.values() for p in line)]
    flown = [*surveyed, *data.homes.values(), *(p for t in data.tracks.values() for p in t)]
    everything = flown or [(0.0, 0.0)]
    return {'region': _box(surveyed or everything), 'all': _box(everything)}


def _box(places: Iterable[Point]) -> Box:
    xs, ys = zip(*places, strict=True)
    width = max(max(xs) - min(xs), _LEAST_BOX_M)
    height = max(max(ys) - min(ys), _LEAST_BOX_M)
    margin = _MARGIN * max(width, height)
    return min(xs) - margin, min(ys) - margin, width + 2 * margin, height + 2 * margin


def _highest_place(data: MapData, highest: HighestReading | None) -> Point | None:
    if highest is None or not data.readings:
        return None
    top = max(data.readings, key=lambda point: point.dose_rate_usvh)
    return top.x, top.y


def _heading() -> Markup:
    buttons = (
        element('button', name, type='button', data_view=layers, aria_pressed='false')
        for name, layers in VIEWS.items()
    )
    return element(
        'div',
        element('h2', 'Map', id='map-title'),
        element('div', buttons, class_='segments', role='group', aria_label='Views of the map'),
        class_='section-head',
    )


def _svg(box: Box, layers: Iterable[Markup]) -> Markup:
    grid = element(
        'pattern',
        element('path', d=f'M0 0H{_GRID_M}M0 0V{_GRID_M}', class_='grid-line'),
        id='grid', width=_GRID_M, height=_GRID_M, patternUnits='userSpaceOnUse',
    )  # fmt: skip
    backdrop = element('rect', x=-50000, y=-50000, width=100000, height=100000, fill='url(#grid)')
    return element(
        'svg',
        element('defs', grid),
        backdrop,
        *layers,
        class_='map hide-photos',
        viewBox=' '.join(number(value) for value in box),
        style=style({'--k': f'{box[2] / _NOMINAL_WIDTH_PX:.5f}'}),
        tabindex=0,
        role='img',
        aria_label='Map: arrow keys move it, plus and minus zoom, 0 shows the region, '
        'A shows everything.',
    )


def _overlays() -> Markup:
    north = element(
        'svg',
        element('path', d='M12 2L18 21L12 17L6 21Z', class_='north-needle'),
        element('text', 'N', x=12, y=33, class_='north-text'),
        viewBox='0 0 24 36', class_='north', role='img', aria_label='North is up',
    )  # fmt: skip
    zoom = element(
        'div',
        (
            element('button', sign, type='button', data_zoom=action, aria_label=text, title=text)
            for sign, action, text in (
                ('+', 'in', 'Zoom in'),
                ('−', 'out', 'Zoom out'),
                ('Region', 'region', 'Show the region'),
                ('All', 'all', 'Show all that was flown'),
            )
        ),
        class_='zoom',
    )
    hint = element('div', 'Ctrl + wheel zooms, drag moves', class_='map-hint', aria_hidden='true')
    return join((north, zoom, hint))


def _scale_bar() -> Markup:
    line = element('span', class_='scale-line')
    return element('div', line, element('span', class_='scale-text'), class_='scale-bar')


def legend(scale: DoseScale) -> Markup:
    """Return the scale of dose rates; what is lower has the lowest colour."""
    ticks = scale.ticks()
    texts = (
        element(
            'span',
            ('≤' if value <= scale.low_usvh else '') + formats.figures(value, 1),
            style=style({'left': f'{100.0 * scale.fraction(value):.1f}%'}),
        )
        for value in ticks
    )
    bar = element('div', class_='legend-bar', style=style({'background': gradient()}))
    return element(
        'div',
        element('div', 'Dose rate, µSv/h', class_='legend-title'),
        element('div', bar, element('div', texts, class_='legend-ticks'), class_='legend-scale'),
        class_='legend',
        role='img',
        aria_label=f'Colours of dose rates from {scale.low_usvh:g} to {scale.high_usvh:g} '
        'microsievert per hour, logarithmic',
    )


def _switches(picture: GroundPicture | None) -> Markup:
    def switch(name: str, text: str) -> Markup:
        is_missing = name == 'ground' and picture is None
        box = element(
            'input',
            type='checkbox',
            data_switch=name,
            checked=name not in HIDDEN_AT_FIRST and not is_missing,
            disabled=is_missing,
        )
        shown = f'{text} (none)' if is_missing else text
        swatch = element('span', class_=f'swatch swatch-{name}', aria_hidden='true')
        return element('label', box, swatch, element('span', shown), class_='switch')

    return element(
        'fieldset',
        element('legend', 'Layers'),
        *(switch(name, text) for name, text in SWITCHES),
        class_='switches script-only',
    )


def _replay(data: MapData) -> Markup | None:
    if not data.replay:
        return None
    end = max(float(track.time_s[-1]) for track in data.replay.values())
    return element(
        'div',
        element('div', element('h3', 'Replay'), element('output', '00:00', id='replay-time')),
        element(
            'div',
            element('button', '▶', type='button', id='replay-play', aria_label='Play'),
            element(
                'input', type='range', id='replay', min=0, max=round(end), value=0, step=1,
                aria_label='Time since the first take-off, seconds',
            ),
        ),
        class_='replay script-only',
    )  # fmt: skip


def _details() -> Markup:
    hint = 'Click a track or a photograph mark to see what was measured there.'
    return element(
        'div',
        element('h3', 'Selected'),
        element('div', hint, id='details', aria_live='polite'),
        class_='details script-only',
    )
