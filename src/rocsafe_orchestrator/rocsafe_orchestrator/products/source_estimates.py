# SPDX-License-Identifier: Apache-2.0
"""Sources estimated from the readings of a run: ``sources.json`` and related files."""

import json
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products.estimator_process import run_estimator


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceEstimate:
    """A source as estimated: place, 95 % ellipse, strength with its 95 % interval."""

    position: GeoPosition
    ellipse_95_m: tuple[float, float]
    ellipse_angle_from_east_deg: float
    dose_rate_at_1m_usvh: float
    dose_rate_at_1m_95_usvh: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceEstimates:
    """All estimated sources, the surest first, the probability of each number, the verdict.

    `doubts` lists the assumptions of the estimator that are violated.
    """

    sources: tuple[SourceEstimate, ...]
    source_count_probability: tuple[float, ...]
    background_usvh: float
    reading_count: int
    is_enough: bool = False
    verdict: str = ''
    doubts: tuple[str, ...] = ()

    def probability_of(self, number: int) -> float:
        """Return the probability that there are at least `number` sources."""
        return sum(self.source_count_probability[number:])


def estimate_sources(readings: Path, options: Sequence[str]) -> SourceEstimates:
    """Estimate sources from the table `readings`; their files are written beside it.

    `options` are those of the command `localize`.

    Raises
    ------
    OrchestratorError
        If there are no estimates, with the reason.
    """
    folder = readings.parent
    arguments = [str(readings), f'--out={folder}', *options]
    run_estimator('rocsafe_radiation', 'localize', arguments)
    try:
        content = json.loads((folder / 'sources.json').read_text(encoding='utf-8'))
        return _estimates(content)
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise OrchestratorError(f'sources.json cannot be read: {error}') from error


def _estimates(content: dict[str, Any]) -> SourceEstimates:
    return SourceEstimates(
        sources=tuple(map(_estimate, content['sources'])),
        source_count_probability=tuple(content['source_count_probability']),
        background_usvh=content['background_usvh'],
        reading_count=content['reading_count'],
        is_enough=content.get('is_enough', False),
        verdict=content.get('verdict', ''),
        doubts=tuple(content.get('doubts', ())),
    )


def _estimate(source: dict[str, Any]) -> SourceEstimate:
    long_m, short_m = source['ellipse_95_m']
    low, high = source['dose_rate_at_1m_95_usvh']
    return SourceEstimate(
        position=GeoPosition(**source['place']),
        ellipse_95_m=(long_m, short_m),
        ellipse_angle_from_east_deg=source['ellipse_angle_from_east_deg'],
        dose_rate_at_1m_usvh=source['dose_rate_at_1m_usvh'],
        dose_rate_at_1m_95_usvh=(low, high),
    )
