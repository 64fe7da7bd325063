# SPDX-License-Identifier: Apache-2.0
"""Spaces and observations that the environments of a search share."""

import numpy as np
from gymnasium import spaces
from numpy.typing import NDArray

from rocsafe_learning.source_belief import Place
from rocsafe_learning.source_search import SearchOptions, SourceSearch

Observation = dict[str, NDArray[np.float32]]
# Readings are scaled by this: 100 is a square root of 2500 counts, twice.
READING_SCALE = 100.0
LARGEST_READING = 1e6


def action_space() -> spaces.Box:
    """Return the space of the next place: east and north, -1 and 1 are the edges of the area."""
    return spaces.Box(-1.0, 1.0, (2,), np.float32)


def observation_space(options: SearchOptions) -> spaces.Dict:
    """Return the space of what one drone knows.

    ``pose`` own place, -1 to 1; ``readings_left`` 0 to 1; ``reading`` the last one, scaled;
    ``belief`` probability of each cell, rows from the south; ``peers`` the places of the others,
    where there are others.
    """
    parts: dict[str, spaces.Space[NDArray[np.float32]]] = {
        'pose': spaces.Box(-1.0, 1.0, (2,), np.float32),
        'readings_left': spaces.Box(0.0, 1.0, (1,), np.float32),
        'reading': spaces.Box(-LARGEST_READING, LARGEST_READING, (1,), np.float32),
        'belief': spaces.Box(0.0, 1.0, (32, 32), np.float32),
    }
    if options.vehicles > 1:
        parts['peers'] = spaces.Box(-1.0, 1.0, (options.vehicles - 1, 2), np.float32)
    return spaces.Dict(parts)


def observe(search: SourceSearch, index: int) -> Observation:
    """Return what drone `index` knows."""
    options = search.options
    scaled = [_scaled(place, options.area_m) for place in search.places_m]
    left = 1.0 - search.count / options.readings
    found: Observation = {
        'pose': np.array(scaled[index], np.float32),
        'readings_left': np.array([left], np.float32),
        'reading': np.array([_reading(search, index)], np.float32),
        # Sums of float32 may be a little above 1.
        'belief': np.minimum(search.belief.cells, np.float32(1.0)),
    }
    if options.vehicles > 1:
        found['peers'] = np.array(scaled[:index] + scaled[index + 1 :], np.float32)
    return found


def target_m(action: NDArray[np.float32], area_m: float) -> Place:
    """Return the place that an action names, east and north, metres.

    Raises
    ------
    ValueError
        If it is not two numbers, as of a policy that has diverged.
    """
    if action.shape != (2,):
        raise ValueError(f'action has shape {action.shape}: must be (2,)')
    east, north = action.tolist()
    if east != east or north != north:
        raise ValueError(f'action is {east}, {north}: must be two numbers')
    return (east + 1.0) / 2.0 * area_m, (north + 1.0) / 2.0 * area_m


def truth_of(search: SourceSearch) -> dict[str, object]:
    """Return what the drones do not know, for the ``info`` of a step."""
    return {
        'source_m': search.truth.place_m,
        'strength': search.truth.strength,
        'error_m': search.error_m(),
        'time_s': search.time_s,
        'readings': search.count,
    }


def _reading(search: SourceSearch, index: int) -> float:
    scaled = search.last_readings[index] / READING_SCALE
    return min(max(scaled, -LARGEST_READING), LARGEST_READING)


def _scaled(place_m: Place, area_m: float) -> Place:
    return 2.0 * place_m[0] / area_m - 1.0, 2.0 * place_m[1] / area_m - 1.0
