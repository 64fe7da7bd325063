# SPDX-License-Identifier: Apache-2.0
"""Mirror images of sources: readings along a line do not tell on which side of it a source is.

A source and its mirror image about the line of the nearest readings explain these equally well.
Only other readings decide. So each source is also fitted on the other side of the line. If both
places remain likely, the covariance covers both.
"""

import math

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.localization.likelihood import Fit, Likelihood


def mirror_images(likelihood: Likelihood, parameters: FloatArray) -> list[FloatArray]:
    """Return copies of `parameters`, each with one source mirrored about its line of readings."""
    images = []
    for index, source in enumerate(likelihood.sources(parameters)):
        place = _image(likelihood, source[:2])
        if place is not None:
            image = parameters.copy()
            start = likelihood.head_size + likelihood.source_size * index
            image[start : start + 2] = place
            images.append(image)
    return images


def covariance_with_images(likelihood: Likelihood, fit: Fit) -> FloatArray:
    """Return the covariance of the parameters of `fit`, likely mirror images included.

    Each image that explains the readings nearly as well adds the square of its distance, weighted
    by its probability: the second moment of both about the place stated.
    """
    covariance = fit.covariance
    for start in mirror_images(likelihood, fit.parameters):
        image = likelihood.fit(start)
        deficit = fit.log_likelihood - image.log_likelihood
        if deficit > likelihood.setting.search.image_deficit:
            continue
        weight = 1.0 / (1.0 + math.exp(max(deficit, 0.0)))
        way = image.parameters - fit.parameters
        covariance = covariance + weight * np.outer(way, way)
    return covariance


def _image(likelihood: Likelihood, place: FloatArray) -> FloatArray | None:
    """Return the mirror image of `place`, None if the nearest readings are not on a line."""
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
    across = float((place - middle) @ axes[:, 0])
    if abs(across) < same_m:
        return None
    return np.asarray(place - 2.0 * across * axes[:, 0])
