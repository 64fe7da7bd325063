# SPDX-License-Identifier: Apache-2.0
"""Mirror images of sources: readings along a line do not tell on which side of it a source is.

A source and its mirror image about the line of the nearest readings explain these equally well.
Only other readings decide. So each source is also fitted on the other side of the line. If both
places remain likely, the covariance covers both.

Errors of the fixes across the line tell no side, but a fit takes them for readings beside it. The
share of their scatter that is the vehicle's own is the reliability ratio (Fuller 1987): by so much
of their distance the readings of the line are left beside it.
"""

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.counts_model import HEAD_SIZE
from rocsafe_radiation.localization.likelihood import Fit, Likelihood

# Readings belong to a line within so many standard deviations across it, or of the fixes.
LINE_STDS = 3.0


@dataclass(frozen=True, slots=True, kw_only=True)
class _Line:
    """A line of readings: a place on it, (2,), its normal, (2,), and the scatter across it."""

    middle_m: FloatArray
    normal: FloatArray
    variance_m2: float

    def across_m(self, places_m: FloatArray) -> FloatArray:
        """Return how far places (..., 2) lie beside it."""
        return np.asarray((places_m - self.middle_m) @ self.normal)


def mirror_images(likelihood: Likelihood, parameters: FloatArray) -> list[FloatArray]:
    """Return copies of `parameters`, each with one source mirrored about its line of readings."""
    return [image for _, image in _images(likelihood, parameters)]


def covariance_with_images(likelihood: Likelihood, fit: Fit, fix_error_m: float) -> FloatArray:
    """Return the covariance of the parameters of `fit`, likely mirror images included.

    Each image that explains the readings nearly as well adds the square of its distance, weighted
    by its probability: the second moment of both about the place stated. `fix_error_m` is the
    standard deviation of the fixes that is stated; that of the setting counts if it is larger.
    """
    covariance = fit.covariance
    for line, start in _images(likelihood, fit.parameters):
        straight = _straightened(likelihood, line, fix_error_m)
        image = straight.fit(start)
        deficit = straight.fit(fit.parameters).log_likelihood - image.log_likelihood
        if deficit > likelihood.setting.search.image_deficit:
            continue
        weight = 1.0 / (1.0 + math.exp(max(deficit, 0.0)))
        way = image.parameters - fit.parameters
        covariance = covariance + weight * np.outer(way, way)
    return covariance


def _straightened(likelihood: Likelihood, line: _Line, fix_error_m: float) -> Likelihood:
    """Return the likelihood with the readings of a line as far beside it as the vehicle was."""
    error_m = max(fix_error_m, likelihood.setting.position_std_m)
    own_share = max(0.0, 1.0 - error_m**2 / line.variance_m2) if line.variance_m2 > 0.0 else 1.0
    if own_share == 1.0:
        return likelihood
    places = likelihood.survey.positions_enu_m.copy()
    across = line.across_m(places[:, :2])
    is_on = np.abs(across) <= LINE_STDS * max(error_m, math.sqrt(line.variance_m2))
    places[is_on, :2] -= (1.0 - own_share) * np.outer(across[is_on], line.normal)
    survey = replace(likelihood.survey, positions_enu_m=places)
    return Likelihood(survey, likelihood.setting, likelihood.basis[:, HEAD_SIZE:])


def _images(likelihood: Likelihood, parameters: FloatArray) -> Iterator[tuple[_Line, FloatArray]]:
    """Yield the line of readings beside each source that has one, and its mirror image."""
    for index, source in enumerate(likelihood.sources(parameters)):
        line = _line(likelihood, source[:2])
        if line is None:
            continue
        image = parameters.copy()
        start = likelihood.head_size + likelihood.source_size * index
        image[start : start + 2] -= 2.0 * line.across_m(source[:2]) * line.normal
        yield line, image


def _line(likelihood: Likelihood, place: FloatArray) -> _Line | None:
    """Return the line of the readings nearest to `place`; None: they are on none, or it is."""
    places = likelihood.survey.positions_enu_m[:, :2]
    distances = np.hypot(*(places - place).T)
    options = likelihood.setting.search
    same_m = options.image_heights * likelihood.survey.height_m(likelihood.setting.source_up_m)
    nearest = float(distances.min())
    near = places[distances <= options.line_reach * max(nearest, same_m)]
    if len(near) < options.line_readings:
        return None
    middle = near.mean(axis=0)
    variances, axes = np.linalg.eigh(np.cov((near - middle).T))
    if variances[0] > options.line_width**2 * variances[1]:
        return None
    line = _Line(middle_m=middle, normal=axes[:, 0], variance_m2=max(float(variances[0]), 0.0))
    return None if abs(float(line.across_m(place))) < same_m else line
