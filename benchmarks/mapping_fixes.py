# SPDX-License-Identifier: Apache-2.0
"""Compares the error that fixes leave in a map with the one that their residuals show.

The surveys are those of `mapping_families`, but without photographs: a block of known shape is
laid on its fixes by shift, turn and scale. So thousands of surveys take seconds, and what the
noise of the fixes alone does is seen. Beside it stands what could be stated if the noise of the
fixes were known exactly: the error of one survey is one draw, and no statement can foretell it.
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from mapping_families import CAMERA, CLAIMED_M, PARTS, Survey, drawn, viewpoints

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.adjustment.fix_noise import fix_errors_m

SAMPLES = 200
WITHIN = 2.0 / 3.0, 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """RMS errors of a block's corners, metres.

    Attributes
    ----------
    true_m, stated_m, ideal_m
        As they are, as the residuals show them, and as the true noise would tell them.
    """

    true_m: float
    stated_m: float
    ideal_m: float


def tried(survey: Survey, seed: int) -> Outcome:
    """Lay the block of a survey on its fixes."""
    rng = np.random.default_rng([seed, 18])
    places = viewpoints(survey)
    spread = places - places.mean(axis=0)
    reach_m = survey.height_m * math.tan(CAMERA.horizontal_fov_rad / 2.0) * np.array([1.0, 0.75])
    corners = (spread[:, np.newaxis] + reach_m * _SIGNS).reshape(-1, 2)
    off = drifting(len(places), survey, 1, rng)[..., 0]
    left = off - _similarity(spread, spread, off)
    stated = fix_errors_m(places + left, places, CLAIMED_M, SAMPLES, rng)
    ideal = drifting(len(places), survey, SAMPLES, rng)
    return Outcome(
        true_m=_rms_m(_similarity(spread, corners, off)),
        stated_m=_rms_m(_similarity(spread, corners, stated)),
        ideal_m=_rms_m(_similarity(spread, corners, ideal)),
    )


_SIGNS = np.array([(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)])


def drifting(count: int, survey: Survey, samples: int, rng: np.random.Generator) -> FloatArray:
    """Return errors of fixes (count, 2, samples) with the survey's noise and drift, metres."""
    errors: FloatArray = rng.normal(0.0, survey.fix_m, (count, 2, samples))
    fresh = math.sqrt(1.0 - survey.drift**2)
    for number in range(1, count):
        errors[number] = survey.drift * errors[number - 1] + fresh * errors[number]
    return errors


def _similarity(spread: FloatArray, points: FloatArray, off: FloatArray) -> FloatArray:
    """Return how errors `off` (n, 2, ...) at `spread` move `points`: shift, turn and scale."""
    plane, moved = spread @ [1.0, 1.0j], off[:, 0] + 1.0j * off[:, 1]
    factor = np.tensordot(np.conj(plane), moved, axes=(0, 0)) / np.sum(np.abs(plane) ** 2)
    shift = moved.mean(axis=0) + np.multiply.outer(points @ [1.0, 1.0j], factor)
    return np.stack([shift.real, shift.imag], axis=1)


def _rms_m(off: FloatArray) -> float:
    return float(np.sqrt(np.mean(np.sum(off**2, axis=1))))


def row(outcomes: Sequence[Outcome]) -> str:
    """Return what came of some surveys."""
    true, stated, ideal = np.array([(o.true_m, o.stated_m, o.ideal_m) for o in outcomes]).T
    texts = [f'n {len(outcomes):4d}  true {np.sqrt(np.mean(true**2)):5.2f} m']
    for name, values in (('stated', stated), ('noise known', ideal)):
        ratios = values / true
        inside = np.mean((ratios > WITHIN[0]) & (ratios < WITHIN[1]))
        texts.append(
            f'{name} over true: of RMS {np.sqrt(np.mean(values**2) / np.mean(true**2)):.2f}, '
            f'median {np.median(ratios):.2f}, {100 * inside:.0f} % within 0.67 to 1.5, '
            f'{100 * np.mean(ratios < 0.4):.1f} % below 0.4'
        )
    return '; '.join(texts)


def main() -> None:
    """Print what came of the surveys of a part."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--part', choices=sorted(PARTS), default='develop')
    parser.add_argument('--count', type=int, default=500)
    options = parser.parse_args()
    first = PARTS[options.part]
    surveys = {seed: drawn(seed) for seed in range(first, first + options.count)}
    outcomes = {seed: tried(survey, seed) for seed, survey in surveys.items()}
    print(f'{"all":18}' + row(list(outcomes.values())))
    for drift in (0.0, 0.6, 0.9):
        chosen = [outcomes[seed] for seed, survey in surveys.items() if survey.drift == drift]
        print(f'drift {drift:<12}' + row(chosen))
    few = [outcomes[seed] for seed, s in surveys.items() if s.rows * s.columns < 10]
    print(f'{"fewer than 10":18}' + row(few))


if __name__ == '__main__':
    main()
