# SPDX-License-Identifier: Apache-2.0
"""Quality of the map of the photographs, from ``map/quality.json``."""

import json
import math
from pathlib import Path
from typing import Any

from markupsafe import Markup

from rocsafe_view import formats

QUALITY, QUALITY_PAGE = Path('map/quality.json'), Path('map/quality.html')
Facts = list[tuple[str, str]]


def map_facts(folder: Path) -> Facts:
    """Return names and values for the report of the run in `folder`, none without a quality.

    What the file lacks, or has in another form, is left out.
    """
    try:
        content = json.loads((folder / QUALITY).read_text(encoding='utf-8'))
    except (OSError, ValueError):
        return []
    document = content if isinstance(content, dict) else {}
    placed, coverage = _part(document, 'photographs'), _part(document, 'coverage')
    total, by_features = _number(placed, 'total'), _number(placed, 'placed_by_features')
    ties = _part(_part(document, 'held_out_ties'), 'px')
    fixes = _part(_part(document, 'fixes'), 'all')
    hole = _number(coverage, 'largest_hole_m2')
    rows: Facts = [
        ('Placed by features', '' if total is None or by_features is None
         else f'{by_features:.0f} of {total:.0f} photographs'),
        ('Georeferenced', _georeferenced(document)),
        ('Stated error, RMS', _quantity(_part(document, 'stated_error_m'), 'rms', 'm')),
        ('Held-out ties, median', _quantity(ties, 'median', 'px')),
        ('Fixes off the map, RMS', _quantity(fixes, 'horizontal_rmse_m', 'm')),
        (f'Shown of the {coverage.get("of", "region")}',
         formats.percent(_number(coverage, 'share'))),
        ('Largest hole', '' if hole is None else formats.area(hole) if hole else 'none'),
    ]  # fmt: skip
    if (folder / QUALITY_PAGE).is_file():
        page = QUALITY_PAGE.as_posix()
        rows.append(('More', Markup('<a href="{0}">{0}</a>').format(page)))
    return [(name, value) for name, value in rows if value not in ('', formats.UNKNOWN)]


def _georeferenced(document: dict[str, Any]) -> str:
    is_true = document.get('is_georeferenced')
    if not isinstance(is_true, bool):
        return ''
    reasons = document.get('why_not_georeferenced') or ()
    return 'yes' if is_true else f'no: {"; ".join(map(str, reasons))}'


def _part(document: dict[str, Any], name: str) -> dict[str, Any]:
    part = document.get(name)
    return part if isinstance(part, dict) else {}


def _number(part: dict[str, Any], name: str) -> float | None:
    value = part.get(name)
    if isinstance(value, (int, float)) and math.isfinite(value):
        return float(value)
    return None


def _quantity(part: dict[str, Any], name: str, unit: str) -> str:
    value = _number(part, name)
    return '' if value is None else f'{formats.figures(value, 2)}{formats.GAP}{unit}'
