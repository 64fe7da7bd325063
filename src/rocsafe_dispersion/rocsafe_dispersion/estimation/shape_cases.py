# SPDX-License-Identifier: Apache-2.0
"""Shapes of the plume that are tried: a first set, and more where the readings ask for them."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import product

from rocsafe_dispersion.estimation.gas_survey import GasSurvey
from rocsafe_dispersion.estimation.plume_kernel import PlumeShape, unit_readings
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_dispersion.plume.spread import Travel
from rocsafe_geo.arrays import FloatArray

# Neighbours are tried of sizes whose logarithm of the posterior is so near to the largest one.
_HEAVY = 3.0

# Numbers of the sizes across the wind and upwards, counted from the first of the options.
_Sizes = tuple[int, int]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ShapeCase:
    """One shape of the plume and one scatter.

    Attributes
    ----------
    shape
        The shape.
    scatter
        Standard deviation of the concentration as a share of its mean.
    log_prior
        Logarithm of its prior, up to a constant.
    units : (offsets, n, m)
        What each reading would be for 1 g/s at each place.
    """

    shape: PlumeShape
    scatter: float
    log_prior: float
    units: FloatArray


class CaseMaker:
    """Makes the cases of a survey.

    Parameters
    ----------
    survey, places_m, height_m, travel, reference_mps
        As of `unit_readings`.
    options
        Sizes, turns and fluctuations of the first set; sizes go on by the same factor.
    """

    def __init__(
        self,
        survey: GasSurvey,
        places_m: FloatArray,
        height_m: float,
        travel: Travel,
        reference_mps: float,
        options: LocateOptions,
    ) -> None:
        self._for = (survey, places_m, height_m, travel, reference_mps)
        self._options = options

    def cases(self, log_weight: Callable[[ShapeCase], float]) -> list[ShapeCase]:
        """Return the cases: sizes beside probable ones are added until there are none.

        Parameters
        ----------
        log_weight
            Logarithm of the posterior of a case, up to a constant.
        """
        options = self._options
        new = list(product(range(len(options.spread_y)), range(len(options.spread_z))))
        made: dict[_Sizes, list[ShapeCase]] = {}
        largest: dict[_Sizes, float] = {}
        while new:
            for sizes in new:
                made[sizes] = list(self._of_sizes(sizes))
                largest[sizes] = max(log_weight(case) for case in made[sizes])
            limit = max(largest.values()) - _HEAVY
            heavy = [sizes for sizes in largest if largest[sizes] > limit]
            beside = {near for sizes in heavy for near in self._beside(sizes)}
            new = sorted(beside - largest.keys())
        return [case for cases in made.values() for case in cases]

    def _beside(self, sizes: _Sizes) -> list[_Sizes]:
        wide, high = sizes
        across = [(wide + step, high) for step in (-1, 1)]
        upwards = [(wide, high + step) for step in (-1, 1)]
        found = [
            *(across if len(self._options.spread_y) > 1 else []),
            *(upwards if len(self._options.spread_z) > 1 else []),
        ]
        return [each for each in found if self._log_prior(each) > -_HEAVY]

    def _factors(self, sizes: _Sizes) -> tuple[float, float]:
        options = self._options
        wide, high = (
            row[0] * (row[1] / row[0] if len(row) > 1 else 1.0) ** number
            for row, number in zip((options.spread_y, options.spread_z), sizes, strict=True)
        )
        return wide, high

    def _log_prior(self, sizes: _Sizes) -> float:
        square = sum(math.log(factor) ** 2 for factor in self._factors(sizes))
        return -0.5 * square / self._options.spread_std**2

    def _of_sizes(self, sizes: _Sizes) -> Iterator[ShapeCase]:
        options, (wide, high) = self._options, self._factors(sizes)
        for turn, (meander, scatter) in product(options.turns_deg, options.fluctuations):
            shape = PlumeShape(
                spread_y=wide, spread_z=high, turn_rad=math.radians(turn), meander=meander
            )
            prior = -0.5 * (turn / options.turn_std_deg) ** 2
            yield ShapeCase(
                shape=shape,
                scatter=scatter,
                log_prior=prior + self._log_prior(sizes),
                units=unit_readings(*self._for, shape),
            )
