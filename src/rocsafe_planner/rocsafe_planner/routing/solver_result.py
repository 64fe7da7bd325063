# SPDX-License-Identifier: Apache-2.0
"""What a search has found, without the compiled code of the search."""

import math
from dataclasses import dataclass

from rocsafe_planner.problem.fleet_problem import Order


@dataclass(frozen=True, slots=True, kw_only=True)
class Optimised:
    """Routes, and a value that no routes undercut, with the argument that proves it; or NaN."""

    orders: list[Order]
    bound: float = math.nan
    bound_name: str = ''
