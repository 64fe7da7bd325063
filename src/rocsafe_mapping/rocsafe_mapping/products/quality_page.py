# SPDX-License-Identifier: Apache-2.0
"""The quality of a map as an HTML page."""

import html
import json
from collections.abc import Mapping
from typing import Any

PAGE = """<!doctype html>
<html lang="en"><head><meta charset="utf-8"><title>Quality of the map</title>
<meta name="viewport" content="width=device-width, initial-scale=1">
<style>
body {{ font: 15px/1.5 system-ui, sans-serif; margin: 2rem auto; max-width: 60rem; color: #1b2430;
padding: 0 1rem; }}
h1 {{ font-size: 1.5rem; }} h2 {{ font-size: 1.1rem; margin-top: 2rem; }}
.yes, .no {{ padding: .6rem 1rem; border-radius: .4rem; }}
.yes {{ background: #e3f3e6; }} .no {{ background: #fbe3df; }}
table {{ border-collapse: collapse; }} td, th {{ padding: .15rem .8rem .15rem 0; text-align: left;
border-bottom: 1px solid #e2e6ea; }}
td.n {{ text-align: right; font-variant-numeric: tabular-nums; }}
img {{ max-width: 100%; background: #eef1f4; }}
</style></head><body>
<h1>Quality of the map</h1>
{verdict}
{picture}
<h2>Figures</h2>
<table>{figures}</table>
{errors}
<h2>Photographs</h2>
<table><tr><th>photograph</th><th>placed by</th><th>error, m</th><th>distance to its fix, m</th>
</tr>{photographs}</table>
</body></html>
"""
ERRORS = """<h2>What stands on the ground</h2>
<p>The map is flat: roofs and trees appear displaced outwards, by more the higher they are. Where
only one photograph shows a place, heights above the ground are unknown; the error there assumes
the heights found elsewhere on the map. The error of each pixel is in error.tif.</p>
<table><tr><th>place</th><th>share of the map</th><th>error, m</th></tr>{rows}</table>
{image}<p>Dark: small error; bright: large error. Grey: heights unknown (only one photograph, or
two that do not match).</p>
"""


def quality_page(document: Mapping[str, Any], picture: str = '', error_picture: str = '') -> str:
    """Return the page for a `document` of `quality`.

    `picture` is the map's and `error_picture` that of its errors, both beside the page.
    """
    return PAGE.format(
        verdict=_verdict(document),
        picture=f'<p><img src="{html.escape(picture)}" alt="the map"></p>' if picture else '',
        figures=''.join(_row(name, value) for name, value in _figures(document)),
        errors=_errors(document['stated_error_with_what_stands_m'], error_picture),
        photographs=''.join(_photograph(row) for row in document['placements']),
    )


def quality_text(document: Mapping[str, Any]) -> bytes:
    """Return the document as a JSON file."""
    return json.dumps(document, indent=1, allow_nan=False).encode() + b'\n'


def _verdict(document: Mapping[str, Any]) -> str:
    if document['is_georeferenced']:
        error = document['stated_error_m']['rms']
        stated = f'the error of the ground is {error:.2f} m (one sigma)'
        return f'<p class="yes">Georeferenced; {stated}.</p>'
    reasons = ''.join(
        f'<li>{html.escape(text)}</li>' for text in document['why_not_georeferenced']
    )
    return f'<div class="no">Not to be called georeferenced:<ul>{reasons}</ul></div>'


def _errors(errors: Mapping[str, Any], picture: str) -> str:
    """Return the errors of ground, of objects, and where heights are unknown."""
    kinds = (
        ('level ground, seen by two photographs', 'ground'),
        ('objects above it, seen by two photographs', 'standing'),
        ('seen by one photograph, or by two that do not match', 'untold'),
    )
    rows = ''.join(
        f'<tr><td>{text}</td><td class="n">{100 * errors[kind]["share"]:.1f} %</td>'
        f'<td class="n">{errors[kind]["rms"]:.2f}</td></tr>'
        for text, kind in kinds
        if errors[kind]['rms'] is not None
    )
    image = f'<p><img src="{html.escape(picture)}" alt="errors of the map"></p>' if picture else ''
    return ERRORS.format(rows=rows, image=image)


def _figures(document: Mapping[str, Any]) -> list[tuple[str, str]]:
    photographs, cover = document['photographs'], document['coverage']
    rows = [
        ('photographs', str(photographs['total'])),
        ('placed by image features', str(photographs['placed_by_features'])),
        ('placed by their fix only', str(len(photographs['placed_by_gps']))),
        ('pixel on the ground', _pixel(document)),
        ('grid', 'local' if document['is_local'] else f'EPSG:{document["epsg_code"]}'),
        (f'covered of the {cover["of"]}', f'{100 * cover["share"]:.1f} %'),
        ('largest hole', f'{cover["largest_hole_m2"]:.0f} m²'),
    ]
    ties, seams, fixes = document['held_out_ties'], document['seams'], document['fixes']
    if ties['count']:
        px = ties['px']
        rows.append(
            (
                f'{ties["count"]} held-out ties: median, 90 %, RMSE',
                f'{px["median"]:.2f}, {px["p90"]:.2f}, {px["rmse"]:.2f} px',
            )
        )
    if seams['count']:
        px = seams['px']
        rows.append(('shift at seams: median, 95 %', f'{px["p50"]:.2f}, {px["p95"]:.2f} px'))
    if fixes:
        rows.append(('distance to the fixes, RMSE', f'{fixes["all"]["horizontal_rmse_m"]:.2f} m'))
        off = fixes['all']
        # Adding 0 turns -0.00 into 0.00.
        bias = [f'{round(off[f"bias_{axis}_m"], 2) + 0.0:.2f}' for axis in ('east', 'north', 'up')]
        rows.append(('mean offset from the fixes east, north, up', ', '.join(bias) + ' m'))
    for kind, facts in document['control'].items():
        if kind != 'points':
            rows.append(
                (
                    f'{facts["count"]} {"check" if kind == "check" else "control"} points, RMSE',
                    f'{facts["rmse_m"]:.2f} m (stated {facts["stated_error_m"]:.2f} m)',
                )
            )
    for vehicle, off in fixes.get('vehicles', {}).items():
        if off['clock_lag_s']:
            rows.append(
                (f'fixes of {vehicle} are late by', f'{off["clock_lag_s"]:.2f} s, corrected')
            )
    for name, cost in document['costs'].items():
        rows.append((f'time, {name}', f'{cost["wall_s"]:.1f} s, processor {cost["cpu_s"]:.1f} s'))
    return rows


def _pixel(document: Mapping[str, Any]) -> str:
    size = document['ground_resolution_m']
    return f'{size:.4f} x {document["unit"]}' if document['is_local'] else f'{100 * size:.1f} cm'


def _row(name: str, value: str) -> str:
    return f'<tr><td>{html.escape(name)}</td><td class="n">{html.escape(value)}</td></tr>'


def _photograph(row: Mapping[str, Any]) -> str:
    off_m = row['fix_off_m']
    off = '' if off_m is None else f'{off_m:.2f}'
    return (
        f'<tr><td>{html.escape(row["name"])}</td><td>{row["placed_by"]}</td>'
        f'<td class="n">{row["error_m"]:.2f}</td><td class="n">{off}</td></tr>'
    )
