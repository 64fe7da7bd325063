# SPDX-License-Identifier: Apache-2.0
"""Least squares adjustment of poses, lenses and ground heights (Levenberg-Marquardt).

Ties and fixes have a robust cost, as they may be outliers; other priors a quadratic one. The point
of a tie may lie above the ground: the spread of such heights is estimated from the residuals and
added to the noise along the direction in which a height moves the point. On rough ground a tie
then constrains like an epipolar line, on level ground like a plane.
"""

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.equations import Equations
from rocsafe_mapping.alignment.adjustment.fix_noise import fix_errors_m
from rocsafe_mapping.alignment.adjustment.height_error import TieHeights
from rocsafe_mapping.alignment.adjustment.projection import POSE_SIZE, TieResiduals
from rocsafe_mapping.alignment.adjustment.sightings import sightings_of
from rocsafe_mapping.alignment.adjustment.ties import ties_of
from rocsafe_mapping.alignment.adjustment.unknowns import Unknowns
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.model.mark import MARK_STD_M
from rocsafe_mapping.alignment.model.normal_equations import factored
from rocsafe_mapping.alignment.model.photo import Photo, footprint
from rocsafe_mapping.alignment.model.state import Lens, Noise, State
from rocsafe_mapping.alignment.model.surface import level_grid
from rocsafe_mapping.alignment_options import AdjustmentOptions, AlignmentOptions, GroundOptions

NORMAL_MAD = 1.4826
NORMAL_MEDIAN_RADIUS = 1.1774
# Quantiles of the normal distribution: 0.9 of its absolute values.
NORMAL_TALL = 1.645


def adjusted(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    state: State,
    options: AlignmentOptions,
    free: Collection[str] | None = None,
) -> State:
    """Return `state` with poses, lenses, surface and noise that fit best.

    Parameters
    ----------
    photos, pairs
        All that shall count; every photograph of a pair has a pose in `state`.
    free
        Photographs whose pose may change, None for all. With it lenses, lifts, surface and noise
        stay.
    """
    steps = options.adjustment.most_steps
    names = tuple(sorted(state.poses if free is None else free))
    most = options.adjustment.most_ties if free is None else options.adjustment.most_local_ties
    ties = ties_of(pairs, photos, held_out=False, most=most)
    unknowns = Unknowns.of(
        photos, names, len(state.marks), options.adjustment, with_shared=free is None
    )
    sightings = sightings_of(state.marks, photos, state)
    equations = Equations(photos, ties, sightings, unknowns, options.adjustment)
    if free is not None:
        return _settled(equations, state, steps // 3)
    state = _settled(equations, dataclasses.replace(state, noise=Noise()), steps)
    state = _settled(equations, _with_noise(equations, state), steps // 2)
    for round_number in range(options.adjustment.surface_rounds):
        state = _with_noise(equations, state)
        if not _is_rough(photos, state, options.adjustment.level_share):
            break
        state = _with_noise(equations, _with_surface(equations, state, options.ground))
        if round_number < options.adjustment.trusting_rounds:
            # Errors of the level ground moved photographs from their fixes: the scatter of the
            # fixes is not increased for that.
            noise = dataclasses.replace(state.noise, fix_factor=min(state.noise.fix_factor, 1.0))
            state = dataclasses.replace(state, noise=noise)
        state = _settled(equations, state, steps // 4)
    return state


def stated_error_m(
    photos: Mapping[str, Photo], pairs: Sequence[Pair], state: State, options: AdjustmentOptions
) -> dict[str, float]:
    """Return the standard error of each photograph's corners on the ground, metres.

    It is computed from random solutions drawn with the covariance of the adjustment; the errors of
    fixes are drawn as their residuals show them, see `fix_noise`.
    """
    names = tuple(sorted(state.poses))
    unknowns = Unknowns.of(photos, names, len(state.marks), options)
    ties = ties_of(pairs, photos, held_out=False, most=options.most_ties)
    sightings = sightings_of(state.marks, photos, state)
    equations = Equations(photos, ties, sightings, unknowns, options)
    jacobian, residuals = equations.rows(state)
    factor = factored(jacobian.T @ jacobian)
    draws = np.random.default_rng(0).standard_normal((len(residuals), options.samples))
    _draw_fixes(draws[2 * len(ties) :], photos, names, state)
    steps = factor.solve(np.asarray(jacobian.T @ draws))
    squares = np.zeros(len(names))
    for step in steps.T:
        moved = unknowns.moved(state, step)
        for number, name in enumerate(names):
            shift = _corners(photos[name], moved) - _corners(photos[name], state)
            squares[number] += np.mean(np.sum(shift**2, axis=1))
    return dict(zip(names, np.sqrt(squares / options.samples).tolist(), strict=True))


def _draw_fixes(
    draws: FloatArray, photos: Mapping[str, Photo], names: Sequence[str], state: State
) -> None:
    """Replace the draws of fixes, two of six rows a photograph, by errors as residuals show."""
    rng = np.random.default_rng(1)
    for order in _in_time(photos, names):
        found = [state.poses[names[at]].centre[:2] for at in order]
        fixes = [photos[names[at]].prior.centre[:2] for at in order]
        claimed_m = float(np.median([photos[names[at]].horizontal_std_m for at in order]))
        errors_m = fix_errors_m(np.array(fixes), np.array(found), claimed_m, draws.shape[1], rng)
        for at, error_m in zip(order, errors_m, strict=True):
            std_m = photos[names[at]].horizontal_std_m * state.noise.fix_factor
            draws[POSE_SIZE * at : POSE_SIZE * at + 2] = error_m / std_m


def _in_time(photos: Mapping[str, Photo], names: Sequence[str]) -> list[list[int]]:
    """Return the indices of the fixes of each vehicle, in the order of their times."""
    found: dict[str, list[int]] = {}
    for at in sorted(range(len(names)), key=lambda at: (photos[names[at]].time_ns, names[at])):
        if not photos[names[at]].has_fix:
            continue
        found.setdefault(photos[names[at]].vehicle, []).append(at)
    return list(found.values())


def _corners(photo: Photo, state: State) -> FloatArray:
    """Return the corners (4, 2) of a photograph on the ground, with its lens as found."""
    lens = state.lenses.get(photo.lens, Lens())
    return footprint(photo, state.poses[photo.name], math.exp(lens.log_focal))


def residuals_px(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    state: State,
    most: int,
    *,
    held_out: bool,
) -> FloatArray:
    """Return the residuals (n, 2) of the ties that were held out, or of those that were not."""
    ties = ties_of(pairs, photos, held_out=held_out, most=most)
    return ties.residuals(state).residuals_px if len(ties) else np.zeros((0, 2))


def tie_heights(
    photos: Mapping[str, Photo], pairs: Sequence[Pair], state: State, most: int
) -> TieHeights:
    """Return how high the points of ties stand: what explains each residual best."""
    ties = ties_of(pairs, photos, held_out=False, most=most)
    if not len(ties):
        return TieHeights(places_m=np.zeros((0, 2)), standing_m=np.zeros(0), stds_m=np.zeros(0))
    return _heights(ties.residuals(state), state)


def _heights(moved: TieResiduals, state: State) -> TieHeights:
    # Pixels that a metre of height moves a point: few where both cameras stood at one place.
    sway = np.sqrt(np.maximum(np.sum(moved.height**2, axis=1), 1e-9))
    return TieHeights(
        places_m=moved.ground_m,
        standing_m=-np.sum(moved.height * moved.residuals_px, axis=1) / sway**2,
        stds_m=state.noise.tie_std_px / sway,
    )


def _settled(equations: Equations, state: State, most_steps: int) -> State:
    """Return the state of least cost near `state`, with the same surface and noise."""
    damping = equations.options.first_damping
    jacobian, residuals = equations.rows(state)
    cost = equations.cost(state)
    for _ in range(most_steps):
        normal = (jacobian.T @ jacobian).tocsc()
        # After a failed step the damping grows, and the step turns towards the gradient.
        normal.setdiag(normal.diagonal() * (1.0 + damping))
        step = factored(normal).solve(-(jacobian.T @ residuals))
        moved = equations.unknowns.moved(state, step)
        gain = cost - equations.cost(moved)
        if gain >= -1e-9 * cost:
            state, cost, damping = moved, cost - gain, max(0.1 * damping, 1e-9)
            if gain < equations.options.least_gain * cost:
                break
            jacobian, residuals = equations.rows(state)
        else:
            damping = max(100.0 * damping, 1e-3)
            if damping > equations.options.largest_damping:
                break
    return state


def _with_noise(equations: Equations, state: State) -> State:
    """Return `state` with the noise that its residuals show."""
    options = equations.options
    moved = equations.ties.residuals(state)
    along = moved.height / np.maximum(np.linalg.norm(moved.height, axis=1), 1e-9)[:, np.newaxis]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    off_along = np.sum(moved.residuals_px * along, axis=1)
    off_across = np.sum(moved.residuals_px * across, axis=1)
    tie_std = float(
        np.clip(
            NORMAL_MAD * np.median(np.abs(off_across)),
            options.least_tie_std_px,
            options.largest_tie_std_px,
        )
    )
    sway = float(np.median(np.linalg.norm(moved.height, axis=1)))
    # A high quantile: where most of the ground is level, trees and roofs are a minority.
    tall = np.quantile(np.abs(off_along), options.tall_share) / NORMAL_TALL
    flat = max(np.quantile(np.abs(off_across), options.tall_share) / NORMAL_TALL, tie_std)
    clutter = float(np.sqrt(max(tall**2 - (1.2 * flat) ** 2, 0.0))) / max(sway, 1e-9)
    if not state.surface.is_level:
        height_m = np.median([pose.centre[2] for pose in state.poses.values()])
        clutter = max(clutter, options.rough_share * float(height_m))
    return dataclasses.replace(
        state,
        noise=Noise(
            tie_std_px=tie_std,
            clutter_std_m=clutter,
            fix_factor=_fix_factor(equations.photos, state, options),
            mark_factor=_mark_factor(state, options),
        ),
    )


def _fix_factor(photos: Mapping[str, Photo], state: State, options: AdjustmentOptions) -> float:
    """Return the scatter of the fixes over their stated one, from their median distance."""
    off = [
        (pose.centre[:2] - photos[name].prior.centre[:2]) / photos[name].horizontal_std_m
        for name, pose in sorted(state.poses.items())
        if photos[name].has_fix
    ]
    factor = _scatter(off) if len(off) >= options.least_fixes else 1.0
    return float(np.clip(factor, options.smallest_factor, options.largest_factor))


def _mark_factor(state: State, options: AdjustmentOptions) -> float:
    """Return the scatter of surveyed marks over `MARK_STD_M`, at least 1."""
    off = [(mark.found_m - mark.surveyed_m) / MARK_STD_M for mark in state.marks]
    factor = _scatter(off) if len(off) >= options.least_marks else 1.0
    return float(np.clip(factor, 1.0, options.largest_mark_factor))


def _scatter(off: Sequence[FloatArray]) -> float:
    """Return the standard deviation of residuals (2,) in the plane, from their median length."""
    # The block's own place, turn and scale were fitted to them.
    lost = len(off) / (len(off) - 2.0)
    median = float(np.median(np.linalg.norm(np.array(off), axis=1)))
    return median / NORMAL_MEDIAN_RADIUS * math.sqrt(lost)


def _is_rough(photos: Mapping[str, Photo], state: State, level_share: float) -> bool:
    height_m = np.median([photos[name].prior.centre[2] for name in state.poses])
    return not state.surface.is_level or state.noise.clutter_std_m > level_share * height_m


def _with_surface(equations: Equations, state: State, options: GroundOptions) -> State:
    """Return `state` with the surface that its ties show."""
    moved = equations.ties.residuals(state)
    surface = state.surface
    if surface.is_level:
        height_m = np.median([pose.centre[2] for pose in state.poses.values()])
        surface = level_grid(
            moved.ground_m, float(height_m) / options.cells_per_height, options.most_nodes
        )
    found = _heights(moved, state)
    heights = state.surface.at(moved.ground_m) + found.standing_m
    return dataclasses.replace(
        state, surface=surface.fitted(moved.ground_m, heights, found.stds_m, options)
    )
