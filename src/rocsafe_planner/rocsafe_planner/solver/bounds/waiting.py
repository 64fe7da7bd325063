# SPDX-License-Identifier: Apache-2.0
"""What vehicles of a kind collect together while they wait for each other.

Of k vehicles each j wait j (j - 1) / 2 intervals together at least, at the begin and at the end of
their routes. With T - (k - 1) intervals for the one, and T for the other, longest: whatever times
they fly, longer ones exist that average the times T, T - 1 interval, ... T - (k - 1) intervals
(weak majorization: Marshall, Olkin & Arnold 2011, Inequalities, 5.A.9). So they collect at most k
times what the concave envelope between the first and the last of these times has in their middle.
"""

import numpy as np

from rocsafe_planner.solver.bounds.walks import find_corners
from rocsafe_planner.solver.model.tables import Floats, Ints


class Crew:
    """Vehicles of a kind.

    Parameters
    ----------
    whole : (steps + 1,)
        The most that one of them collects by each moment, ascending.
    count
        How many there are.
    apart
        Steps of an interval; 0: they do not wait.
    """

    def __init__(self, whole: Floats, count: int, apart: float) -> None:
        self._whole, self._count, self._apart = whole, count, apart

    def collected(self, moment: int) -> float:
        """Return the most that they collect by a moment, on any number of routes."""
        if self._apart == 0.0:
            return self._count * float(self._whole[moment])
        return max(self._by(moment, routes) for routes in range(1, self._count + 1))

    def moments(self, moment: int) -> list[int]:
        """Return the ends of the routes on which they all collect the most by a moment."""
        if self._apart == 0.0:
            return [moment]
        times, _ = self._envelope(moment, self._count)
        middle = int(np.searchsorted(times, moment - self._wait(self._count)))
        return [int(time) for time in times[max(middle - 1, 0) : middle + 1] if time >= 0]

    def _by(self, moment: int, routes: int) -> float:
        times, values = self._envelope(moment, routes)
        return routes * float(np.interp(moment - self._wait(routes), times, values))

    def _wait(self, routes: int) -> float:
        """Return the mean wait of some routes, in steps."""
        return 0.5 * self._apart * (routes - 1)

    def _envelope(self, moment: int, routes: int) -> tuple[Ints, Floats]:
        """Return the corners of the envelope from the shortest to the longest route.

        Each by its time, and what is collected by then.
        """
        first = int(np.floor(moment - 2.0 * self._wait(routes)))
        values = np.zeros(moment + 1 - first)
        values[max(-first, 0) :] = self._whole[max(first, 0) : moment + 1]
        corners = np.empty(len(values), np.int32)
        chosen = corners[: find_corners(values, corners)]
        return chosen + first, values[chosen]
