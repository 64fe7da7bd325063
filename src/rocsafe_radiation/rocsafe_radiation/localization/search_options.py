# SPDX-License-Identifier: Apache-2.0
"""Numbers that tune the search for sources, all in one place."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """How sources are searched for, and how much evidence they need.

    Evidence, gains and deficits are natural logarithms of likelihood ratios. "Heights" is a
    length in units of the median height of the readings above the sources. Where no source is
    given, the value was chosen on the simulated surveys of ``benchmarks/localisation.py``.

    Attributes
    ----------
    cell_heights
        Side of the cells in which readings are merged before a fit, heights. Smaller cells change
        no result and take longer.
    pitch_heights, margin_heights, most_places
        Grid on which a further source is looked for: distance of its places, how far it reaches
        beyond the readings, both in heights, and the most places. A pitch above half a height
        misses sources between its places.
    tried_candidates, refined_candidates, rough_iterations
        Places of the grid from which a fit is begun, the best of these that are fitted to the
        end, and the iterations after which they are compared.
    log_prior_odds_first
        Logarithm of the odds of any source before the first reading. Sources are rare; where
        there is one, a second is as likely as not.
    log_prior_odds_narrow
        The same of a background that varies as narrowly as a source shows.
    hopeless_deficit
        Evidence by which a setting may be behind after a rough fit and still be fitted fully.
    strong_evidence
        Evidence above which a single source cannot come from an uneven background.
    telling_evidence
        Evidence above which a single source would show a misfit if it stood beside a wall.
    large_dispersion, notable_dispersion
        Standard deviations by which Pearson's chi-square exceeds its expectation: above the first
        the model does not explain the readings, above the second it may not.
    largest_ellipse_share
        Longest half axis of a 95 % ellipse that still is a place, as a share of the diagonal of
        the survey.
    unresolved_share
        Variation of the background over the width of a source, as a share of what it varies
        smoothly.
    clearly_better
        Evidence by which an uneven background must explain the readings better than an even one.
    largest_excess
        Readings count as far from all sources where these add less than this share of the
        background.
    clearly_beyond
        Standard deviations by which the squared misfits of far readings must exceed those of
        counts.
    line_reach, line_readings, line_width
        Readings within so many distances of the nearest one to a source, if there are as many of
        them, lie on a line if their spread across it is less than this share of that along it.
    image_heights, image_deficit
        A mirror image nearer than this, heights, is the same place; one whose evidence is lower
        by more than this is excluded.
    """

    cell_heights: float = 0.125
    pitch_heights: float = 0.4
    margin_heights: float = 1.0
    most_places: int = 6000
    tried_candidates: int = 5
    refined_candidates: int = 3
    rough_iterations: int = 8
    log_prior_odds_first: float = -3.0
    log_prior_odds_narrow: float = -3.0
    hopeless_deficit: float = 30.0
    strong_evidence: float = 60.0
    telling_evidence: float = 300.0
    large_dispersion: float = 3.0
    notable_dispersion: float = 0.5
    largest_ellipse_share: float = 0.25
    unresolved_share: float = 0.5
    clearly_better: float = 3.0
    largest_excess: float = 0.3
    clearly_beyond: float = 3.0
    line_reach: float = 3.0
    line_readings: int = 4
    line_width: float = 0.25
    image_heights: float = 0.2
    image_deficit: float = 6.0

    def __post_init__(self) -> None:
        for name in ('cell_heights', 'pitch_heights', 'margin_heights', 'largest_ellipse_share'):
            if not getattr(self, name) > 0.0:
                raise ValueError(f'{name} = {getattr(self, name)} must be above 0')
        for name in ('most_places', 'tried_candidates', 'refined_candidates', 'rough_iterations'):
            if getattr(self, name) < 1:
                raise ValueError(f'{name} = {getattr(self, name)} must be at least 1')
