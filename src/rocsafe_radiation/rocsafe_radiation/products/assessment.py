# SPDX-License-Identifier: Apache-2.0
"""Assessment of a hazard from readings: sources, dose rates, cordons, whether they are enough."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from shapely.geometry import Polygon

from rocsafe_hazard.next_places import MeasuringPlace, Verdict, are_within
from rocsafe_radiation.belief.belief_search import BeliefMap, believe
from rocsafe_radiation.decision.sequential_decision import SequentialEvidence, sequential_evidence
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.decision.waypoint_choice import candidate_places, next_waypoints
from rocsafe_radiation.localization.candidates import best_separated
from rocsafe_radiation.localization.estimates import (
    BELIEF_METHOD,
    METHODS,
    ML_METHOD,
    Localization,
)
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.products.cordon import DEFAULT_LEVELS_USVH, Cordon, cordons
from rocsafe_radiation.products.dose_map import DoseMap, dose_map
from rocsafe_radiation.readings.survey import RadiationSurvey

# One byte a cell in a message; files hold finer maps.
LARGEST_CELLS = 40_000


@dataclass(frozen=True, slots=True, kw_only=True)
class AssessmentOptions:
    """How an assessment is made.

    Attributes
    ----------
    known
        What is known before the readings.
    method
        Method by which sources are found, one of `METHODS`.
    rule
        When the evidence is enough.
    levels_usvh
        Dose rates of cordons, microsievert per hour.
    """

    known: LocalizationOptions = field(default_factory=LocalizationOptions)
    method: str = ML_METHOD
    rule: StoppingRule = field(default_factory=StoppingRule)
    levels_usvh: tuple[float, ...] = DEFAULT_LEVELS_USVH

    def __post_init__(self) -> None:
        if self.method not in METHODS:
            raise ValueError(f'method = {self.method!r} must be one of: {", ".join(METHODS)}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Assessment:
    """What the readings so far show; `belief` is None but for the method ``belief-grid``."""

    options: AssessmentOptions
    survey: RadiationSurvey
    found: Localization
    evidence: SequentialEvidence
    verdict: Verdict
    dose: DoseMap
    cordons: tuple[Cordon, ...]
    belief: BeliefMap | None = None


Found = tuple[Localization, BeliefMap | None]


def _by_likelihood(
    survey: RadiationSurvey, options: AssessmentOptions, _agents: Sequence[str]
) -> Found:
    return localize(survey, options.known), None


def _by_belief(
    survey: RadiationSurvey, options: AssessmentOptions, agents: Sequence[str]
) -> Found:
    return believe(survey, options.known, agents, options.rule.smallest_usvh)


FINDERS: dict[str, Callable[[RadiationSurvey, AssessmentOptions, Sequence[str]], Found]] = {
    ML_METHOD: _by_likelihood,
    BELIEF_METHOD: _by_belief,
}


def assess(
    survey: RadiationSurvey,
    options: AssessmentOptions,
    agents: Sequence[str] = (),
    largest_cells: int = LARGEST_CELLS,
) -> Assessment:
    """Return the assessment of `survey`.

    Parameters
    ----------
    survey
        Readings.
    options
        How they are assessed.
    agents
        Agent of each reading, for the method ``belief-grid``.
    largest_cells
        Approximate number of cells of the map of dose rates.

    Raises
    ------
    TooFewReadingsError
        If there are too few readings.
    """
    known = options.known
    found, belief = FINDERS[options.method](survey, options, agents)
    cell_m = 0.25 * survey.height_m(known.source_up_m)
    merged = survey.merged(cell_m, known.search.most_readings)
    counted = known.kernel.at_heights(merged.heights_m - known.source_up_m)
    setting = Setting(kernel=counted, source_up_m=known.source_up_m, rho=found.rho)
    evidence = sequential_evidence(merged, setting, options.rule.smallest_usvh)
    lowest = min(options.levels_usvh)
    dose = dose_map(found, survey, known.kernel, lowest, largest_cells=largest_cells)
    return Assessment(
        options=options,
        survey=survey,
        found=found,
        evidence=evidence,
        verdict=options.rule.verdict(found, evidence),
        dose=dose,
        cordons=tuple(cordons(dose, options.levels_usvh)),
        belief=belief,
    )


def suggested_waypoints(
    assessment: Assessment, count: int, area: Polygon | None = None
) -> list[MeasuringPlace]:
    """Return up to `count` places to measure at next, the largest gain first.

    With sources, they are those that reduce the uncertainty of the sources most. Without, they are
    over the ground where a source is least excluded. All lie within `area`, east and north, if it
    is given.
    """
    if count < 1:
        return []
    known = assessment.options.known
    candidates = candidate_places(assessment.survey, known.source_up_m)
    candidates = candidates[are_within(candidates, area)]
    if not len(candidates):
        return []
    if assessment.found.sources:
        exposure = float(np.median(assessment.survey.exposures))
        height_m = np.array([assessment.survey.height_m(known.source_up_m)])
        counted = known.kernel.at_heights(height_m)
        return next_waypoints(assessment.found, candidates, exposure, counted, count)
    return _doubtful(assessment, count, area)


def _doubtful(assessment: Assessment, count: int, area: Polygon | None) -> list[MeasuringPlace]:
    """Return places over the ground where a source of the smallest strength is least excluded."""
    evidence, survey = assessment.evidence, assessment.survey
    inside = are_within(evidence.places_m, area)
    places, doubts = evidence.places_m[inside], evidence.doubts[inside]
    if not len(places):
        return []
    above = assessment.options.known.source_up_m
    height = survey.height_m(above)
    # `best_separated` needs ranks above 0; the order is the same.
    ranks = doubts - doubts.min() + 1.0
    separation_m = height
    chosen = best_separated(places, ranks, count, separation_m)
    # Small ground has no room for so many places a height apart.
    while len(chosen) < min(count, len(places)):
        separation_m /= 2.0
        chosen = best_separated(places, ranks, count, separation_m)
    ups = survey.ground.ups_at(places[chosen]) + above + height
    return [
        MeasuringPlace(
            place_m=(float(places[k, 0]), float(places[k, 1]), float(up)),
            gain=float(np.exp(min(doubts[k], 0.0))),
        )
        for k, up in zip(chosen, ups, strict=True)
    ]
