# SPDX-License-Identifier: Apache-2.0
"""Numbers on the command line, within their limits: an error names value and limits."""

from rocsafe_geo.argument import number, whole_number
from rocsafe_planner.plan.survey_options import MAX_VIEWPOINTS_LIMIT
from rocsafe_scenario.limits import (
    LARGEST_BUDGET_S,
    LARGEST_FLEET,
    LARGEST_HEIGHT_M,
    LARGEST_SEED,
    LARGEST_SPEED,
)

speed = number(0.0, LARGEST_SPEED, ' simulated seconds a second')
height = number(1.0, LARGEST_HEIGHT_M, ' m')
budget = number(0.0, LARGEST_BUDGET_S, ' s')
metres = number(0.0, 10_000.0, ' m')
seconds = number(0.0, 86_400.0, ' s')
overlap = number(0.0, 0.95)
part = number(0.0, 1.0)
vehicle_speed = number(0.1, 100.0, ' m/s')
wind = number(-100.0, 100.0, ' m/s')
seed = whole_number(0, LARGEST_SEED)
count = whole_number(1, LARGEST_FLEET)
viewpoint_count = whole_number(1, MAX_VIEWPOINTS_LIMIT)
waiting_time = number(0.0, 300.0, ' s')
