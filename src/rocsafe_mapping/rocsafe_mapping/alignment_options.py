# SPDX-License-Identifier: Apache-2.0
"""Options of the alignment: each constant that tunes the method, step by step.

Where no source is named, a value was chosen on the sets of ``benchmarks/mapping.py``: the paper's
survey, the derailment scene and the public set Brighton Beach.
"""

import math
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True, kw_only=True)
class PriorOptions:
    """How certain measurements on board are where the photograph does not say.

    Attributes
    ----------
    horizontal_std_m, vertical_std_m
        Standard deviation of a fix, metres: that of a GNSS receiver without corrections.
    tilt_std_rad, yaw_std_rad
        Standard deviation of a gimbal's attitude, radians.
    least_position_std_m, least_angle_std_rad
        Lower limits of what a photograph says: a receiver does not know the lens better.
    longest_reach
        Distance over the ground to the farthest corner that is used, over the height of the
        camera. At 5 (79 degrees off nadir) a pixel covers over twenty times its size at nadir.
    largest_relief_share
        Where altitude and height above ground differ by more than this share of the height, the
        ground is not nearly level: the height above ground is used.
    """

    horizontal_std_m: float = 2.5
    vertical_std_m: float = 1.5
    tilt_std_rad: float = math.radians(3.0)
    yaw_std_rad: float = math.radians(10.0)
    least_position_std_m: float = 0.02
    least_angle_std_rad: float = math.radians(0.1)
    longest_reach: float = 5.0
    largest_relief_share: float = 0.15


@dataclass(frozen=True, slots=True, kw_only=True)
class FeatureOptions:
    """Step 1: points of a photograph that can be found again in others.

    Attributes
    ----------
    count
        Features of a photograph.
    surplus
        ORB detects this many times as many; the strongest of each cell are kept.
    grid_cells
        Cells along each side of the image.
    search_side_px
        A larger picture is reduced to this long side: features of larger areas repeat better.
    contrast_limit, contrast_tiles
        Of CLAHE (Zuiderveld 1994), for pictures of little contrast.
    low_contrast
        Standard deviation of grey levels up to which contrast is raised.
    orb_fast_threshold, orb_scale_factor, orb_levels
        Of ORB (Rublee et al. 2011).
    sift_contrast
        Contrast threshold of SIFT (Lowe 2004).
    """

    count: int = 1500
    surplus: int = 3
    grid_cells: int = 12
    search_side_px: int = 1000
    contrast_limit: float = 2.0
    contrast_tiles: tuple[int, int] = (8, 6)
    low_contrast: float = 25.0
    orb_fast_threshold: int = 7
    orb_scale_factor: float = 1.3
    orb_levels: int = 6
    sift_contrast: float = 0.02


@dataclass(frozen=True, slots=True, kw_only=True)
class NeighbourOptions:
    """Step 2: photographs that may show the same ground.

    Attributes
    ----------
    most
        Neighbours of a photograph, those of largest overlap.
    margin_stds, most_margin_share
        Footprints grow by this many standard deviations of the fix, at most by this share of
        their size.
    least_overlap_share
        Overlap over the smaller footprint.
    disc_sides
        Segments of a quarter circle, for the footprint where the yaw is unknown.
    nearest
        Photographs of the nearest fixes that are neighbours where heights, hence footprints, are
        unknown.
    alike_features
        Strongest or coarsest features that show which photographs look alike without a fix.
    """

    most: int = 9
    margin_stds: float = 1.5
    most_margin_share: float = 0.5
    least_overlap_share: float = 0.08
    disc_sides: int = 4
    nearest: int = 5
    alike_features: int = 300


@dataclass(frozen=True, slots=True, kw_only=True)
class MatchingOptions:
    """Steps 3 and 4: matches of two photographs, and whether they can be believed.

    Attributes
    ----------
    ratio
        Largest distance of the best descriptor over that of the second best (Lowe 2004).
    few, many
        Strongest features used for the first homography: with and without help of the priors.
    coarse_inliers, coarse_share
        Least number and least share of its inliers.
    inlier_px
        Largest distance of an inlier from the homography.
    guided_margin_px
        Features that the first homography puts this far outside the other image are used.
    least_inliers, least_inlier_share
        Least number and share of inliers of the final homography.
    strong_inliers
        With fewer inliers the baseline must also agree with the fixes.
    least_cells, cell_share
        Inliers must lie in this many cells, whose side is this share of the image's height.
    smallest_scale, largest_scale
        Limits of the homography's scale, over that of the focal lengths and heights.
    largest_stretch
        Largest ratio of the two scales at one place, 1 / cos(tilt): 20 degrees each way.
    largest_bend
        Largest ratio of the areas that the homography gives a pixel at different places.
    most_ties, most_tall_ties, tie_cells
        Ties kept of a pair, on the plane and off it, spread over this many cells a side.
    held_out_every
        Each tie of this number is kept out of the adjustment, to judge it.
    baseline_stds, baseline_share
        Tolerance of the baseline: standard deviations of the fixes, and a share of its length.
    few_partners
        SIFT is tried for photographs with fewer partners.
    """

    ratio: float = 0.82
    few: int = 600
    many: int = 800
    coarse_inliers: int = 9
    coarse_share: float = 0.1
    inlier_px: float = 4.0
    guided_margin_px: float = 30.0
    least_inliers: int = 15
    least_inlier_share: float = 0.2
    strong_inliers: int = 45
    least_cells: int = 3
    cell_share: float = 0.2
    smallest_scale: float = 0.6
    largest_scale: float = 1.6
    largest_stretch: float = 1.25
    largest_bend: float = 1.9
    most_ties: int = 150
    most_tall_ties: int = 60
    tie_cells: int = 10
    held_out_every: int = 5
    baseline_stds: float = 4.0
    baseline_share: float = 0.3
    few_partners: int = 2


@dataclass(frozen=True, slots=True, kw_only=True)
class ParallaxOptions:
    """Step 4: matches of points above or below the ground's plane.

    Attributes
    ----------
    most_px, across_px
        Such a match lies this far along the parallax, and this far beside it.
    certainty
        Their number over that of the same band turned by a right angle, where only chance puts
        matches.
    least_baseline_px
        Distance of the cameras, in pixels of the image.
    """

    most_px: float = 26.0
    across_px: float = 3.0
    certainty: float = 2.5
    least_baseline_px: float = 60.0


@dataclass(frozen=True, slots=True, kw_only=True)
class RefinementOptions:
    """Step 4: ties made exact to a fraction of a pixel (Lucas, Kanade 1981).

    Attributes
    ----------
    window_px
        Side of the compared windows.
    largest_move_px
        A tie that moves farther was matched by chance.
    largest_error
        Mean difference of grey levels of the windows.
    least_share
        If fewer ties can be refined, all stay as they were.
    iterations, least_step_px
        Where the iteration ends.
    """

    window_px: int = 21
    largest_move_px: float = 6.0
    largest_error: float = 18.0
    least_share: float = 0.5
    iterations: int = 20
    least_step_px: float = 0.01


@dataclass(frozen=True, slots=True, kw_only=True)
class InitialOptions:
    """Steps 5 and 6: the graph of pairs, and first poses.

    Attributes
    ----------
    angle_scale_rad, log_scale
        Residual of turn and of log height at which a pair has half its weight.
    largest_turn_rad, largest_log_scale
        Residual at which a pair is rejected.
    shift_share, largest_shift_share
        The same of places, over the flying height; tilts alone move them by a tenth of it.
    most_passes
        Rounds of rejecting pairs.
    rounds, converged
        Reweighted least squares end after this many rounds, or when values move by less: radians,
        logarithms, or flying heights.
    most_full
        Photographs up to which equations are solved as a full matrix.
    guessed_height_share
        Heights less certain than this share of themselves are scaled to the fixes.
    found_height_share
        Standard deviation of a height that was found from the fixes, over the height.
    altitude_share
        Where the altitudes of fixes agree with heights to this share of the height, a photograph
        without ties has the height that its altitude says, else the median height.
    least_baselines
        Fixes show the scale if they spread over this many of their standard deviations.
    scale_certainty
        Heights from which the scale of the fixes differs by so many standard errors are scaled to
        the fixes, too.
    yaw_disbelief_rad
        Yaws of a group that disagree with its fixes by more are not used.
    """

    angle_scale_rad: float = math.radians(2.0)
    log_scale: float = 0.03
    largest_turn_rad: float = math.radians(9.0)
    largest_log_scale: float = 0.16
    shift_share: float = 0.03
    largest_shift_share: float = 0.25
    most_passes: int = 4
    rounds: int = 12
    converged: float = 1e-6
    most_full: int = 120
    guessed_height_share: float = 0.2
    found_height_share: float = 0.5
    altitude_share: float = 0.15
    least_baselines: float = 4.0
    scale_certainty: float = 4.0
    yaw_disbelief_rad: float = math.radians(20.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class PathOptions:
    """Step 6: fixes from the track of a vehicle.

    Attributes
    ----------
    horizontal_std_m
        Standard deviation of a track's point: that of a GNSS receiver without corrections.
    exposure_std_s
        The same of a time of exposure: most cameras tell whole seconds.
    least_photos, least_share
        Photographs without a fix whose clock can be found, and the share of them that must lie
        on the track.
    step_s, most_steps, candidates
        Offsets tried, and how many of the best of them are compared.
    largest_misfit
        What a similarity may leave of the track, over its spread.
    same_s, rival_factor
        Another offset, so much farther away, must leave this many times as much.
    least_spread_m
        Of the track at the photographs.
    """

    horizontal_std_m: float = 2.5
    exposure_std_s: float = 0.3
    least_photos: int = 5
    least_share: float = 0.8
    step_s: float = 0.5
    most_steps: int = 50_000
    candidates: int = 4
    largest_misfit: float = 0.15
    same_s: float = 5.0
    rival_factor: float = 1.5
    least_spread_m: float = 10.0


@dataclass(frozen=True, slots=True, kw_only=True)
class StructureOptions:
    """Structure from motion, for photographs that look in any direction.

    Attributes
    ----------
    count, search_side_px
        SIFT features of a photograph, and the long side of the picture that they are found in.
    neighbours
        Photographs of the nearest fixes that each is matched with, or most like it where it has no
        fix; of up to `all_up_to` photographs all are.
    least_matches, least_share, least_front_share
        Matches that fit the epipolar geometry, their share, and that of those before both cameras.
    epipolar_px, pose_px, point_px, knee_px
        Largest distance of a match from its epipolar line, of a point from a new photograph and
        from adjusted ones; residual from which a sighting loses weight.
    least_seen, least_pose_share
        Known points that a new photograph must show, and the share of them that must fit.
    least_angle_rad
        Between two rays, for a point to be used.
    good_angle_rad, widest_rad, seeds, least_seed_points
        Of the pair that a scene begins with; pairs tried that give so many points, of whose scenes
        the one with most sightings counts.
    growth
        The scene is adjusted when it has grown by this factor.
    bundle_steps, first_damping, largest_damping, least_gain
        Of Levenberg-Marquardt.
    plane_trials, plane_share, below_share
        Planes tried for the ground; how far off it a point of the ground may lie, over the height
        of the cameras; share of cameras, wrongly placed, that may lie below it.
    ground_share, longest_reach, least_ties, most_ties
        Points so near to the ground, over the height, seen at most so many heights away, become
        ties; a pair has so many.
    beside, largest_off_stds
        A photograph that shows no ground nearby lies beside so many that do, unless its fix lies
        so many standard deviations away.
    tilt_std_rad, focal_std_share
        How certain the tilts and the focal length are that were found.
    least_tied_share, most_photos
        Structure from motion is tried where a smaller share of at most so many photographs, whose
        attitude no gimbal tells, is tied in one group.
    """

    count: int = 2000
    search_side_px: int = 1600
    neighbours: int = 14
    all_up_to: int = 40
    least_matches: int = 20
    least_share: float = 0.2
    least_front_share: float = 0.7
    epipolar_px: float = 4.0
    pose_px: float = 10.0
    point_px: float = 8.0
    knee_px: float = 2.0
    least_seen: int = 10
    least_pose_share: float = 0.15
    least_angle_rad: float = math.radians(1.5)
    good_angle_rad: float = math.radians(12.0)
    widest_rad: float = math.radians(45.0)
    seeds: int = 5
    least_seed_points: int = 40
    growth: float = 1.15
    bundle_steps: int = 12
    first_damping: float = 1e-4
    largest_damping: float = 1e8
    least_gain: float = 1e-4
    plane_trials: int = 400
    plane_share: float = 0.02
    below_share: float = 0.05
    ground_share: float = 0.08
    longest_reach: float = 4.0
    least_ties: int = 12
    most_ties: int = 150
    beside: int = 4
    largest_off_stds: float = 6.0
    tilt_std_rad: float = math.radians(1.0)
    focal_std_share: float = 0.02
    least_tied_share: float = 0.9
    most_photos: int = 400


@dataclass(frozen=True, slots=True, kw_only=True)
class GroundOptions:
    """Step 8: the grid of ground heights.

    Attributes
    ----------
    relief_std_m
        Prior standard deviation of a height from level ground.
    bend_std_m
        Prior standard deviation of its second difference from cell to cell.
    clutter_std_m
        Spread of the heights of ties within a cell.
    cells_per_height
        Cells of the grid in one flying height.
    most_nodes
        A larger grid gets wider cells.
    rounds, settled_m
        Reweighted least squares end after this many rounds, or when heights move by less.
    samples
        Random grounds from which the standard error is computed.
    """

    relief_std_m: float = 6.0
    bend_std_m: float = 0.5
    clutter_std_m: float = 0.4
    cells_per_height: float = 10.0
    most_nodes: int = 40_000
    rounds: int = 4
    settled_m: float = 1e-3
    samples: int = 32


@dataclass(frozen=True, slots=True, kw_only=True)
class AdjustmentOptions:
    """Steps 7 and 8: the least squares adjustment of ties and priors.

    Attributes
    ----------
    most_steps
        Levenberg-Marquardt steps from first poses; later rounds have a share of them.
    first_damping, largest_damping, least_gain
        Damping over the diagonal, and the share of the cost below which a step is the last.
    tie_knee, fix_knee
        Residual over its standard deviation from which ties and fixes lose weight.
    yaw_knee_rad
        A yaw farther off is a fault and has no weight.
    radial_std
        Prior standard deviation of k1 and k2 of a camera that is not calibrated.
    lift_share
        Prior scale of a vehicle's lift (Cauchy's distribution), over the height that it tells.
    least_tie_std_px, largest_tie_std_px
        Limits of the estimated noise of ties.
    level_share
        Heights above the plane, over the flying height, from which the ground gets a grid.
    rough_share
        Where it has one, objects smaller than its cells are at least so high.
    tall_share
        Quantile of the residuals that shows the height of objects: most ground may be level.
    surface_rounds, trusting_rounds
        Rounds of heights and poses; in the first of them fixes are not blamed for ground that
        was taken for level.
    least_fixes
        Fixes from which their scatter is estimated.
    smallest_factor, largest_factor
        Limits of that scatter over what fixes claim.
    least_marks, largest_mark_factor
        The same for surveyed marks: 100 times 3 cm is a receiver without corrections.
    samples
        Random solutions from which the stated error is computed.
    most_ties, most_local_ties
        Ties of an adjustment of all photographs, and of one photograph with its neighbours.
    usual_ties
        The spread of heights about a node is that of all ties until this many lie there.
    correcting_fixes, correcting_reach
        A photograph without ties is moved like so many tied ones, at most so many flying heights
        away.
    """

    most_steps: int = 12
    first_damping: float = 1e-6
    largest_damping: float = 1e6
    least_gain: float = 1e-4
    tie_knee: float = 2.0
    fix_knee: float = 2.0
    yaw_knee_rad: float = math.radians(25.0)
    radial_std: tuple[float, float] = (0.05, 0.05)
    lift_share: float = 0.02
    least_tie_std_px: float = 0.15
    largest_tie_std_px: float = 4.0
    level_share: float = 0.0015
    rough_share: float = 0.015
    tall_share: float = 0.9
    surface_rounds: int = 8
    trusting_rounds: int = 6
    least_fixes: int = 6
    smallest_factor: float = 0.15
    largest_factor: float = 8.0
    least_marks: int = 4
    largest_mark_factor: float = 100.0
    samples: int = 48
    most_ties: int = 150_000
    most_local_ties: int = 1200
    usual_ties: float = 3.0
    correcting_fixes: int = 4
    correcting_reach: float = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class ClockOptions:
    """Step 9: fixes that are late.

    Attributes
    ----------
    least_photos, least_speed_mps
        Photographs of a vehicle in flight that are needed, and what flight is.
    certainty, left_share
        A lag is used if it is so many standard errors long, and leaves so little of the residuals.
    largest_lag_s
        A longer one is a fault of another kind.
    straight_cosine
        Between two legs: where the path turns by more, the velocity is not known.
    rounds, knee
        Of the reweighted least squares.
    """

    least_photos: int = 5
    least_speed_mps: float = 0.5
    certainty: float = 5.0
    left_share: float = 0.6
    largest_lag_s: float = 10.0
    straight_cosine: float = 0.9
    rounds: int = 12
    knee: float = 2.0


@dataclass(frozen=True, slots=True, kw_only=True)
class AlignmentOptions:
    """All options of the alignment, in the order of its steps."""

    prior: PriorOptions = field(default_factory=PriorOptions)
    features: FeatureOptions = field(default_factory=FeatureOptions)
    neighbours: NeighbourOptions = field(default_factory=NeighbourOptions)
    matching: MatchingOptions = field(default_factory=MatchingOptions)
    parallax: ParallaxOptions = field(default_factory=ParallaxOptions)
    refinement: RefinementOptions = field(default_factory=RefinementOptions)
    initial: InitialOptions = field(default_factory=InitialOptions)
    structure: StructureOptions = field(default_factory=StructureOptions)
    path: PathOptions = field(default_factory=PathOptions)
    adjustment: AdjustmentOptions = field(default_factory=AdjustmentOptions)
    ground: GroundOptions = field(default_factory=GroundOptions)
    clock: ClockOptions = field(default_factory=ClockOptions)
