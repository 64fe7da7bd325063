# SPDX-License-Identifier: Apache-2.0
"""Texts of SVG: short numbers, and path data through points."""

from collections.abc import Iterable, Sequence

Point = tuple[float, float]
Rings = tuple[tuple[Point, ...], ...]
_DECIMETRE_DIGITS = 1


def number(value: float, digits: int = 2) -> str:
    """Return `value` as short as SVG allows: 12.50 is 12.5, -0.00 is 0."""
    text = f'{value:.{digits}f}'
    text = text.rstrip('0').rstrip('.') if '.' in text else text
    return '0' if text == '-0' else text


def polyline(line: Sequence[Point]) -> str:
    """Return path data through `line`; a single point becomes a dot of a round-capped stroke."""
    if not line:
        return ''
    steps = [f'{number(x, _DECIMETRE_DIGITS)} {number(y, _DECIMETRE_DIGITS)}' for x, y in line]
    distinct = [
        step for step, before in zip(steps, [None, *steps], strict=False) if step != before
    ]
    return f'M{"L".join(distinct)}' if len(distinct) > 1 else f'M{distinct[0]}h0'


def polygons(rings: Iterable[Sequence[Point]], separator: str = ' ') -> str:
    """Return path data of closed `rings`."""
    return separator.join(f'{polyline(ring)}Z' for ring in rings)
