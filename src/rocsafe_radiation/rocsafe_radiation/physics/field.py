# SPDX-License-Identifier: Apache-2.0
"""The gamma dose-rate field of known sources."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike

from rocsafe_geo.arrays import FloatArray, IndexArray
from rocsafe_geo.position import ecef_m
from rocsafe_radiation.errors import UnknownPointError
from rocsafe_radiation.physics.photons import AIR
from rocsafe_radiation.physics.shielding import Coordinates, Shielding
from rocsafe_radiation.physics.source import RadiationSource
from rocsafe_radiation.physics.source_shape import TrackShape
from rocsafe_radiation.physics.transmission import air_transmission, shielded_transmission

SECONDS_PER_HOUR = 3600.0
PAPER_MODEL, AIR_MODEL, SHIELDED_MODEL = 'paper', 'air', 'shielded'
MODELS = (PAPER_MODEL, AIR_MODEL, SHIELDED_MODEL)
# With the largest sigma the dose rate at a source of this radius is 1e18 uSv/s: still finite.
SMALLEST_SOURCE_RADIUS_M = 1e-3
# Rays at a time, so that memory stays small.
LARGEST_BLOCK = 1_000_000
COORDINATE_LIMITS = (('latitude', 90.0), ('longitude', 180.0), ('altitude', math.inf))


@dataclass(frozen=True, slots=True, kw_only=True)
class RadiationField:
    """Dose rates around any number of sources, by one of three models.

    paper: each source gives sigma / d^2 microsievert per second at the straight-line distance d in
    metres, without attenuation or scatter (Smyth, Glavin and Madden 2018, section II.B). air:
    sigma / d^2 times what air transmits of the lines of its nuclide, with build-up. shielded: as
    air, with the materials of `shielding` along each ray. Scatter from the ground, which adds 10
    to 20 %, is in none of them. The sources add up.

    The formula is singular at d = 0: below `source_radius_m` the distance counts as
    `source_radius_m`, as at the surface of a source of that size.

    Attributes
    ----------
    sources
        The sources; none gives a field of zeros.
    source_radius_m
        Distance below which the dose rate grows no further.
    model
        One of `MODELS`.
    shielding
        What shields in the model ``shielded``; None: that model is ``air``.

    Examples
    --------
    Ten metres above a source of 1 uSv/s at one metre there is 1 / 10^2 uSv/s, or 36 uSv/h:

    >>> from rocsafe_geo.position import GeoPosition
    >>> source = RadiationSource(
    ...     name='lost', position=GeoPosition(53.28, -9.06, 0.0), sigma_usvps=1.0
    ... )
    >>> field = RadiationField(sources=(source,))
    >>> field.source_dose_rates_usvh([53.28], [-9.06], [10.0]).round(3)
    array([[36.]])
    """

    sources: tuple[RadiationSource, ...]
    source_radius_m: float = 0.1
    model: str = PAPER_MODEL
    shielding: Shielding | None = None
    _still: tuple['_Group', ...] = field(init=False, repr=False, compare=False)
    _moving: tuple[int, ...] = field(init=False, repr=False, compare=False)

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
        moves = [isinstance(source.shape, TrackShape) for source in self.sources]
        by_nuclide: dict[str, list[_Group]] = {}
        for index, source in enumerate(self.sources):
            if not moves[index]:
                group = _Group.of(index, self.sources, 0.0)
                by_nuclide.setdefault(source.nuclide, []).append(group)
        still = tuple(map(_Group.joined, by_nuclide.values()))
        object.__setattr__(self, '_moving', tuple(np.flatnonzero(moves).tolist()))
        object.__setattr__(self, '_still', still)

    @property
    def is_still(self) -> bool:
        """Whether no source moves."""
        return not self._moving

    def source_dose_rates_usvh(
        self,
        latitudes_deg: ArrayLike,
        longitudes_deg: ArrayLike,
        altitudes_m: ArrayLike,
        time_s: float = 0.0,
    ) -> FloatArray:
        """Return the dose rate of each source alone at n points, uSv/h, shape (sources, n).

        Latitudes and longitudes are WGS84, altitudes above the ellipsoid; each is an array of
        shape (n,) or a scalar. `time_s` counts from the start of the mission. Distances are good
        to about 2 nm, the rounding of geocentric coordinates; the rest keeps 1e-12 relative.

        Raises
        ------
        UnknownPointError
            If a point is not finite or out of range, naming it.
        """
        points = _arrays(latitudes_deg, longitudes_deg, altitudes_m)
        _check_points(points)
        positions = ecef_m(*points)
        rates_usvps: FloatArray = np.zeros((len(self.sources), len(positions)))
        moving = [_Group.of(index, self.sources, time_s) for index in self._moving]
        for group in (*self._still, *moving):
            self._add_rates(group, positions, points, rates_usvps)
        return rates_usvps * SECONDS_PER_HOUR

    def _add_rates(
        self,
        group: '_Group',
        positions: FloatArray,
        points: Coordinates,
        rates_usvps: FloatArray,
    ) -> None:
        """Add the dose rates of the parts of a group to those of their sources."""
        size = max(1, LARGEST_BLOCK // max(1, len(positions)))
        for start in range(0, len(group.centres), size):
            block = slice(start, start + size)
            offsets = positions - group.centres[block, None]
            distances_m = np.sqrt(np.einsum('pnc,pnc->pn', offsets, offsets))
            rates = dose_rate_usvps(
                group.sigmas_usvps[block, None], distances_m, self.source_radius_m
            )
            if self.model != PAPER_MODEL:
                rates *= self._transmission(
                    group.nuclide, group.places[block], distances_m, points
                )
            np.add.at(rates_usvps, group.owners[block], rates)

    def _transmission(
        self,
        nuclide: str,
        places: FloatArray,
        distances_m: FloatArray,
        points: Coordinates,
    ) -> FloatArray:
        """Return the transmission of each ray from a place of the source, shape (places, n)."""
        if self.model == AIR_MODEL or self.shielding is None:
            return air_transmission(nuclide, distances_m)
        starts = (places[:, 0], places[:, 1], places[:, 2])
        lengths = dict(self.shielding.lengths_m(starts, points))
        solid = sum(lengths.values(), np.zeros_like(distances_m))
        lengths[AIR] = np.maximum(distances_m - solid, 0.0)
        return shielded_transmission(nuclide, lengths)


@dataclass(frozen=True, slots=True)
class _Group:
    """Parts of sources of one nuclide.

    `owners` are the numbers of their sources and `sigmas_usvps` their strengths, shape (parts,);
    `places` and `centres` are geodetic and geocentric, shape (parts, 3).
    """

    nuclide: str
    owners: IndexArray
    sigmas_usvps: FloatArray
    places: FloatArray
    centres: FloatArray

    @classmethod
    def of(cls, index: int, sources: Sequence[RadiationSource], time_s: float) -> '_Group':
        """Return the parts of one source."""
        source = sources[index]
        places = source.places(time_s)
        count = len(places)
        return cls(
            source.nuclide,
            np.full(count, index, np.intp),
            np.full(count, source.sigma_usvps / count),
            places,
            ecef_m(*places.T),
        )

    @classmethod
    def joined(cls, groups: Sequence['_Group']) -> '_Group':
        """Return groups of one nuclide as one."""
        return cls(
            groups[0].nuclide,
            np.concatenate([group.owners for group in groups]),
            np.concatenate([group.sigmas_usvps for group in groups]),
            np.concatenate([group.places for group in groups]),
            np.concatenate([group.centres for group in groups]),
        )


def dose_rate_usvps(
    sigma_usvps: float | FloatArray,
    distances_m: FloatArray,
    source_radius_m: float,
) -> FloatArray:
    """Return sigma / d^2 in microsievert per second, with d at least `source_radius_m`."""
    clamped_m = np.maximum(distances_m, source_radius_m)
    return np.asarray(sigma_usvps / (clamped_m * clamped_m), dtype=np.float64)


def require_point(latitude_deg: float, longitude_deg: float, altitude_m: float) -> None:
    """Raise UnknownPointError if a place is not finite or out of range."""
    is_place = abs(latitude_deg) <= 90.0 and abs(longitude_deg) <= 180.0
    if not (is_place and math.isfinite(altitude_m)):
        _check_points(_arrays(latitude_deg, longitude_deg, altitude_m))


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
