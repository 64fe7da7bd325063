# SPDX-License-Identifier: Apache-2.0
"""What takes gas and particles out of the air: the ground, gravity, decay."""

import math
from dataclasses import dataclass

from rocsafe_geo.limits import require_not_negative, require_positive
from rocsafe_geo.wind.similarity import SurfaceLayer

GRAVITY_MPS2 = 9.80665
# Air at 20 degrees: dynamic viscosity (Pa s) and mean free path (m).
VISCOSITY_PA_S, FREE_PATH_M = 1.81e-5, 6.6e-8
# Height at which deposition looks at the concentration, metres.
REFERENCE_M = 1.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Losses:
    """Losses of a gas or of particles; by default none.

    Attributes
    ----------
    surface_resistance_s_m
        Resistance of the ground to a gas, s/m; infinite: it takes nothing.
    settling_mps
        Speed at which particles fall, m/s.
    decay_per_s
        Share that decays in a second, 1/s, also loss of viability.
    """

    surface_resistance_s_m: float = math.inf
    settling_mps: float = 0.0
    decay_per_s: float = 0.0

    def __post_init__(self) -> None:
        if not self.surface_resistance_s_m >= 0.0:
            raise ValueError(
                f'surface_resistance_s_m is {self.surface_resistance_s_m:g}: must be 0 or above'
            )
        require_not_negative('settling_mps', self.settling_mps, 'm/s')
        require_not_negative('decay_per_s', self.decay_per_s, '1/s')

    def deposition_mps(self, layer: SurfaceLayer) -> float:
        """Return the deposition velocity at 1.5 m above the ground, m/s.

        1 / (Ra + Rb + Rc) with Ra = u / u*^2 and Rb = 5 / u* (Seinfeld and Pandis, chapter 19),
        plus the settling speed.
        """
        if math.isinf(self.surface_resistance_s_m):
            return self.settling_mps
        friction = layer.friction_velocity_mps
        aerodynamic = float(layer.speed_mps(REFERENCE_M)) / friction**2
        total = aerodynamic + 5.0 / friction + self.surface_resistance_s_m
        return 1.0 / total + self.settling_mps


NO_LOSSES = Losses()


def settling_speed_mps(diameter_m: float, density_kg_m3: float = 1000.0) -> float:
    """Return the speed at which a sphere falls in air, m/s (Stokes with slip; up to 50 um).

    Raises
    ------
    ValueError
        If the diameter is above 50 um, where the law does not hold, or a value not above 0.
    """
    diameter = require_positive('diameter_m', diameter_m, 'm')
    density = require_positive('density_kg_m3', density_kg_m3, 'kg/m^3')
    if diameter > 50e-6:
        raise ValueError(f'diameter_m is {diameter:g}: must be at most 5e-05')
    knudsen = 2.0 * FREE_PATH_M / diameter
    # Slip correction of Allen and Raabe 1985.
    slip = 1.0 + knudsen * (1.142 + 0.558 * math.exp(-0.999 / knudsen))
    return density * diameter**2 * GRAVITY_MPS2 * slip / (18.0 * VISCOSITY_PA_S)
