# SPDX-License-Identifier: Apache-2.0
"""The figures of a run: how it was planned and flown, and how well its sources were found."""

import json
import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

import numpy as np
from scipy.optimize import linear_sum_assignment

from rocsafe_campaign.flight.pure_mission import PureMission
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_scenario.scenario import Scenario

# An estimate farther from a source than this does not stand for it.
NEAR_M = 25.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Metrics:
    """Figures of a run; NaN where one is not known.

    Attributes
    ----------
    makespan_s, gap_fraction, covered_fraction, viewpoint_count
        Of the plan.
    duration_s, distance_m
        From the first take-off to the last touch-down, and the way of all vehicles together.
    completed
        Vehicles whose flight ended as planned.
    reading_count, highest_usvh
        Readings, and the highest dose rate among them.
    source_count, found_count
        Sources there are, and sources estimated.
    missed, invented
        Sources without an estimate within 25 m, and estimates without such a source.
    error_m
        Mean horizontal distance of the sources from their estimates; NaN if all are missed.
    ellipse_m
        Longest half axis of the 95 % ellipses.
    is_enough
        Whether the readings are enough by the scenario's own rule: 1 or 0.
    """

    makespan_s: float = math.nan
    gap_fraction: float = math.nan
    covered_fraction: float = math.nan
    viewpoint_count: float = math.nan
    duration_s: float = math.nan
    distance_m: float = math.nan
    completed: float = math.nan
    reading_count: float = math.nan
    highest_usvh: float = math.nan
    source_count: float = math.nan
    found_count: float = math.nan
    missed: float = math.nan
    invented: float = math.nan
    error_m: float = math.nan
    ellipse_m: float = math.nan
    is_enough: float = math.nan


METRICS = tuple(field.name for field in fields(Metrics))


def metrics_of_mission(mission: PureMission) -> Metrics:
    """Return the figures of a mission flown without processes."""
    plan, found = mission.plan, mission.assessment
    sources = () if found is None else found.found.sources
    places = [tuple(source.position_enu_m[:2].tolist()) for source in sources]
    flights = mission.flight.summaries.values()
    return Metrics(
        makespan_s=plan.makespan_s,
        gap_fraction=plan.gap_fraction,
        covered_fraction=plan.covered_fraction,
        viewpoint_count=float(plan.viewpoint_count),
        duration_s=mission.flight.duration_s,
        distance_m=math.fsum(one.distance_flown_m for one in flights),
        completed=float(sum(one.outcome.value == 'completed' for one in flights)),
        reading_count=float(len(mission.readings)),
        highest_usvh=max((one.dose_rate_usvh for one in mission.readings), default=math.nan),
        ellipse_m=max((source.ellipse_95()[0] for source in sources), default=math.nan),
        is_enough=math.nan if found is None else float(found.verdict.is_enough),
        **match(true_places(mission.scenario), places),
    )


def metrics_of_summary(scenario: Scenario, path: Path) -> Metrics:
    """Return the figures of a run of whole processes from its ``summary.json``.

    Raises
    ------
    OSError, ValueError
        If the file cannot be read.
    """
    content = json.loads(path.read_text(encoding='utf-8'))
    plan, estimates = content.get('plan') or {}, content.get('estimates') or {}
    frame = LocalFrame(scenario.origin_position())
    sources: Sequence[Mapping[str, Any]] = estimates.get('sources', ())
    places = [frame.enu_of(GeoPosition(**source['position']))[:2].tolist() for source in sources]
    ways = [vehicle['flown_length_m'] for vehicle in content['vehicles']]
    return Metrics(
        makespan_s=_number(plan.get('makespan_s')),
        gap_fraction=_number(plan.get('gap_fraction')),
        covered_fraction=_number(plan.get('covered_fraction')),
        viewpoint_count=_number(plan.get('viewpoint_count')),
        duration_s=_number(content.get('mission_duration_s')),
        distance_m=math.fsum(way for way in ways if way is not None),
        completed=float(sum(vehicle['state'] == 'landed' for vehicle in content['vehicles'])),
        reading_count=_number(content.get('reading_count')),
        highest_usvh=_number((content.get('highest_reading') or {}).get('dose_rate_usvh')),
        ellipse_m=max((source['ellipse_95_m'][0] for source in sources), default=math.nan),
        is_enough=_number(estimates.get('is_enough')),
        **match(true_places(scenario), places),
    )


def _number(value: object) -> float:
    return float(value) if isinstance(value, (int, float)) else math.nan


def true_places(scenario: Scenario) -> list[tuple[float, float]]:
    """Return where the sources of a scenario are, east and north of its origin, metres."""
    frame = LocalFrame(scenario.origin_position())
    positions = (scenario.ground_position(one.place) for one in scenario.radiation.sources)
    places = (frame.enu_of(position).tolist() for position in positions)
    return [(east, north) for east, north, _ in places]


def match(
    sources: Sequence[Sequence[float]], estimates: Sequence[Sequence[float]]
) -> dict[str, float]:
    """Return how well estimates stand for sources; pairs have the least sum of distances.

    Parameters
    ----------
    sources, estimates
        Places, east and north, metres.
    """
    true, found = (np.asarray(p, float).reshape(-1, 2) for p in (sources, estimates))
    distances = np.linalg.norm(true[:, None] - found[None], axis=2)
    # One beyond reach costs the same however far it is: it takes no partner from a near one.
    rows, columns = linear_sum_assignment(np.minimum(distances, 2.0 * NEAR_M))
    errors = distances[rows, columns]
    near = errors[errors <= NEAR_M]
    return {
        'source_count': float(len(true)),
        'found_count': float(len(found)),
        'missed': float(len(true) - len(near)),
        'invented': float(len(found) - len(near)),
        'error_m': float(near.mean()) if len(near) else math.nan,
    }
