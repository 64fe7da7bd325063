# SPDX-License-Identifier: Apache-2.0
"""How a multirotor with a common autopilot moves: legs, corners, routes, stops, wind, charge.

Pure functions of time, shared by the planner, which states how long a route takes, and by the
simulated vehicle, which flies it: the two agree because they are the same. The model is that of
ArduCopter 4, checked against its recorded flights in `benchmarks/flight_model.py`.
"""

from rocsafe_geo.motion.leg import leg_duration_s
from rocsafe_geo.motion.leg_table import leg_progress_m, leg_speed_mps
from rocsafe_geo.motion.limits import MotionLimits

__all__ = ['MotionLimits', 'leg_duration_s', 'leg_progress_m', 'leg_speed_mps']
