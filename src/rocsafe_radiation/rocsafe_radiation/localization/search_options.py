# SPDX-License-Identifier: Apache-2.0
"""Numbers that tune the search for sources, all in one place."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchOptions:
    """How sources are searched for, and how much evidence they need.

    Evidence is the natural logarithm of a probability. "Heights" is a length in units of the
    median height of the readings above the sources.

    Attributes
    ----------
    cell_heights
        Side of the cells in which readings are merged before a fit, heights. Smaller cells change
        no result and take longer.
    most_readings
        Most cells: they are larger where there are more.
    pitch_heights, margin_heights, most_places
        Grid on which a further source is looked for: distance of its places, how far it reaches
        beyond the readings, both in heights, and the most places. A pitch above half a height
        misses sources between its places.
    tried_candidates, rough_iterations
        Places of the grid from which a fit is begun, and the iterations after which they are
        compared: only the best is fitted to the end.
    log_odds_of_source
        Prior evidence of each source: sources are rare.
    are_shades_tried
        Whether something beside the sources may take part of their dose rate on one side; alike
        likely as not.
    background_slopes, background_spacings, position_factors, rhos, drift_factors
        Settings over which the evidence is summed: standard deviation of the bumps of the
        background's random field over their spacing in heights, this spacing, standard deviation
        of the fixes as a multiple of that given, share by which readings scatter in proportion to
        the sources, and standard deviation of what the fixes of a leg have in common, as such a
        multiple. From above, the ground is the more blurred the narrower its parts are: so
        bumps are the lower the nearer they are to each other.
    background_slope_std
        Prior standard deviation of the first of these.
    near_evidence
        Settings whose evidence is lower than that of the best by more are not looked beyond.
    outlier_share
        Probability that a reading tells nothing of the field: a spike.
    largest_dispersion
        Standard deviations by which Pearson's chi-square exceeds its expectation, above which the
        model does not explain the readings.
    largest_ellipse_share
        Longest half axis of a 95 % ellipse that still is a place, as a share of the diagonal of
        the survey.
    line_reach, line_readings, line_width
        Readings within so many distances of the nearest one to a source, if there are as many of
        them, lie on a line if their spread across it is less than this share of that along it.
    image_heights, image_deficit
        A mirror image nearer than this, heights, is the same place; one whose evidence is lower
        by more than this is excluded.
    """

    cell_heights: float = 0.125
    most_readings: int = 2500
    pitch_heights: float = 0.4
    margin_heights: float = 1.0
    most_places: int = 6000
    tried_candidates: int = 4
    rough_iterations: int = 8
    log_odds_of_source: float = -2.0
    background_slopes: tuple[float, ...] = (0.0, 0.015, 0.05, 0.15)
    background_slope_std: float = 0.02
    background_spacings: tuple[float, ...] = (4.0, 2.0, 1.0)
    position_factors: tuple[float, ...] = (0.0, 1.0, 2.0)
    rhos: tuple[float, ...] = (0.0, 0.05, 0.2)
    drift_factors: tuple[float, ...] = (0.0, 1.0, 2.0)
    are_shades_tried: bool = True
    near_evidence: float = 4.0
    outlier_share: float = 1e-3
    largest_dispersion: float = 3.0
    largest_ellipse_share: float = 0.25
    line_reach: float = 3.0
    line_readings: int = 4
    line_width: float = 0.25
    image_heights: float = 0.2
    image_deficit: float = 6.0

    def __post_init__(self) -> None:
        for name in ('cell_heights', 'pitch_heights', 'margin_heights', 'largest_ellipse_share'):
            if not getattr(self, name) > 0.0:
                raise ValueError(f'{name} = {getattr(self, name)} must be above 0')
        for name in (
            'most_places',
            'most_readings',
            'tried_candidates',
            'rough_iterations',
        ):
            if getattr(self, name) < 1:
                raise ValueError(f'{name} = {getattr(self, name)} must be at least 1')
