# SPDX-License-Identifier: Apache-2.0
"""The analytic derivatives of a tie are those that finite differences give."""

import numpy as np
import pytest

from rocsafe_geo.pinhole import rotation_enu_from_optical
from rocsafe_mapping.alignment.adjustment.projection import Views, tie_derivatives, tie_residuals
from rocsafe_mapping.alignment.adjustment.rotation import turned

STEP = 1e-6
# Central differences of pixels of a few hundred: eight digits.
TOLERANCE = 1e-3


def views(rng, *, move=None, turn=None, log_focal=0.0, radial=(0.0, 0.0), seed_offsets):
    """Return one end of five ties."""
    rotation = rotation_enu_from_optical(*rng.normal(0.0, 0.1, 3))
    centre = np.array([*rng.normal(0.0, 5.0, 2), 32.0])
    if move is not None:
        centre = centre + move
    if turn is not None:
        rotation = turned(turn) @ rotation
    return Views(
        offsets_px=seed_offsets,
        focal_px=np.full(len(seed_offsets), 350.0 * np.exp(log_focal)),
        radial=np.tile(radial, (len(seed_offsets), 1)),
        centres=np.tile(centre, (len(seed_offsets), 1)),
        rotations=np.tile(rotation, (len(seed_offsets), 1, 1)),
    )


def residuals(change, index, which):
    """Return the residuals and derivatives with one parameter of one camera changed."""
    offsets = np.random.default_rng(7).uniform(-150.0, 150.0, (2, 5, 2))
    parts = []
    for side in (0, 1):
        step = np.zeros(9)
        if side == which:
            step[index] = change
        parts.append(
            views(
                np.random.default_rng(side),
                move=step[:3],
                turn=step[3:6],
                log_focal=step[6],
                radial=(0.02 + step[7], -0.01 + step[8]),
                seed_offsets=offsets[side],
            )
        )
    return tie_derivatives(*parts, np.full(5, 1.3))


@pytest.mark.parametrize('which', [0, 1])
@pytest.mark.parametrize('index', range(9))
def test_derivative_to_each_parameter(which, index):
    """A change of pose, focal length or distortion moves the residual as the Jacobian says."""
    plus, minus = residuals(STEP, index, which), residuals(-STEP, index, which)
    measured = (plus.residuals.residuals_px - minus.residuals.residuals_px) / (2.0 * STEP)
    at = residuals(0.0, index, which)
    pose, lens = (at.first_pose, at.first_lens) if which == 0 else (at.second_pose, at.second_lens)
    analytic = np.concatenate([pose, lens], axis=2)[:, :, index]
    assert analytic == pytest.approx(measured, abs=TOLERANCE, rel=1e-5)


def test_derivative_to_the_height():
    """Higher ground moves the residual as the derivative says."""
    offsets = np.random.default_rng(7).uniform(-150.0, 150.0, (2, 5, 2))
    first = views(np.random.default_rng(0), seed_offsets=offsets[0])
    second = views(np.random.default_rng(1), seed_offsets=offsets[1])
    up = tie_residuals(first, second, np.full(5, 1.0 + STEP)).residuals_px
    down = tie_residuals(first, second, np.full(5, 1.0 - STEP)).residuals_px
    at = tie_residuals(first, second, np.full(5, 1.0))
    assert at.height == pytest.approx((up - down) / (2.0 * STEP), abs=TOLERANCE)
