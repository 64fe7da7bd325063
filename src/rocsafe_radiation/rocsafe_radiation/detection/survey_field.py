# SPDX-License-Identifier: Apache-2.0
"""Dose rates that a detector measures: sources, each by its nuclide, and background."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import ecef_m
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_radiation.detection.counting import Sample
from rocsafe_radiation.detection.detector import DETECTORS, IDEAL, DetectorModel, response_of
from rocsafe_radiation.physics.background import Background
from rocsafe_radiation.physics.field import PAPER_MODEL, RadiationField
from rocsafe_radiation.physics.scatter import counts_for_dose


@dataclass(frozen=True, slots=True, kw_only=True)
class SurveyField:
    """The dose rate of sources and background, and how a kind of detector responds to it.

    Attributes
    ----------
    field
        Field of the sources.
    background
        Natural background, to which every detector responds as to Cs-137.
    detector
        Name of a kind, or ``ideal``, which reads the dose rate itself.
    """

    field: RadiationField
    background: Background
    detector: str = IDEAL

    def __post_init__(self) -> None:
        response_of(self.detector)

    @property
    def kind(self) -> DetectorModel | None:
        """The kind of detector, None for the ideal one."""
        return DETECTORS.get(self.detector)

    def dose_rates_usvh(
        self,
        latitudes_deg: ArrayLike,
        longitudes_deg: ArrayLike,
        altitudes_m: ArrayLike,
        time_s: float = 0.0,
    ) -> FloatArray:
        """Return the dose rate at n points, microsievert per hour, shape (n,).

        Raises
        ------
        UnknownPointError
            If a point is not finite or out of range, naming it.
        """
        by_source = self.field.source_dose_rates_usvh(
            latitudes_deg, longitudes_deg, altitudes_m, time_s
        )
        return by_source.sum(axis=0) + self._natural(latitudes_deg, longitudes_deg, altitudes_m)

    def counted_dose_rates_usvh(
        self,
        latitudes_deg: ArrayLike,
        longitudes_deg: ArrayLike,
        altitudes_m: ArrayLike,
        time_s: float = 0.0,
    ) -> FloatArray:
        """Return the dose rate of Cs-137 that would give as many counts, shape (n,).

        Raises
        ------
        UnknownPointError
            If a point is not finite or out of range, naming it.
        """
        by_source = self.field.source_dose_rates_usvh(
            latitudes_deg, longitudes_deg, altitudes_m, time_s
        )
        places = (latitudes_deg, longitudes_deg, altitudes_m)
        counted = (self._counts_for_dose(places, time_s) * by_source).sum(axis=0)
        return np.asarray(counted + self._natural(*places))

    def _counts_for_dose(
        self, places: tuple[ArrayLike, ArrayLike, ArrayLike], time_s: float
    ) -> FloatArray:
        """Return the counts for the dose of each source, (sources, n) or (sources, 1).

        Photons scatter as about a source on the ground in the middle of the parts of it. In the
        model ``paper`` nothing scatters.
        """
        kind, sources = self.kind, self.field.sources
        if kind is None:
            return np.ones((len(sources), 1))
        if self.field.model == PAPER_MODEL:
            return np.array([[kind.relative_response(one.nuclide)] for one in sources])
        latitudes, longitudes, altitudes = np.broadcast_arrays(*map(np.atleast_1d, places))
        points = ecef_m(latitudes, longitudes, altitudes)
        factors: FloatArray = np.empty((len(sources), len(points)))
        for row, source in zip(factors, sources, strict=True):
            middle = source.places(time_s).mean(axis=0)
            ways = points - ecef_m(*middle[:, None])
            row[:] = counts_for_dose(
                source.nuclide,
                kind.response,
                altitudes - middle[2],
                np.linalg.norm(ways, axis=1),
            )
        return factors

    def flown_dose_rates_usvh(self, start_ns: int, samples: Sequence[Sample]) -> FloatArray:
        """Return such dose rates of Cs-137 at each sample of a flight, shape (n,).

        Parameters
        ----------
        start_ns
            Start of the mission, nanoseconds since 1970.
        samples
            Moments of a flight whose places are known.
        """
        if self.field.is_still:
            places = np.array([sample.place for sample in samples])
            return self.counted_dose_rates_usvh(*places.T)
        return np.concatenate(
            [
                self.counted_dose_rates_usvh(*one.place, (one.time_ns - start_ns) / NS_PER_S)
                for one in samples
            ]
        )

    def _natural(
        self, latitudes: ArrayLike, longitudes: ArrayLike, altitudes: ArrayLike
    ) -> FloatArray:
        """Return the background, or zero where there is none."""
        if self.background == Background():
            return np.zeros(1)
        places = (np.asarray(part, np.float64) for part in (latitudes, longitudes, altitudes))
        return self.background.dose_rates_usvh(*places)
