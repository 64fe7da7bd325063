# SPDX-License-Identifier: Apache-2.0
"""A vehicle of a trial: it flies legs from standstill to standstill at its own height."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rocsafe_fleet.ledger.records import Place, place_of
from rocsafe_geo.motion import leg_duration_s
from rocsafe_geo.position import GeoPosition, level_offset_m, offset
from rocsafe_planner.plan.vehicle import Vehicle

Plane = tuple[float, float]


@dataclass(slots=True, kw_only=True)
class _Leg:
    """A leg that is being flown, and the viewpoint at its end; None: home."""

    begin: Plane
    end: Plane
    from_s: float
    arrives_s: float
    until_s: float
    point: int | None


class TrialVehicle:
    """Flies whatever route it is given, then home.

    Parameters
    ----------
    spec
        The vehicle, which stands at its home.
    places
        Of all viewpoints, metres east and north of `origin`.
    height_m
        At which it flies.

    Attributes
    ----------
    landed_s
        When it landed last; None: it is in the air, or has not flown.
    is_aloft
        Whether it is in the air.
    """

    def __init__(
        self, spec: Vehicle, origin: GeoPosition, places: Mapping[int, Plane], height_m: float
    ) -> None:
        self.spec = spec
        self.landed_s: float | None = None
        self.is_aloft = False
        self.used_s = 0.0
        self.height_m = height_m
        self._limits = spec.performance().fastest()
        self._origin = origin
        self._places = places
        self._home = level_offset_m(origin, spec.home)
        self._at: Plane = self._home
        self._free_s = 0.0
        self._route: list[int] = []
        self._leg: _Leg | None = None
        self._now_s = 0.0
        performance = spec.performance()
        self._ascent = performance.ascent_motion(height_m)
        self._descent = performance.descent_motion(height_m)
        self._climbs_from_s = -math.inf

    def fly(self, route: tuple[int, ...], now_s: float) -> None:
        """Fly this route from where it is, in place of the one being flown.

        While it lands it takes none.
        """
        if self._lands_since_s(now_s) is not None:
            return
        following = [] if self._leg is None or self._leg.point is None else [self._leg.point]
        if list(route) == [*following, *self._route]:
            return
        self._route = list(route)
        if not self.is_aloft:
            if route:
                self.is_aloft, self.landed_s = True, None
                self._climbs_from_s = now_s
                self._at, self._free_s = self._home, now_s + self._ascent.duration_s
            return
        if self._leg is not None and self._leg.from_s <= now_s:
            self._at, self._free_s = self.plane(now_s), now_s
        self._leg = None

    def advance(self, now_s: float) -> list[int]:
        """Fly on; return the viewpoints that it has photographed."""
        visited = []
        if self.is_aloft:
            self.used_s += now_s - self._now_s
        self._now_s = now_s
        while self.is_aloft:
            if self._leg is None:
                self._begin_leg()
            leg = self._leg
            if leg is None or now_s < leg.until_s:
                break
            self._at, self._free_s, self._leg = leg.end, leg.until_s, None
            if leg.point is None:
                self.is_aloft, self.landed_s = False, leg.until_s
            else:
                visited.append(leg.point)
        return visited

    def _begin_leg(self) -> None:
        point = self._route.pop(0) if self._route else None
        end = self._home if point is None else self._places[point]
        distance = ((end[0] - self._at[0]) ** 2 + (end[1] - self._at[1]) ** 2) ** 0.5
        flown_s = leg_duration_s(distance, self._limits) if distance > 0.0 else 0.0
        stand_s = self.spec.hover_s
        if point is None:
            stand_s = self.spec.performance().descent_s(self.height_m)
        self._leg = _Leg(
            begin=self._at,
            end=end,
            from_s=self._free_s,
            arrives_s=self._free_s + flown_s,
            until_s=self._free_s + flown_s + stand_s,
            point=point,
        )

    def plane(self, now_s: float) -> Plane:
        """Return where it is, metres east and north; along a leg as if its speed were even."""
        leg = self._leg
        if leg is None or now_s <= leg.from_s:
            return self._at
        share = min(1.0, (now_s - leg.from_s) / max(leg.arrives_s - leg.from_s, 1e-9))
        return (
            leg.begin[0] + share * (leg.end[0] - leg.begin[0]),
            leg.begin[1] + share * (leg.end[1] - leg.begin[1]),
        )

    def _lands_since_s(self, now_s: float) -> float | None:
        """Return since when it comes down above its home; None: it does not."""
        leg = self._leg
        if not self.is_aloft or leg is None or leg.point is not None:
            return None
        lands_s = leg.arrives_s + self.spec.autopilot.home_wait_s
        return lands_s if now_s >= lands_s else None

    def up_m(self, now_s: float) -> float:
        """Return how high it is above the ground."""
        if not self.is_aloft:
            return 0.0
        since_s = self._lands_since_s(now_s)
        if since_s is not None:
            return float(self._descent.positions(np.array([now_s - since_s]))[0, 2])
        if now_s - self._climbs_from_s < self._ascent.duration_s:
            return float(self._ascent.positions(np.array([now_s - self._climbs_from_s]))[0, 2])
        return self.height_m

    def place(self, now_s: float) -> Place:
        """Return where it is, as it tells its agent."""
        east, north = self.plane(now_s)
        position = offset(self._origin, east, north, self.up_m(now_s))
        is_landing = self._lands_since_s(now_s) is not None
        return place_of(position, self.used_s, is_aloft=self.is_aloft, is_landing=is_landing)
