# SPDX-License-Identifier: Apache-2.0
"""A route of a ground vehicle as the simulation drives it; metres about the mission origin."""

import math
from dataclasses import dataclass

from rocsafe_geo.limits import require_not_negative, require_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class RouteStop:
    """A place on the way.

    Attributes
    ----------
    east_m, north_m
        The place.
    limit_mps
        Speed on the line that leads to it; not used at the first stop.
    dwell_s
        How long the vehicle stands there; 0: it drives on.
    evidence
        Id of the evidence that is photographed there; empty: none.
    look_rad
        Where it looks while it stands, from east to north.
    predicted_s, predicted_usv
        Time and dose of that line and of the stand, as planned.
    """

    east_m: float
    north_m: float
    limit_mps: float = 0.0
    dwell_s: float = 0.0
    evidence: str = ''
    look_rad: float = 0.0
    predicted_s: float = 0.0
    predicted_usv: float = 0.0

    def __post_init__(self) -> None:
        for name in ('east_m', 'north_m', 'look_rad'):
            if not math.isfinite(getattr(self, name)):
                raise ValueError(f'{name} is {getattr(self, name)}: must be finite')
        for name in ('limit_mps', 'dwell_s', 'predicted_s', 'predicted_usv'):
            require_not_negative(name, getattr(self, name))

    @property
    def place(self) -> tuple[float, float]:
        """East and north."""
        return self.east_m, self.north_m

    @property
    def is_stand(self) -> bool:
        """Whether the vehicle stands there."""
        return self.dwell_s > 0.0 or bool(self.evidence)


@dataclass(frozen=True, slots=True, kw_only=True)
class DrivenRoute:
    """A route: its stops in driving order, and the limits of dose.

    Attributes
    ----------
    route_id
        Name of the route.
    stops
        At least two; the first is where it begins.
    budget_usv
        Dose that the vehicle must not exceed on it, by its own readings.
    turn_back_usvh
        Dose rate at which it turns back.
    upper_ratio
        Upper 95 % of the predicted dose over its mean; 0: nobody told.
    turn_back_ppm
        Concentration of gas at which it turns back; 0: none.
    """

    route_id: str
    stops: tuple[RouteStop, ...]
    budget_usv: float
    turn_back_usvh: float
    upper_ratio: float = 0.0
    turn_back_ppm: float = 0.0

    def __post_init__(self) -> None:
        if len(self.stops) < 2:
            raise ValueError(f'the route has {len(self.stops)} stops: must have 2 or more')
        for number, stop in enumerate(self.stops[1:], start=1):
            require_positive(f'speed limit to stop {number}', stop.limit_mps, 'm/s')
        require_positive('dose_budget_usv', self.budget_usv, 'uSv')
        require_positive('turn_back_usvh', self.turn_back_usvh, 'uSv/h')
        require_not_negative('upper_ratio', self.upper_ratio)
        require_not_negative('turn_back_ppm', self.turn_back_ppm, 'ppm')
