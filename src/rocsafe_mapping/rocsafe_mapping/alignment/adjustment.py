# SPDX-License-Identifier: Apache-2.0
"""Poses of photographs that fit ties and priors best (least squares, Levenberg-Marquardt).

Ties and fixes may be wrong and count robustly; all other priors count plainly. A tie's point may
stand off the ground: the spread of such heights is estimated from the residuals, and counts as
noise along the direction in which a height would move the point (so on rough ground ties hold
photographs like the epipolar lines of a free point, and on level ground like the plane).
"""

import dataclasses
import math
from collections.abc import Collection, Mapping, Sequence

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.equations import Equations, Unknowns
from rocsafe_mapping.alignment.matching import Pair
from rocsafe_mapping.alignment.normal import factored
from rocsafe_mapping.alignment.photo import Photo, footprint
from rocsafe_mapping.alignment.projection import Carried
from rocsafe_mapping.alignment.state import LEAST_TIE_STD_PX, Lens, Noise, State
from rocsafe_mapping.alignment.surface import level_grid
from rocsafe_mapping.alignment.ties import MOST_TIES, ties_of

MOST_STEPS = 12
LARGEST_TIE_STD_PX = 4.0
NORMAL_MAD = 1.4826
NORMAL_MEDIAN_RADIUS = 1.1774
# Ground rougher than this share of the flying height is worth a grid of heights.
LEVEL_SHARE = 0.0015
# Where a grid was needed, things smaller than its cells stand up at least so much.
ROUGH_SHARE = 0.015
TALL_SHARE, NORMAL_TALL = 0.9, 1.645
CELLS_PER_HEIGHT = 10.0
SURFACE_ROUNDS, TRUSTING_ROUNDS = 8, 6
# Fixes needed before their scatter says more than their own claim, and how much more at most.
LEAST_FIXES = 6
SMALLEST_FACTOR, LARGEST_FACTOR = 0.15, 8.0
SAMPLES = 16
# Ties of an adjustment of few photographs: the next one of all makes it exact.
MOST_WINDOW_TIES = 1200
FIRST_DAMPING, LARGEST_DAMPING = 1e-6, 1e6
LEAST_GAIN = 1e-4


def adjusted(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    state: State,
    free: Collection[str] | None = None,
) -> State:
    """Return `state` with poses, lenses, surface and noise that fit best.

    Parameters
    ----------
    photos, pairs: all that shall count; every photograph of a pair has a pose in `state`.
    free: photographs whose pose may change, None for all. With it lenses, surface and noise stay.
    """
    names = tuple(sorted(state.poses if free is None else free))
    most = MOST_TIES if free is None else MOST_WINDOW_TIES
    ties = ties_of(pairs, photos, held_out=False, most=most)
    unknowns = Unknowns.of(photos, names, with_lenses=free is None)
    if free is not None:
        return _settled(Equations(photos, ties, unknowns), state, MOST_STEPS // 3)
    equations = Equations(photos, ties, unknowns)
    state = _settled(equations, dataclasses.replace(state, noise=Noise()), MOST_STEPS)
    state = _settled(equations, _with_noise(equations, state), MOST_STEPS // 2)
    for round_number in range(SURFACE_ROUNDS):
        state = _with_noise(equations, state)
        if not _is_rough(photos, state):
            break
        state = _with_noise(equations, _with_surface(equations, state))
        if round_number < TRUSTING_ROUNDS:
            # Ground that was taken for level pulled photographs from their fixes: fixes are not
            # to blame for that, and are asked again.
            noise = dataclasses.replace(state.noise, fix_factor=min(state.noise.fix_factor, 1.0))
            state = dataclasses.replace(state, noise=noise)
        state = _settled(equations, state, MOST_STEPS // 4)
    return state


def stated_error_m(
    photos: Mapping[str, Photo], pairs: Sequence[Pair], state: State
) -> dict[str, float]:
    """Return the standard error of each photograph's corners on the ground, metres.

    It is that of random solutions drawn with the covariance of the adjustment.
    """
    names = tuple(sorted(state.poses))
    unknowns = Unknowns.of(photos, names, with_lenses=True)
    equations = Equations(photos, ties_of(pairs, photos, held_out=False), unknowns)
    jacobian, residuals = equations.rows(state)
    factor = factored(jacobian.T @ jacobian)
    draws = np.random.default_rng(0).standard_normal((len(residuals), SAMPLES))
    steps = factor.solve(np.asarray(jacobian.T @ draws))
    squares = np.zeros(len(names))
    for step in steps.T:
        moved = unknowns.moved(state, step)
        for number, name in enumerate(names):
            shift = _corners(photos[name], moved) - _corners(photos[name], state)
            squares[number] += np.mean(np.sum(shift**2, axis=1))
    return dict(zip(names, np.sqrt(squares / SAMPLES).tolist(), strict=True))


def _corners(photo: Photo, state: State) -> FloatArray:
    """Return the corners (4, 2) of a photograph on the ground, with its lens as found."""
    lens = state.lenses.get(photo.lens, Lens())
    return footprint(photo, state.poses[photo.name], math.exp(lens.log_focal))


def residuals_px(
    photos: Mapping[str, Photo], pairs: Sequence[Pair], state: State, *, held_out: bool
) -> FloatArray:
    """Return the residuals (n, 2) of the ties that were held out, or of those that were not."""
    ties = ties_of(pairs, photos, held_out=held_out)
    return ties.carried(state).residuals_px if len(ties) else np.zeros((0, 2))


def standing_m(
    photos: Mapping[str, Photo], pairs: Sequence[Pair], state: State
) -> tuple[FloatArray, FloatArray]:
    """Return where ties lie (n, 2) and how far above the surface their points stand (n,)."""
    ties = ties_of(pairs, photos, held_out=False)
    if not len(ties):
        return np.zeros((0, 2)), np.zeros(0)
    moved = ties.carried(state)
    return moved.ground_m, _rise(moved)


def _rise(moved: Carried) -> FloatArray:
    """Return the height above the surface that explains each residual best, metres."""
    sway = np.maximum(np.sum(moved.height**2, axis=1), 1e-9)
    rise: FloatArray = -np.sum(moved.height * moved.residuals_px, axis=1) / sway
    return rise


def _settled(equations: Equations, state: State, most_steps: int) -> State:
    """Return the state of least cost near `state`, its surface and noise unchanged."""
    damping = FIRST_DAMPING
    jacobian, residuals = equations.rows(state)
    cost = equations.cost(state)
    for _ in range(most_steps):
        normal = (jacobian.T @ jacobian).tocsc()
        # Longer on the diagonal where the step failed: the gradient's own direction in the end.
        normal.setdiag(normal.diagonal() * (1.0 + damping))
        step = factored(normal).solve(-(jacobian.T @ residuals))
        moved = equations.unknowns.moved(state, step)
        gain = cost - equations.cost(moved)
        if gain >= -1e-9 * cost:
            state, cost, damping = moved, cost - gain, max(0.1 * damping, 1e-9)
            if gain < LEAST_GAIN * cost:
                break
            jacobian, residuals = equations.rows(state)
        else:
            damping = max(100.0 * damping, 1e-3)
            if damping > LARGEST_DAMPING:
                break
    return state


def _with_noise(equations: Equations, state: State) -> State:
    """Return `state` with the noise that its residuals show."""
    moved = equations.ties.carried(state)
    along = moved.height / np.maximum(np.linalg.norm(moved.height, axis=1), 1e-9)[:, np.newaxis]
    across = np.column_stack([-along[:, 1], along[:, 0]])
    off_along = np.sum(moved.residuals_px * along, axis=1)
    off_across = np.sum(moved.residuals_px * across, axis=1)
    tie_std = float(
        np.clip(NORMAL_MAD * np.median(np.abs(off_across)), LEAST_TIE_STD_PX, LARGEST_TIE_STD_PX)
    )
    sway = float(np.median(np.linalg.norm(moved.height, axis=1)))
    # Not the median: where most of the ground is level, trees and roofs are a minority.
    tall = np.quantile(np.abs(off_along), TALL_SHARE) / NORMAL_TALL
    flat = max(np.quantile(np.abs(off_across), TALL_SHARE) / NORMAL_TALL, tie_std)
    clutter = float(np.sqrt(max(tall**2 - (1.2 * flat) ** 2, 0.0))) / max(sway, 1e-9)
    if not state.surface.is_level:
        height_m = np.median([pose.centre[2] for pose in state.poses.values()])
        clutter = max(clutter, ROUGH_SHARE * float(height_m))
    return dataclasses.replace(
        state,
        noise=Noise(
            tie_std_px=tie_std,
            clutter_std_m=clutter,
            fix_factor=_fix_factor(equations.photos, state),
        ),
    )


def _fix_factor(photos: Mapping[str, Photo], state: State) -> float:
    """Return how far fixes scatter over what they claim, from their median distance."""
    if len(state.poses) < LEAST_FIXES:
        return 1.0
    off = np.array(
        [
            (pose.centre[:2] - photos[name].prior.centre[:2]) / photos[name].horizontal_std_m
            for name, pose in sorted(state.poses.items())
        ]
    )
    # The block's own place, turn and scale were fitted to the fixes.
    lost = len(off) / (len(off) - 2.0)
    factor = np.median(np.linalg.norm(off, axis=1)) / NORMAL_MEDIAN_RADIUS * np.sqrt(lost)
    return float(np.clip(factor, SMALLEST_FACTOR, LARGEST_FACTOR))


def _is_rough(photos: Mapping[str, Photo], state: State) -> bool:
    height_m = np.median([photos[name].prior.centre[2] for name in state.poses])
    return not state.surface.is_level or state.noise.clutter_std_m > LEVEL_SHARE * height_m


def _with_surface(equations: Equations, state: State) -> State:
    """Return `state` with the surface that its ties show."""
    moved = equations.ties.carried(state)
    surface = state.surface
    if surface.is_level:
        height_m = np.median([pose.centre[2] for pose in state.poses.values()])
        surface = level_grid(moved.ground_m, float(height_m) / CELLS_PER_HEIGHT)
    sway = np.maximum(np.sum(moved.height**2, axis=1), 1e-9)
    std_m = state.noise.tie_std_px / np.sqrt(sway)
    heights = state.surface.at(moved.ground_m) + _rise(moved)
    return dataclasses.replace(state, surface=surface.fitted(moved.ground_m, heights, std_m))
