# SPDX-License-Identifier: Apache-2.0
"""Charge over time: a multirotor mostly pays for staying up, a little for moving through the air.

Recorded flights of ArduCopter drew 28.0 A at 5 m/s, 28.7 A at 10 m/s and 29.4 A in 8 m/s of wind:
power grows with the square of the airspeed, by about 5 % at its largest.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import accumulate, pairwise

import numpy as np

from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_geo.motion.state import Motion

# Gauss's four nodes and weights integrate a speed squared, of degree six in time, exactly.
_NODES, _WEIGHTS = (values.tolist() for values in np.polynomial.legendre.leggauss(4))


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerModel:
    """Electric power of a vehicle in flight.

    Attributes
    ----------
    hover_power_w : in still air, standing.
    drag_power_w_s2_per_m2 : more for each square of airspeed.
    voltage_v : of the battery, taken as steady.
    endurance_s : time in the air on a full battery at `top_airspeed_mps`; slower it lasts longer.
    top_airspeed_mps : the largest.
    """

    hover_power_w: float = 350.0
    drag_power_w_s2_per_m2: float = 0.2
    voltage_v: float = 12.6
    endurance_s: float
    top_airspeed_mps: float

    def __post_init__(self) -> None:
        for name in ('hover_power_w', 'voltage_v', 'endurance_s'):
            require_positive(name, getattr(self, name))
        for name in ('drag_power_w_s2_per_m2', 'top_airspeed_mps'):
            require_not_negative(name, getattr(self, name))

    @property
    def capacity_j(self) -> float:
        """Energy of a full battery."""
        return self.endurance_s * self.power_w(self.top_airspeed_mps**2)

    @property
    def capacity_ah(self) -> float:
        """Charge of a full battery."""
        return self.capacity_j / self.voltage_v / 3600.0

    def power_w(self, airspeed_square: float) -> float:
        """Return the power at an airspeed, given its square in m^2/s^2."""
        return self.hover_power_w + self.drag_power_w_s2_per_m2 * airspeed_square


class Discharge:
    """What a motion takes from a battery.

    Parameters
    ----------
    motion : from time 0 on; a stand without end ends it.
    power : of the vehicle.
    wind_mps : (east, north) that the air moves towards.
    """

    def __init__(self, motion: Motion, power: PowerModel, wind_mps: tuple[float, float]) -> None:
        self._motion, self._power, self._wind = motion, power, wind_mps
        self._knots = [knot for knot in motion.knots_s if math.isfinite(knot)]
        energies = [self._between_j(a, b) for a, b in pairwise(self._knots)]
        self._used_j = list(accumulate(energies, initial=0.0))

    def used_j(self, elapsed_s: float) -> float:
        """Return the energy used until a time."""
        piece = max(0, bisect_right(self._knots, elapsed_s) - 1)
        return self._used_j[piece] + self._between_j(self._knots[piece], elapsed_s)

    def power_w(self, elapsed_s: float) -> float:
        """Return the power at a time."""
        east, north, _ = self._motion.state(elapsed_s).velocity_enu
        square = (east - self._wind[0]) ** 2 + (north - self._wind[1]) ** 2
        return self._power.power_w(square)

    def _between_j(self, begin_s: float, end_s: float) -> float:
        half, middle = 0.5 * (end_s - begin_s), 0.5 * (end_s + begin_s)
        if half <= 0.0:
            return 0.0
        return half * sum(
            weight * self.power_w(middle + half * node)
            for node, weight in zip(_NODES, _WEIGHTS, strict=True)
        )
