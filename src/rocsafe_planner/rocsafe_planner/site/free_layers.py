# SPDX-License-Identifier: Apache-2.0
"""Height layers that a request leaves to its vehicles."""

from rocsafe_planner.errors import NoFreeHeightError
from rocsafe_planner.plan.request import SurveyRequest

MAX_LAYERS = 8
"""Layers that are tried; the highest flies that many separations higher, less one."""
_TOLERANCE_M = 0.01


def lowest_layers_m(request: SurveyRequest) -> tuple[float, ...]:
    """Return how much higher than the camera's height each vehicle flies at least.

    Empty: not at all. Their batteries must do for this height.

    Raises
    ------
    NoFreeHeightError
        If vehicles that nobody hears leave no layer.
    """
    if request.separation.by != 'layers' or not request.continuation.unheard:
        return request.layers_m
    return (free_layers_m(request)[0],) * len(request.vehicles)


def free_layers_m(request: SurveyRequest) -> list[float]:
    """Return the layers that may be flown in, as heights above the lowest.

    Raises
    ------
    NoFreeHeightError
        If vehicles that nobody hears leave none.
    """
    step, base_m = request.separation.distance_m, request.coverage.height_agl_m
    unheard = request.continuation.unheard
    highest_m = request.airspace.max_height_agl_m
    free = [
        number * step
        for number in range(MAX_LAYERS)
        if base_m + number * step <= highest_m
        and all(
            abs(base_m + number * step - one.flight_height_m) >= step - _TOLERANCE_M
            for one in unheard
        )
    ]
    if not free:
        heights = ', '.join(f'{one.flight_height_m:g} m' for one in unheard)
        raise NoFreeHeightError(
            f'no flight height up to {highest_m:g} m keeps {step:g} m from vehicles that nobody '
            f'hears, at {heights}'
        )
    return free
