# SPDX-License-Identifier: Apache-2.0
"""Battery charge over time.

Most of the power of a multirotor keeps it in the air; a little more grows with the square of its
airspeed.
"""

import math
from bisect import bisect_right
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_geo.motion.state import Motion

# Four nodes of Gauss's quadrature integrate a speed squared, a polynomial of degree six, exactly.
_NODES, _WEIGHTS = (values.tolist() for values in np.polynomial.legendre.leggauss(4))

# Power of the motors of a quadrotor of about 2 kg in hover: momentum theory, (m g)^1.5 over
# sqrt(2 rho A), gives 123 W for four rotors of 10 inches, of which motors and rotors make 220 W
# at an efficiency of 0.56. In 1500 s that is 92 Wh, the usual battery of such a vehicle.
HOVER_POWER_W = 220.0
# Additional power per square of airspeed, W s^2/m^2, and battery voltage, taken as constant:
# measured on recorded flights of ArduCopter 4.7, which drew 28.0 A at 5 m/s, 28.7 A at 10 m/s and
# 29.4 A in 8 m/s of wind.
DRAG_POWER_W_S2_PER_M2 = 0.2
VOLTAGE_V = 12.6


@dataclass(frozen=True, slots=True, kw_only=True)
class PowerModel:
    """Electric power of a vehicle in flight.

    Attributes
    ----------
    hover_power_w
        Power in hover in still air, W.
    endurance_s
        Time in the air on a full battery at `top_airspeed_mps`, seconds; slower it lasts longer.
    top_airspeed_mps
        Largest airspeed, m/s.
    """

    hover_power_w: float = HOVER_POWER_W
    endurance_s: float
    top_airspeed_mps: float

    def __post_init__(self) -> None:
        require_positive('hover_power_w', self.hover_power_w)
        require_positive('endurance_s', self.endurance_s)
        require_not_negative('top_airspeed_mps', self.top_airspeed_mps)

    @property
    def capacity_j(self) -> float:
        """Energy of a full battery, J."""
        return self.endurance_s * self.power_w(self.top_airspeed_mps**2)

    @property
    def capacity_ah(self) -> float:
        """Charge of a full battery, Ah."""
        return self.capacity_j / VOLTAGE_V / 3600.0

    def power_w(self, airspeed_square: float) -> float:
        """Return the power at an airspeed, given its square in m^2/s^2."""
        return self.hover_power_w + DRAG_POWER_W_S2_PER_M2 * airspeed_square


class Discharge:
    """Energy that a motion takes from a battery.

    Parameters
    ----------
    motion
        Motion from time 0 on.
    power
        Power of the vehicle.
    wind_mps
        Velocity (east, north) of the air, m/s.
    """

    def __init__(self, motion: Motion, power: PowerModel, wind_mps: tuple[float, float]) -> None:
        self._motion, self._power, self._wind = motion, power, wind_mps
        self._knots = [knot for knot in motion.knots_s if math.isfinite(knot)]
        # Energy at the knots that somebody has asked for: the first ones do not wait for all.
        self._used_j = [0.0]

    def used_j(self, elapsed_s: float) -> float:
        """Return the energy used until a time."""
        piece = max(0, bisect_right(self._knots, elapsed_s) - 1)
        for begin_s, end_s in pairwise(self._knots[len(self._used_j) - 1 : piece + 1]):
            self._used_j.append(self._used_j[-1] + self._between_j(begin_s, end_s))
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
