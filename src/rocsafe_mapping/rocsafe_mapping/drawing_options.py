# SPDX-License-Identifier: Apache-2.0
"""Options of the drawing: each constant that tunes how photographs become a map, step by step.

Where no source is named, a value was chosen by the figures and pictures of
``benchmarks/mapping.py``: seams, cut objects, and heights beside the truth of the simulated scene.
"""

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class ViewOptions:
    """Step 1: small views of all photographs from above, on the coarse grid.

    Attributes
    ----------
    coarse_side_px
        Long side of a footprint, coarse pixels.
    edge_share
        Share of the image's shorter side, at each edge, over which its score falls to zero.
    """

    coarse_side_px: int = 160
    edge_share: float = 0.04


@dataclass(frozen=True, slots=True, kw_only=True)
class GainOptions:
    """Step 2: factors that make the brightness and colour of photographs alike.

    Attributes
    ----------
    brightness_hold, colour_hold
        Weight that holds a gain at 1, over the weight of its comparisons: it cannot drift across
        the map. Colour is a gain's ratio to the mean of the three.
    largest_log
        Limit of the logarithm of a gain.
    dark, bright
        Grey levels between which pixels are compared.
    least_common_px
        Coarse pixels that two photographs must share.
    """

    brightness_hold: float = 0.12
    colour_hold: float = 0.5
    largest_log: float = 1.2
    dark: int = 8
    bright: int = 247
    least_common_px: int = 40


@dataclass(frozen=True, slots=True, kw_only=True)
class VignettingOptions:
    """Step 2: fall-off of a lens's brightness towards the corners.

    Attributes
    ----------
    least_pairs, least_common_px
        Pairs of photographs that must show it, and the coarse pixels that each pair shares.
    least_log, largest_log
        Logarithms of the brightness of the corners between which a fall-off is undone.
    largest_ratio
        Pixels whose logarithms differ by more show different things.
    """

    least_pairs: int = 8
    least_common_px: int = 200
    least_log: float = 0.04
    largest_log: float = -1.2
    largest_ratio: float = 0.4


@dataclass(frozen=True, slots=True, kw_only=True)
class SeamOptions:
    """Step 3: borders between photographs.

    Attributes
    ----------
    slack
        A border may run where another photograph's score is lower by this share.
    colour_unit
        Squared difference of blue, green and red that costs 1: 20 levels in each.
    most_colour
        Limit of the cost of a difference of colour.
    least_colour
        From this cost on a difference is not one of light or noise: an object stands there.
    search_length_cost, kept_length_cost
        Cost of each pixel of a border where photographs agree: in the search (borders shall be
        short), and when objects are kept whole (a border round one may be longer).
    closing_px, margin_px
        Sides of the squares that close and widen the places where photographs differ.
    least_shift_px, most_shift_px
        Shifts of objects between two photographs that cost their square.
    shift_places
        Shares of the way between the two places of an object that get its cost: there it would
        be missing or shown twice.
    """

    slack: float = 0.25
    colour_unit: float = 3 * 20.0**2
    most_colour: float = 8.0
    least_colour: float = 1.0
    search_length_cost: float = 1.0
    kept_length_cost: float = 0.3
    closing_px: int = 9
    margin_px: int = 3
    least_shift_px: float = 1.0
    most_shift_px: float = 6.0
    shift_places: tuple[float, ...] = (0.0, 0.25, 0.5, 0.75, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class ObjectOptions:
    """Step 4: objects that borders cut, each given to one photograph.

    Attributes
    ----------
    rounds
        Least cost of a place that belongs to an object, and width in pixels below which links
        are cut: large objects first, then what stands highest of them.
    margin_px
        Pixels about an object that are looked at.
    score_worth
        What it costs to show a pixel by a photograph of lower score, over the score.
    least_score
        A photograph shows a pixel of an object if its score is higher.
    whole_share
        An object stays as it is unless the cost falls below this share.
    """

    rounds: tuple[tuple[float, int], ...] = (
        (2.5, 3), (2.5, 9), (6.0, 5), (6.0, 13), (12.0, 7), (24.0, 9),
    )  # fmt: skip
    margin_px: int = 3
    score_worth: float = 0.02
    least_score: float = 0.05
    whole_share: float = 0.6


@dataclass(frozen=True, slots=True, kw_only=True)
class ReliefOptions:
    """Step 5: heights of what stands on the ground, by plane sweep (Collins 1996).

    Attributes
    ----------
    lowest_share, highest_share
        Heights that are tried, over the flying height.
    step_px
        Shift between two of them, coarse pixels.
    compared_px
        Side of the windows that are correlated, coarse pixels: a waggon is some ten of them wide.
    noise_variance
        Added to the variance of grey levels: an area without structure correlates with nothing.
    edge_px
        Side of the square by which a photograph's area is eroded: windows at its edge are not
        complete.
    most_partners, enough
        Photographs compared with one, and how often a place shall be seen by them.
    new_share
        Share of the area that a further photograph must newly show.
    alike, more_alike
        Least correlation, and by how much it must exceed that of the ground.
    height_penalty
        Correlation subtracted for a height as large as the flying height.
    least_spot_px
        Smaller areas of height are chance, coarse pixels.
    smoothed_px
        Side of the mean over known heights, coarse pixels.
    nearby_px, usual_weight
        Side of the area whose heights are expected where none is known, and weight of the
        whole map's mean beside an area that is all known.
    unlike_stands
        Share of the places where two photographs do not correlate that stand above the ground,
        where truth was known.
    band_rows
        Rows that are computed at once: a limit of memory.
    """

    lowest_share: float = -0.04
    highest_share: float = 0.31
    step_px: float = 1.5
    compared_px: int = 7
    noise_variance: float = 9.0
    edge_px: int = 3
    most_partners: int = 3
    enough: int = 2
    new_share: float = 0.05
    alike: float = 0.5
    more_alike: float = 0.12
    height_penalty: float = 0.3
    least_spot_px: int = 8
    smoothed_px: int = 5
    nearby_px: int = 15
    usual_weight: float = 0.1
    unlike_stands: float = 0.45
    band_rows: int = 256


@dataclass(frozen=True, slots=True, kw_only=True)
class DrawingOptions:
    """All options of the drawing, in the order of its steps."""

    views: ViewOptions = field(default_factory=ViewOptions)
    vignetting: VignettingOptions = field(default_factory=VignettingOptions)
    gains: GainOptions = field(default_factory=GainOptions)
    seams: SeamOptions = field(default_factory=SeamOptions)
    objects: ObjectOptions = field(default_factory=ObjectOptions)
    relief: ReliefOptions = field(default_factory=ReliefOptions)
