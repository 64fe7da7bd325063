# SPDX-License-Identifier: Apache-2.0
"""Motion of a multirotor under autopilot: legs, corners, routes, stops, wind, charge.

All are pure functions of time. The planner states with them how long a route takes, and the
simulated vehicle flies them, so that both agree. The model is that of ArduCopter 4, and
`benchmarks/flight_model.py` compares it with recorded flights.
"""

from rocsafe_geo.motion.leg import leg_duration_s
from rocsafe_geo.motion.limits import MotionLimits

__all__ = ['MotionLimits', 'leg_duration_s']
