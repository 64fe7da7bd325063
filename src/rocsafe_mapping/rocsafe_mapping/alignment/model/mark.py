# SPDX-License-Identifier: Apache-2.0
"""Marks: points of the ground whose places were surveyed, and the photographs that show them."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

from rocsafe_geo.arrays import FloatArray

MARK_STD_M = 0.03
"""What a survey with a corrected receiver is worth; the residuals may show that it is worse."""


@dataclass(frozen=True, slots=True, kw_only=True)
class Mark:
    """A surveyed point.

    Attributes
    ----------
    name
        Its label.
    surveyed_m
        Its (east, north) as surveyed, shape (2,).
    found_m
        Where the adjustment has it, shape (2,).
    sightings
        Pixels (2,) by photograph.
    """

    name: str
    surveyed_m: FloatArray
    found_m: FloatArray
    sightings: Mapping[str, FloatArray]

    def moved(self, step_m: FloatArray) -> 'Mark':
        """Return the mark found a step (2,) farther."""
        return replace(self, found_m=self.found_m + step_m)
