# SPDX-License-Identifier: Apache-2.0
"""The equations of the adjustment: which unknowns, residuals over their noise, derivatives."""

from collections.abc import Mapping, Sequence
from typing import NamedTuple

import numpy as np
from scipy.sparse import csr_matrix

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.projection import (
    LENS_SIZE,
    POSE_SIZE,
    TieDerivatives,
    TieResiduals,
)
from rocsafe_mapping.alignment.adjustment.rotation import tilt_and_yaw
from rocsafe_mapping.alignment.adjustment.sightings import Sightings, pointing_noise
from rocsafe_mapping.alignment.adjustment.ties import Index, Ties
from rocsafe_mapping.alignment.adjustment.unknowns import MARK_SIZE, Unknowns
from rocsafe_mapping.alignment.model.mark import MARK_STD_M
from rocsafe_mapping.alignment.model.photo import Photo
from rocsafe_mapping.alignment.model.state import Lens, Noise, State
from rocsafe_mapping.alignment_options import AdjustmentOptions

# Row of the height among the priors of a pose.
_UP = 2


class Equations:
    """Residuals over their standard deviations, and their derivatives.

    Parameters
    ----------
    photos
        With the priors.
    ties
        Between photographs that all have a pose.
    sightings
        Of surveyed marks in photographs that have a pose.
    unknowns
        What may change.
    """

    def __init__(
        self,
        photos: Mapping[str, Photo],
        ties: Ties,
        sightings: Sightings,
        unknowns: Unknowns,
        options: AdjustmentOptions,
    ) -> None:
        self.options = options
        self.photos = photos
        self.ties = ties
        self.sightings = sightings
        self.unknowns = unknowns
        self._tie_columns = _columns(ties, unknowns)
        self._sighting_columns = _sighting_columns(sightings, unknowns)
        self._lift_columns = unknowns.lift_columns(
            [photos[name].vehicle for name in unknowns.names]
        )

    def cost(self, state: State) -> float:
        """Return the value that the adjustment minimises."""
        ties = self._seen_cost(self.ties.residuals(state), state.noise)
        if self.unknowns.marks:
            moved = self.sightings.residuals(state)
            ties += self._seen_cost(moved, pointing_noise(state.noise))
        plain, fixes = self._prior_residuals(state)
        knee = self.options.fix_knee**2
        held = np.concatenate([fixes, _mark_residuals(state)])
        held_cost = float(np.sum(knee * np.log1p(np.sum(held**2, axis=1) / knee)))
        lift_cost = float(np.sum(np.log1p(self._lift_residuals(state) ** 2)))
        return ties + held_cost + lift_cost + float(np.sum(plain**2)) + self._lens_cost(state)

    def _seen_cost(self, moved: TieResiduals, noise: Noise) -> float:
        square = np.sum(_whitened(moved, noise)[0] ** 2, axis=1)
        knee = self.options.tie_knee**2
        return float(np.sum(2.0 * knee * (np.sqrt(1.0 + square / knee) - 1.0)))

    def rows(self, state: State) -> tuple[csr_matrix, FloatArray]:
        """Return Jacobian and residuals, weighted so that plain least squares is right.

        Rows: ties, priors of poses, lenses and lifts, sightings and surveyed places of marks.
        """
        blocks = [self._seen_rows(self.ties.derivatives(state), self._tie_columns, state.noise)]
        values, residuals = self._prior_rows(state)
        # A prior has the column of its own row, that of a height also the column of a lift.
        columns = np.column_stack([np.arange(len(values)), np.full(len(values), -1)])
        columns[_UP : POSE_SIZE * len(self.unknowns.names) : POSE_SIZE, 1] = self._lift_columns
        blocks.append(_Rows(np.column_stack([values, -values]), columns, residuals))
        if self.unknowns.marks:
            moved = self.sightings.derivatives(state)
            noise = pointing_noise(state.noise)
            blocks.append(self._seen_rows(moved, self._sighting_columns, noise))
            blocks.append(self._mark_rows(state))
        return _stacked(blocks, len(self.unknowns))

    def _seen_rows(self, moved: TieDerivatives, columns: Index, noise: Noise) -> '_Rows':
        """Return the rows of what photographs show, two each."""
        white, whiten = _whitened(moved.residuals, noise)
        square = np.sum(white**2, axis=1)
        trust = (1.0 + square / self.options.tie_knee**2) ** -0.25
        whiten = whiten * trust[:, np.newaxis, np.newaxis]
        parts = (moved.first_pose, moved.second_pose, moved.first_lens, moved.second_lens)
        values = np.concatenate([whiten @ part for part in parts], axis=2)
        return _Rows(
            values.reshape(-1, values.shape[2]),
            np.repeat(columns, 2, axis=0),
            (white * trust[:, np.newaxis]).ravel(),
        )

    def _mark_rows(self, state: State) -> '_Rows':
        off = _mark_residuals(state)
        trust = 1.0 / np.sqrt(1.0 + np.sum(off**2, axis=1) / self.options.fix_knee**2)
        weight = np.repeat(trust / (MARK_STD_M * state.noise.mark_factor), MARK_SIZE)
        columns = self.unknowns.mark_columns()[:, np.newaxis] + np.arange(MARK_SIZE)
        return _Rows(
            weight[:, np.newaxis], columns.reshape(-1, 1), (off * trust[:, np.newaxis]).ravel()
        )

    def _prior_residuals(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Return the plain residuals (n, 4) - up, tilt, tilt, yaw - and those of fixes (n, 2)."""
        plain = np.zeros((len(self.unknowns.names), 4))
        fixes = np.zeros((len(self.unknowns.names), 2))
        for number, name in enumerate(self.unknowns.names):
            photo, pose = self.photos[name], state.poses[name]
            off = pose.centre - photo.prior.centre
            off[2] -= state.lifts_m.get(photo.vehicle, 0.0)
            fixes[number] = off[:2] / (photo.horizontal_std_m * state.noise.fix_factor)
            tilt, yaw = tilt_and_yaw(pose, photo.prior)
            weight = float(abs(yaw) < self.options.yaw_knee_rad)
            plain[number] = (
                off[2] / photo.vertical_std_m,
                *(tilt / photo.tilt_std_rad),
                weight * yaw / photo.yaw_std_rad,
            )
        return plain, fixes

    def _prior_rows(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Return values and residuals of the priors."""
        plain, fixes = self._prior_residuals(state)
        trust = 1.0 / np.sqrt(1.0 + np.sum(fixes**2, axis=1) / self.options.fix_knee**2)
        stds = np.array(
            [
                (
                    photo.horizontal_std_m,
                    photo.vertical_std_m,
                    photo.tilt_std_rad,
                    photo.yaw_std_rad,
                )
                for photo in (self.photos[name] for name in self.unknowns.names)
            ]
        ).reshape(-1, 4)
        by_fix = trust / (stds[:, 0] * state.noise.fix_factor)
        yaw_weight = np.array(
            [
                abs(tilt_and_yaw(state.poses[name], self.photos[name].prior)[1])
                < self.options.yaw_knee_rad
                for name in self.unknowns.names
            ]
        )
        values = np.column_stack(
            [
                by_fix,
                by_fix,
                1.0 / stds[:, 1],
                1.0 / stds[:, 2],
                1.0 / stds[:, 2],
                yaw_weight / stds[:, 3],
            ]
        ).ravel()
        residuals = np.column_stack([fixes * trust[:, np.newaxis], plain]).ravel()
        lens_values, lens_residuals = self._lens_rows(state)
        lift_values, lift_residuals = self._lift_rows(state)
        return (
            np.concatenate([values, lens_values, lift_values]),
            np.concatenate([residuals, lens_residuals, lift_residuals]),
        )

    def _lift_residuals(self, state: State) -> FloatArray:
        lifts = self.unknowns.lifts
        return np.array([state.lifts_m.get(vehicle, 0.0) / std for vehicle, std in lifts])

    def _lift_rows(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Return values and residuals of the priors of lifts: Cauchy's, whose tails are heavy."""
        off = self._lift_residuals(state)
        trust = 1.0 / np.sqrt(1.0 + off**2)
        return trust / np.array([std for _, std in self.unknowns.lifts]), off * trust

    def _lens_rows(self, state: State) -> tuple[FloatArray, FloatArray]:
        values, residuals = [], []
        for name, focal_std in self.unknowns.lenses:
            lens = state.lenses.get(name, Lens())
            stds = np.array([focal_std, *self.options.radial_std])
            values.append(1.0 / stds)
            residuals.append(np.array([lens.log_focal, lens.k1, lens.k2]) / stds)
        if not values:
            return np.zeros(0), np.zeros(0)
        return np.concatenate(values), np.concatenate(residuals)

    def _lens_cost(self, state: State) -> float:
        return float(np.sum(self._lens_rows(state)[1] ** 2))


class _Rows(NamedTuple):
    """Rows of the equations: values and columns (n, k), -1 for known ones; residuals (n,)."""

    values: FloatArray
    columns: Index
    residuals: FloatArray


def _stacked(blocks: Sequence[_Rows], width: int) -> tuple[csr_matrix, FloatArray]:
    """Return blocks of rows as one sparse matrix with `width` columns, and their residuals."""
    starts = np.cumsum([0, *(len(block.values) for block in blocks)])
    values, lines, columns = [], [], []
    for start, block in zip(starts, blocks, strict=False):
        used = block.columns >= 0
        values.append(block.values[used])
        columns.append(block.columns[used])
        lines.append(start + np.nonzero(used)[0])
    places = np.concatenate(lines), np.concatenate(columns)
    jacobian = csr_matrix((np.concatenate(values), places), shape=(int(starts[-1]), width))
    return jacobian, np.concatenate([block.residuals for block in blocks])


def _mark_residuals(state: State) -> FloatArray:
    """Return how far marks lie from where they were surveyed, over the noise, (n, 2)."""
    off = np.array([mark.found_m - mark.surveyed_m for mark in state.marks]).reshape(-1, 2)
    residuals: FloatArray = off / (MARK_STD_M * state.noise.mark_factor)
    return residuals


def _whitened(moved: TieResiduals, noise: Noise) -> tuple[FloatArray, FloatArray]:
    """Return the residuals divided by their noise (n, 2), and the matrices (n, 2, 2) that do so.

    The covariance s^2 I + z^2 b b^T, b the derivative to the height, has the inverse root
    (I - (1 - 1 / sqrt(1 + z^2 b^2 / s^2)) b b^T / b^2) / s.
    """
    sway = np.linalg.norm(moved.height, axis=1)
    along = moved.height / np.maximum(sway, 1e-9)[:, np.newaxis]
    ratio = noise.clutter_std_m * sway / noise.tie_std_px
    share = 1.0 - 1.0 / np.sqrt(1.0 + ratio**2)
    outer = along[:, :, np.newaxis] * along[:, np.newaxis, :]
    whiten = (np.eye(2) - share[:, np.newaxis, np.newaxis] * outer) / noise.tie_std_px
    return np.einsum('nij,nj->ni', whiten, moved.residuals_px), whiten


def _columns(ties: Ties, unknowns: Unknowns) -> Index:
    """Return the columns of a tie's derivatives, -1 for known values, shape (n, 18)."""
    poses, lenses = unknowns.pose_columns(ties.names), unknowns.lens_columns(ties.lenses)
    return _spread(
        (poses[ties.first], POSE_SIZE), (poses[ties.second], POSE_SIZE),
        (lenses[ties.first], LENS_SIZE), (lenses[ties.second], LENS_SIZE),
    )  # fmt: skip


def _sighting_columns(sightings: Sightings, unknowns: Unknowns) -> Index:
    """Return the columns of a sighting's derivatives, -1 for known values, shape (n, 11)."""
    return _spread(
        # The third derivative to the mark's place is that to its height, which is the ground's.
        (unknowns.mark_columns()[sightings.marks], MARK_SIZE),
        (np.full(len(sightings), -1), 1),
        (unknowns.pose_columns(sightings.names), POSE_SIZE),
        (unknowns.lens_columns(sightings.lenses), LENS_SIZE),
    )


def _spread(*groups: tuple[Index, int]) -> Index:
    """Return the columns (n, k) of groups of first columns (n,), -1 where known, and sizes."""
    parts = [
        np.where(first[:, np.newaxis] < 0, -1, first[:, np.newaxis] + np.arange(size))
        for first, size in groups
    ]
    return np.concatenate(parts, axis=1)
