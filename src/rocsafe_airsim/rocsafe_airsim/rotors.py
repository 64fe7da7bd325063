# SPDX-License-Identifier: Apache-2.0
"""Rotors of a simulated vehicle, from the force that carries it.

The simulation has no rotors. These are those of the vehicle of which its power in hover is told
(`rocsafe_geo.motion.battery`): about 2 kg on four rotors of 10 inches, all alike, with AirSim's
coefficients of thrust and power (of UIUC's propeller data).
"""

import math
from typing import Any

MASS_KG = 2.0
DIAMETER_M = 0.254
AIR_DENSITY_KG_M3 = 1.225
THRUST_COEFFICIENT, POWER_COEFFICIENT = 0.109919, 0.040164
# Front right and rear left turn anticlockwise, the others clockwise, as AirSim numbers them.
TURNS = (-1.0, -1.0, 1.0, 1.0)


def rotor_states(time_ns: int, force_mps2: float) -> dict[str, Any]:
    """Return a RotorStates: thrust, N, torque, N m, and speed, rad/s, of each rotor.

    Parameters
    ----------
    time_ns
        Mission time.
    force_mps2
        Force of the rotors per mass of the vehicle, upwards in its body; 0: they stand.
    """
    thrust_n = MASS_KG * max(force_mps2, 0.0) / len(TURNS)
    # thrust = c n^2 d^4 rho with n turns a second, torque = power / (2 pi n).
    turns_hz = math.sqrt(thrust_n / (THRUST_COEFFICIENT * AIR_DENSITY_KG_M3 * DIAMETER_M**4))
    power_w = POWER_COEFFICIENT * AIR_DENSITY_KG_M3 * turns_hz**3 * DIAMETER_M**5
    speed_radps = 2.0 * math.pi * turns_hz
    torque_nm = power_w / speed_radps if speed_radps else 0.0
    rotors = [
        {'thrust': thrust_n, 'torque_scaler': turn * torque_nm, 'speed': speed_radps}
        for turn in TURNS
    ]
    return {'timestamp': time_ns, 'rotors': rotors}
