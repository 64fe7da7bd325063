# SPDX-License-Identifier: Apache-2.0
"""The gamma dose-rate field of known sources."""

import math
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike, NDArray

from rocsafe_geo.position import ecef_m
from rocsafe_radiation.errors import UnknownPointError
from rocsafe_radiation.photons import AIR
from rocsafe_radiation.shielding import Coordinates, Shielding
from rocsafe_radiation.source import RadiationSource
from rocsafe_radiation.transmission import air_transmission, shielded_transmission

SECONDS_PER_HOUR = 3600.0
PAPER_MODEL, AIR_MODEL, SHIELDED_MODEL = 'paper', 'air', 'shielded'
MODELS = (PAPER_MODEL, AIR_MODEL, SHIELDED_MODEL)
# With the largest sigma the dose rate at a source of this radius is 1e18 uSv/s: still finite.
SMALLEST_SOURCE_RADIUS_M = 1e-3
COORDINATE_LIMITS = (('latitude', 90.0), ('longitude', 180.0), ('altitude', math.inf))


@dataclass(frozen=True, slots=True, kw_only=True)
class RadiationField:
    """Dose rates around any number of sources, by one of three models.

    paper: each source gives sigma / d^2 microsievert per second at the straight-line distance d
    in metres, without attenuation or scatter (Smyth, Glavin and
    Madden 2018, section II.B). air: times what air leaves of the lines of its nuclide, build-up
    included. shielded: as air, with the materials of `shielding` in between. Scatter from the
    ground, which adds 10 to 20 %, is in none of them. The sources add up.

    The formula is singular at d = 0: below `source_radius_m` the distance counts as
    `source_radius_m`, as at the surface of a source of that size.

    Attributes
    ----------
    sources: the sources; none gives a field of zeros.
    source_radius_m: distance below which the dose rate grows no further.
    model: one of `MODELS`.
    shielding: of the model ``shielded``; without it that model is ``air``.
    """

    sources: tuple[RadiationSource, ...]
    source_radius_m: float = 0.1
    model: str = PAPER_MODEL
    shielding: Shielding | None = None
    _centres: NDArray[np.float64] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        if not SMALLEST_SOURCE_RADIUS_M <= self.source_radius_m < math.inf:
            raise ValueError(
                f'source_radius_m = {self.source_radius_m} must be at least '
                f'{SMALLEST_SOURCE_RADIUS_M:g} and finite'
            )
        if self.model not in MODELS:
            raise ValueError(f'model = {self.model!r} must be one of: {", ".join(MODELS)}')
        names = [source.name for source in self.sources]
        if len(set(names)) < len(names):
            raise ValueError(f'source names must differ: {", ".join(names)}')
        object.__setattr__(self, '_centres', _centres(self.sources))

    def dose_rates_usvh(
        self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike, altitudes_m: ArrayLike
    ) -> NDArray[np.float64]:
        """Return the dose rate at each of n points in microsievert per hour, shape (n,).

        Latitudes and longitudes are WGS84, altitudes above the ellipsoid; each is an array of
        shape (n,) or a scalar. Distances are good to about 2 nm, the rounding of geocentric
        coordinates; the rest keeps 1e-12 relative.

        Raises
        ------
        UnknownPointError: if a point is not finite or out of range, naming it.
        """
        return self.source_dose_rates_usvh(latitudes_deg, longitudes_deg, altitudes_m).sum(axis=0)

    def source_dose_rates_usvh(
        self, latitudes_deg: ArrayLike, longitudes_deg: ArrayLike, altitudes_m: ArrayLike
    ) -> NDArray[np.float64]:
        """Return the same of each source alone, shape (sources, n)."""
        points = _arrays(latitudes_deg, longitudes_deg, altitudes_m)
        _check_points(points)
        positions = ecef_m(*points)
        rates_usvps = np.empty((len(self.sources), len(positions)))
        for index, (source, centre) in enumerate(zip(self.sources, self._centres, strict=True)):
            distances_m = np.linalg.norm(positions - centre, axis=1)
            rates_usvps[index] = dose_rate_usvps(
                source.sigma_usvps, distances_m, self.source_radius_m
            )
            if self.model != PAPER_MODEL:
                rates_usvps[index] *= self._transmission(source, distances_m, points)
        return rates_usvps * SECONDS_PER_HOUR

    def _transmission(
        self, source: RadiationSource, distances_m: NDArray[np.float64], points: Coordinates
    ) -> NDArray[np.float64]:
        if self.model == AIR_MODEL or self.shielding is None:
            return air_transmission(source.nuclide, distances_m)
        lengths = dict(self.shielding.lengths_m(source.position, points))
        solid = sum(lengths.values(), np.zeros_like(distances_m))
        lengths[AIR] = np.maximum(distances_m - solid, 0.0)
        return shielded_transmission(source.nuclide, lengths)


def dose_rate_usvps(
    sigma_usvps: float, distances_m: NDArray[np.float64], source_radius_m: float
) -> NDArray[np.float64]:
    """Return sigma / d^2 in microsievert per second, with d at least `source_radius_m`."""
    clamped_m = np.maximum(distances_m, source_radius_m)
    return np.asarray(sigma_usvps / (clamped_m * clamped_m), dtype=np.float64)


def _arrays(*parts: ArrayLike) -> Coordinates:
    first, second, third = np.broadcast_arrays(
        *(np.atleast_1d(np.asarray(part, np.float64)) for part in parts)
    )
    return first, second, third


def _check_points(points: Coordinates) -> None:
    for (name, limit), values in zip(COORDINATE_LIMITS, points, strict=True):
        wrong = np.flatnonzero(~(np.isfinite(values) & (np.abs(values) <= limit)))
        if wrong.size:
            bound = f'within {-limit:g} and {limit:g}' if math.isfinite(limit) else 'finite'
            raise UnknownPointError(
                f'point {wrong[0]}: {name} = {values[wrong[0]]} must be {bound}'
            )


def _centres(sources: tuple[RadiationSource, ...]) -> NDArray[np.float64]:
    """Return the geocentric positions of `sources` in metres, shape (sources, 3)."""
    places = [source.position for source in sources]
    return ecef_m(
        np.array([place.latitude_deg for place in places]),
        np.array([place.longitude_deg for place in places]),
        np.array([place.altitude_m for place in places]),
    )
