# SPDX-License-Identifier: Apache-2.0
"""Lines on the ground: distance of places from a line and along it, resampling."""

from dataclasses import dataclass

import numpy as np

from rocsafe_scene.mesh.mesh import Floats

_BLOCK = 4096


@dataclass(frozen=True, slots=True, eq=False)
class Nearest:
    """Distance of places (n,) from a line, and distance along the line from its start, metres."""

    distance_m: Floats
    along_m: Floats


def nearest_on(line: Floats, places: Floats) -> Nearest:
    """Return for each of `places` (n, 2) its nearest point on `line` (k, 2)."""
    blocks = [
        _nearest(line, places[start : start + _BLOCK]) for start in range(0, len(places), _BLOCK)
    ]
    if not blocks:
        return Nearest(np.zeros(0), np.zeros(0))
    return Nearest(
        np.concatenate([block.distance_m for block in blocks]),
        np.concatenate([block.along_m for block in blocks]),
    )


def _nearest(line: Floats, places: Floats) -> Nearest:
    start, step = line[:-1], np.diff(line, axis=0)
    length = np.linalg.norm(step, axis=1)
    run = np.concatenate([[0.0], np.cumsum(length)])[:-1]
    offset = places[:, None] - start
    share = np.einsum('nkd,kd->nk', offset, step) / np.maximum(length**2, 1e-12)
    share = np.clip(share, 0.0, 1.0)
    gap = np.linalg.norm(offset - share[..., None] * step, axis=2)
    best = gap.argmin(axis=1)
    rows = np.arange(len(places))
    return Nearest(gap[rows, best], run[best] + share[rows, best] * length[best])


def run_of(line: Floats) -> Floats:
    """Return the distance of each point of `line` (k, d) from its start, along it."""
    steps = np.linalg.norm(np.diff(line, axis=0), axis=1)
    return np.concatenate([[0.0], np.cumsum(steps)])


def resampled(line: Floats, spacing_m: float) -> Floats:
    """Return `line` (k, d) with points about `spacing_m` apart, its ends kept."""
    run = run_of(line)
    count = max(2, round(float(run[-1]) / spacing_m) + 1)
    at = np.linspace(0.0, run[-1], count)
    return np.column_stack([np.interp(at, run, line[:, k]) for k in range(line.shape[1])])
