# SPDX-License-Identifier: Apache-2.0
"""Read-only data of the kernels: legs, ends of routes, limits, neighbours."""

from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rocsafe_planner.solver.model.compiled import inlined

Floats = NDArray[np.float64]
Costs = NDArray[np.float32]
if TYPE_CHECKING:
    # Typed as int: kernels calculate with the elements.
    Ints = NDArray[Any]
    Words = NDArray[Any]
else:
    Ints = NDArray[np.int32]
    Words = NDArray[np.uint64]


class Tables(NamedTuple):
    """A routing problem as flat arrays.

    Sites are numbered: customers 0 .. n-1, then the ends of routes, last `nowhere`, which stands
    for the missing end of an open route. A measure is a cost of legs (one per vehicle class).
    """

    matrix: Costs
    """(measures, sites, sites) cost of legs; one element when legs are computed from `points`."""
    points: Floats
    """(sites, 3) coordinates; one row when legs are read from `matrix`."""
    pace: Floats
    """(measures, 4): cost a metre, of the ramp, metres below which the ramp rules, its factor."""
    stay: Floats
    """(measures, sites): half of the cost of staying at a site; each leg carries both halves."""
    first: Ints
    """(m,) site where each route starts."""
    last: Ints
    """(m,) site where each route ends."""
    measure: Ints
    """(m,) measure that the objective uses for each route."""
    limit_measure: Ints
    """(m,) measure that counts against each route's limit."""
    fixed: Floats
    """(m,) cost of a route that serves anybody, besides its legs."""
    idle: Floats
    """(m,) cost of a route that serves nobody."""
    limit: Floats
    """(m,) most that a route's legs may consume of its limit measure; infinite when free."""
    ability: Words
    """(m,) one bit that a vehicle has: vehicles that may serve the same customers share it."""
    needs: Words
    """(n,) bits of the vehicles that may serve a customer."""
    near: Ints
    """(n, k) nearest customers of each customer."""
    dense: bool
    symmetric: bool
    limited: bool
    restricted: bool


@inlined
def leg(tables: Tables, measure: int, origin: int, target: int) -> float:
    """Return the cost of flying from one site to another under a measure."""
    if tables.dense:
        return tables.matrix[measure, origin, target]
    stays = tables.stay[measure, origin] + tables.stay[measure, target]
    nowhere = tables.points.shape[0] - 1
    if origin == nowhere or target == nowhere:
        return stays
    dx = tables.points[origin, 0] - tables.points[target, 0]
    dy = tables.points[origin, 1] - tables.points[target, 1]
    dz = tables.points[origin, 2] - tables.points[target, 2]
    distance = np.sqrt(dx * dx + dy * dy + dz * dz)
    if distance >= tables.pace[measure, 2]:
        return stays + distance * tables.pace[measure, 0] + tables.pace[measure, 1]
    return stays + tables.pace[measure, 3] * np.sqrt(distance)


def flown_costs(tables: Tables, origins: Ints, targets: Ints) -> Floats:
    """Return the costs of legs under the first measure, without stays, computed with numpy."""
    if tables.dense:
        stays = tables.stay[0, origins] + tables.stay[0, targets]
        return np.asarray(tables.matrix[0, origins, targets] - stays, np.float64)
    distance = np.linalg.norm(tables.points[origins] - tables.points[targets], axis=-1)
    slowness, ramp, short, factor = tables.pace[0]
    flown = np.where(distance >= short, distance * slowness + ramp, factor * np.sqrt(distance))
    return np.asarray(flown, np.float64)
