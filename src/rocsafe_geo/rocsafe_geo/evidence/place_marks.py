# SPDX-License-Identifier: Apache-2.0
"""Places that people have marked as evidence, in the evidence log of a run."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.evidence.evidence_log import read_log
from rocsafe_geo.position import GeoPosition

MARK = 'mark'


@dataclass(frozen=True, slots=True, kw_only=True)
class PlaceMark:
    """A place that somebody marked, with what they wrote."""

    position: GeoPosition
    text: str
    by: str


def read_marks(path: Path) -> list[PlaceMark]:
    """Return the marks of an evidence log in their order, none if there is no file.

    Raises
    ------
    EvidenceError
        If the log has been changed.
    """
    return [_mark(entry) for entry in read_log(path) if entry['kind'] == MARK]


def _mark(entry: dict[str, Any]) -> PlaceMark:
    return PlaceMark(
        position=GeoPosition(entry['latitude_deg'], entry['longitude_deg']),
        text=entry['text'],
        by=entry['by'],
    )
