# SPDX-License-Identifier: Apache-2.0
"""The equations of the adjustment: which unknowns, residuals over their noise, derivatives."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.sparse import csr_matrix

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.projection import LENS_SIZE, POSE_SIZE, TieResiduals
from rocsafe_mapping.alignment.adjustment.rotation import tilt_and_yaw, turned
from rocsafe_mapping.alignment.adjustment.ties import Index, Ties
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment.model.state import Lens, State
from rocsafe_mapping.alignment_options import AdjustmentOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class Unknowns:
    """Which column of the equations belongs to what.

    Attributes
    ----------
    names
        Photographs whose pose is unknown, six columns each.
    lenses
        Lenses to be found, three columns each, after the poses; with the uncertainty of each focal
        length over itself.
    """

    names: tuple[str, ...]
    lenses: tuple[tuple[str, float], ...]

    @staticmethod
    def of(
        photos: Mapping[str, Photo], names: tuple[str, ...], *, with_lenses: bool
    ) -> 'Unknowns':
        """Return the unknowns of some photographs."""
        stds = {photos[name].lens: photos[name].focal_std_share for name in names}
        lenses = [(lens, std) for lens, std in sorted(stds.items()) if with_lenses and std > 0.0]
        return Unknowns(names=names, lenses=tuple(lenses))

    def __len__(self) -> int:
        return POSE_SIZE * len(self.names) + LENS_SIZE * len(self.lenses)

    def pose_columns(self, names: Sequence[str]) -> Index:
        """Return the first column of each name, -1 where its pose is known."""
        column = {name: POSE_SIZE * number for number, name in enumerate(self.names)}
        return np.array([column.get(name, -1) for name in names], np.int64)

    def lens_columns(self, lenses: Sequence[str]) -> Index:
        """Return the first column of each lens, -1 where it is known."""
        start = POSE_SIZE * len(self.names)
        column = {lens: start + LENS_SIZE * at for at, (lens, _) in enumerate(self.lenses)}
        return np.array([column.get(lens, -1) for lens in lenses], np.int64)

    def moved(self, state: State, step: FloatArray) -> State:
        """Return `state` changed by `step`."""
        poses, lenses = dict(state.poses), dict(state.lenses)
        for number, name in enumerate(self.names):
            change = step[POSE_SIZE * number : POSE_SIZE * (number + 1)]
            pose = poses[name]
            poses[name] = Pose(
                centre=pose.centre + change[:3], rotation=turned(change[3:]) @ pose.rotation
            )
        start = POSE_SIZE * len(self.names)
        for number, (name, _) in enumerate(self.lenses):
            change = step[start + LENS_SIZE * number : start + LENS_SIZE * (number + 1)]
            lens = lenses.get(name, Lens())
            lenses[name] = Lens(
                log_focal=lens.log_focal + change[0],
                k1=lens.k1 + change[1],
                k2=lens.k2 + change[2],
            )
        return replace(state, poses=poses, lenses=lenses)


class Equations:
    """Residuals over their standard deviations, and their derivatives.

    Parameters
    ----------
    photos
        With the priors.
    ties
        Between photographs that all have a pose.
    unknowns
        What may change.
    """

    def __init__(
        self,
        photos: Mapping[str, Photo],
        ties: Ties,
        unknowns: Unknowns,
        options: AdjustmentOptions,
    ) -> None:
        self.options = options
        self.photos = photos
        self.ties = ties
        self.unknowns = unknowns
        self._tie_columns = _columns(ties, unknowns)

    def cost(self, state: State) -> float:
        """Return the value that the adjustment minimises."""
        white = _whitened(self.ties.residuals(state), state)[0]
        square = np.sum(white**2, axis=1)
        knee = self.options.tie_knee**2
        ties = float(np.sum(2.0 * knee * (np.sqrt(1.0 + square / knee) - 1.0)))
        plain, fixes = self._prior_residuals(state)
        fix_knee = self.options.fix_knee**2
        fix_cost = float(np.sum(fix_knee * np.log1p(np.sum(fixes**2, axis=1) / fix_knee)))
        return ties + fix_cost + float(np.sum(plain**2)) + self._lens_cost(state)

    def rows(self, state: State) -> tuple[csr_matrix, FloatArray]:
        """Return Jacobian and residuals, weighted so that plain least squares is right."""
        moved = self.ties.derivatives(state)
        white, whiten = _whitened(moved.residuals, state)
        square = np.sum(white**2, axis=1)
        trust = (1.0 + square / self.options.tie_knee**2) ** -0.25
        whiten = whiten * trust[:, np.newaxis, np.newaxis]
        parts = (moved.first_pose, moved.second_pose, moved.first_lens, moved.second_lens)
        values = np.concatenate([whiten @ part for part in parts], axis=2)
        residuals = (white * trust[:, np.newaxis]).ravel()
        count = len(self.ties)
        lines = np.broadcast_to(np.arange(2 * count).reshape(count, 2, 1), values.shape)
        columns = np.broadcast_to(self._tie_columns[:, np.newaxis, :], values.shape)
        used = columns >= 0
        prior_values, prior_lines, prior_columns, prior_residuals = self._prior_rows(state)
        jacobian = csr_matrix(
            (
                np.concatenate([values[used], prior_values]),
                (
                    np.concatenate([lines[used], 2 * count + prior_lines]),
                    np.concatenate([columns[used], prior_columns]),
                ),
            ),
            shape=(2 * count + len(prior_residuals), len(self.unknowns)),
        )
        return jacobian, np.concatenate([residuals, prior_residuals])

    def _prior_residuals(self, state: State) -> tuple[FloatArray, FloatArray]:
        """Return the plain residuals (n, 4) - up, tilt, tilt, yaw - and those of fixes (n, 2)."""
        plain = np.zeros((len(self.unknowns.names), 4))
        fixes = np.zeros((len(self.unknowns.names), 2))
        for number, name in enumerate(self.unknowns.names):
            photo, pose = self.photos[name], state.poses[name]
            off = pose.centre - photo.prior.centre
            fixes[number] = off[:2] / (photo.horizontal_std_m * state.noise.fix_factor)
            tilt, yaw = tilt_and_yaw(pose, photo.prior)
            weight = float(abs(yaw) < self.options.yaw_knee_rad)
            plain[number] = (
                off[2] / photo.vertical_std_m,
                *(tilt / photo.tilt_std_rad),
                weight * yaw / photo.yaw_std_rad,
            )
        return plain, fixes

    def _prior_rows(self, state: State) -> tuple[FloatArray, Index, Index, FloatArray]:
        """Return values, lines, columns and residuals of the priors."""
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
        values = np.concatenate([values, lens_values])
        residuals = np.concatenate([residuals, lens_residuals])
        # Each prior row has one entry; poses and lenses follow in the order of their columns.
        places = np.arange(len(values), dtype=np.int64)
        return values, places, places, residuals

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


def _whitened(moved: TieResiduals, state: State) -> tuple[FloatArray, FloatArray]:
    """Return the residuals divided by their noise (n, 2), and the matrices (n, 2, 2) that do so.

    The covariance s^2 I + z^2 b b^T, b the derivative to the height, has the inverse root
    (I - (1 - 1 / sqrt(1 + z^2 b^2 / s^2)) b b^T / b^2) / s.
    """
    noise = state.noise
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
    parts = []
    for starts, index, size in (
        (poses, ties.first, POSE_SIZE),
        (poses, ties.second, POSE_SIZE),
        (lenses, ties.first, LENS_SIZE),
        (lenses, ties.second, LENS_SIZE),
    ):
        begin = starts[index][:, np.newaxis]
        parts.append(np.where(begin < 0, -1, begin + np.arange(size)))
    return np.concatenate(parts, axis=1)
