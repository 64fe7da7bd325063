# SPDX-License-Identifier: Apache-2.0
"""Mean and intensity of the gas of a release at many readings, for many hypotheses at once.

The mean is the Gaussian plume. The intensity is that of a plume that meanders as a whole
(Gifford 1959, Adv. Geophys. 6, 117): with the share m of its variance in the motion of its middle
and the relative intensity r within the moving plume, the mean square over the squared mean at u
and v standard deviations beside and above the axis is

    1 + i^2 = (1 + r^2) / (1 - m^2) exp((u^2 + v^2) m / (1 + m))
"""

from dataclasses import dataclass

import numpy as np
from scipy import special

from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.plume.spread import NEAREST_M, Travel, at_rows
from rocsafe_geo.arrays import FloatArray, IndexArray

# Slower wind does not carry a plume anywhere: readings in it count as in this wind, m/s.
LEAST_SPEED_MPS = 0.3
# How far gas has come from a release that moves is sought with the speed of a plume after so many
# metres; a release that follows its own gas counts as no faster than this share of it.
_USUAL_M, _FOLLOWS = 20.0, 0.8
# Farther beside a plume, in its crosswind standard deviations, there is nothing of it.
_REACH = 5.0
LARGEST_SQUARE, _LARGEST_GROWTH = 100.0, 20.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Shapes:
    """How plumes differ from the one that the air suggests, each (particles,).

    Attributes
    ----------
    turn_rad
        Angle by which the true wind is turned anticlockwise from the measured one, radians.
    spread_y, spread_z
        Factors of the crosswind and vertical size.
    meander
        Share of the variance that is motion of the whole plume, 0 to below 1.
    relative
        Intensity within the moving plume.
    """

    turn_rad: FloatArray
    spread_y: FloatArray
    spread_z: FloatArray
    meander: FloatArray
    relative: FloatArray

    @property
    def mean_turn_rad(self) -> float:
        """Circular mean of the turns of the wind, radians anticlockwise."""
        return float(np.angle(np.exp(1j * self.turn_rad).mean()))

    def at(self, index: IndexArray) -> 'Shapes':
        """Return those of an index."""
        return Shapes(**{name: getattr(self, name)[index] for name in self.__dataclass_fields__})


class PlumeReadings:
    """Readings of a survey, ready for any release in an air."""

    def __init__(
        self, survey: GasSurvey, height_m: float, travel: Travel, reference_mps: float
    ) -> None:
        count = len(survey.weights)
        points = survey.places_m.reshape(-1, 3)
        self.points, self._above = len(points), points[:, 2].astype(np.float32)
        winds = np.repeat(survey.wind_towards_mps, count, axis=0)
        speeds = np.maximum(np.hypot(winds[:, 0], winds[:, 1]), 1e-9)
        east, north = (winds / speeds[:, None]).T
        self._middle_m = points[:, :2].mean(axis=0)
        x, y = (points[:, :2] - self._middle_m).T
        self._times_s = np.repeat(survey.times_s, count)
        self._span_s = max(float(np.ptp(survey.times_s)), 1e-9)
        left = (self._times_s.max() - self._times_s) / self._span_s
        # Distances along and across a turned wind are sums of these; the last two are of releases
        # that move.
        self._bases = np.stack([
            east * x + north * y, east * y - north * x, east, north, left * east, left * north,
        ]).astype(np.float32)  # fmt: skip
        slow = np.maximum(np.repeat(survey.speeds_mps, count), LEAST_SPEED_MPS)
        self._factor = (reference_mps / slow).astype(np.float32)
        self._weights, self._height_m, self._travel = survey.weights, height_m, travel
        usual_s = float(np.interp(_USUAL_M, travel.distances_m, travel.times_s))
        self._usual_mps = _USUAL_M / usual_s / self._factor

    def of(
        self,
        places_m: FloatArray,
        shapes: Shapes,
        spans_s: FloatArray | None = None,
        ways_m: FloatArray | None = None,
    ) -> tuple[FloatArray, FloatArray]:
        """Return mean and standard deviation for 1 g/s at places (p, 2), each (p, n), s/m^3.

        Releases move along `ways_m` (p, 2), even from the first reading to the last one, when they
        are at `places_m`; None: they stand.

        Releases start and end at `spans_s` (2, p), in the time of the readings; None: long before
        and after. Their front and their end come with the plume, and are as long as it is wide.
        """
        row, column, along, across, follows_mps = self._reached(places_m, shapes, ways_m)
        rows = self._travel.rows(along)
        sigma_y = at_rows(self._travel.sigma_y_m, rows) * shapes.spread_y[row]
        sigma_z = at_rows(self._travel.sigma_z_m, rows) * shapes.spread_z[row]
        flow = at_rows(self._travel.airborne / self._travel.speeds_mps, rows)
        above = self._above[column]
        middle = at_rows(self._travel.heights_m(), rows)
        u, v = across / sigma_y, (above - middle) / sigma_z
        reflected = np.exp(-2.0 * above * middle / sigma_z**2)
        shape = np.exp(-0.5 * (u**2 + v**2)) * (1.0 + reflected) / (2.0 * np.pi)
        mean = self._factor[column] * flow * shape / (sigma_y * sigma_z)
        if follows_mps is not None:
            # What follows its own gas releases more of it into a metre of the way.
            speeds = at_rows(self._travel.speeds_mps, rows) / self._factor[column]
            mean = mean / (1.0 - np.minimum(follows_mps / speeds, _FOLLOWS))
        if spans_s is not None:
            # How far the gas of the start and of the end has come beyond the reading, in widths.
            slower = self._factor[column]
            left_s = self._times_s[column] - slower * at_rows(self._travel.times_s, rows)
            widths_s = sigma_y * slower / at_rows(self._travel.speeds_mps, rows)
            begun, ended = special.ndtr((left_s - spans_s[:, row]) / widths_s)
            mean = mean * np.maximum(begun - ended, 0.0)
        meander, relative = shapes.meander[row], shapes.relative[row]
        growth = np.minimum((u**2 + v**2) * meander / (1.0 + meander), _LARGEST_GROWTH)
        square = np.exp(growth) / (1.0 - meander**2)
        intensity = np.sqrt(np.minimum((1.0 + relative**2) * square - 1.0, LARGEST_SQUARE))
        size = (len(places_m), self.points)
        return self._over_points(row, column, mean, size), self._over_points(
            row, column, mean * intensity, size
        )

    def _reached(
        self, places_m: FloatArray, shapes: Shapes, ways_m: FloatArray | None
    ) -> tuple[IndexArray, IndexArray, FloatArray, FloatArray, FloatArray | None]:
        """Return particles and points that a plume may reach, with distances along and across.

        And with the speed of the release along the wind there; None: it stands.
        """
        cosine, sine = np.cos(shapes.turn_rad), np.sin(shapes.turn_rad)
        x, y = (places_m - self._middle_m).T
        to, beside = x * cosine + y * sine, x * sine - y * cosine
        none = np.zeros(len(x))
        ahead, aside = none, none
        if ways_m is not None:
            ahead = ways_m[:, 0] * cosine + ways_m[:, 1] * sine
            aside = ways_m[:, 0] * sine - ways_m[:, 1] * cosine
        along, across = (
            np.stack(parts, axis=1).astype(np.float32) @ self._bases
            for parts in (
                (cosine, sine, -to, beside, ahead, -aside),
                (-sine, cosine, beside, to, -aside, -ahead),
            )
        )
        if ways_m is not None:
            # What is read now was released before, where the release was then.
            speeds = [
                np.stack(parts, axis=1) @ self._bases[2:4] / self._span_s
                for parts in ((ahead, -aside), (-aside, -ahead))
            ]
            shares = np.minimum(speeds[0] / self._usual_mps, _FOLLOWS)
            rows = self._travel.rows(along / (1.0 - shares))
            after_s = self._factor * at_rows(self._travel.times_s, rows)
            along, across = along + speeds[0] * after_s, across + speeds[1] * after_s
        # sigma_y grows at most as fast as the distance.
        slope = float(self._travel.sigma_y_m[0] / self._travel.distances_m[0])
        wide = (_REACH * slope * shapes.spread_y.astype(np.float32))[:, None]
        row, column = np.nonzero((along > NEAREST_M) & (np.abs(across) < wide * along))
        follows_mps = None if ways_m is None else np.asarray(speeds[0][row, column])
        along_m, across_m = (np.asarray(one[row, column]) for one in (along, across))
        return row, column, along_m, across_m, follows_mps

    def _over_points(
        self, row: IndexArray, column: IndexArray, values: FloatArray, size: tuple[int, int]
    ) -> FloatArray:
        """Return the weighted sum over the points of each reading, (particles, readings)."""
        full = np.zeros(size)
        full[row, column] = values
        return np.asarray(full.reshape(size[0], -1, len(self._weights)) @ self._weights)
