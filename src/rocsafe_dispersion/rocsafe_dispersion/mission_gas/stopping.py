# SPDX-License-Identifier: Apache-2.0
"""When the readings of gas are enough."""

import math
from dataclasses import dataclass

from rocsafe_dispersion.estimation.found_release import FoundRelease
from rocsafe_dispersion.estimation.locate import LocatedReleases
from rocsafe_geo.limits import require_between, require_positive
from rocsafe_hazard.next_places import Verdict

_PLACELESS = (
    'doubted: the readings are explained better without the places where they were taken; '
    'check coordinates, clocks and detector'
)
# Probability beyond the ground from which a release is said to be there.
_BEYOND = 0.5
_SIDES = ('N', 'NE', 'E', 'SE', 'S', 'SW', 'W', 'NW')


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleaseRule:
    """When a search may end.

    Attributes
    ----------
    region_m
        Radius of a circle as large as the region of 0.95 that is precise enough, metres.
    hidden_share
        Share of the ground where a release of the smallest rate may still be.
    wrong_wind
        Largest probability that the direction of the wind is wrong altogether.
    moves
        Largest probability that a release moves: one that does is never placed for good.
    """

    region_m: float = 10.0
    hidden_share: float = 0.05
    wrong_wind: float = 0.05
    moves: float = 0.05

    def __post_init__(self) -> None:
        require_positive('region_m', self.region_m, 'm')
        require_between('hidden_share', self.hidden_share, 1e-3, 0.9)
        require_between('wrong_wind', self.wrong_wind, 1e-3, 0.9)
        require_between('moves', self.moves, 1e-3, 0.9)

    def verdict(self, found: LocatedReleases) -> Verdict:
        """Return whether what was found is placed well enough, and no more is hidden."""
        share = found.hidden.share
        smallest = f'{found.hidden.smallest_g_s:g} {found.amount.rate_unit}'
        where = f'of {smallest} may be in {100.0 * share:.0f} % of the ground'
        is_searched = share <= self.hidden_share
        if not found.releases:
            text = f'a release {where}'
            reason = f'no release found: {text}' if is_searched else text
            return Verdict(is_enough=is_searched, reason=reason)
        count = len(found.releases)
        what = f'{count} release{"s" if count > 1 else ""}'
        what = f'{what}, placed within {widest_m(found):.0f} m (95 %)'
        if found.gain_of_places <= 0.0:
            return Verdict(is_enough=False, reason=f'{what}; {_PLACELESS}')
        if found.wrong_wind > self.wrong_wind:
            return Verdict(is_enough=False, reason=f'{what}; {_doubted_wind(found)}')
        for release in found.releases:
            if release.moves > self.moves:
                return Verdict(is_enough=False, reason=f'{what}; {_moves(release)}')
            if release.beyond > _BEYOND:
                return Verdict(is_enough=False, reason=f'{what}; {_is_beyond(release, found)}')
        if not self.is_placed(found):
            wanted = f'{self.region_m:g} m are wanted'
            return Verdict(is_enough=False, reason=f'{what}: {wanted}')
        if not is_searched:
            return Verdict(is_enough=False, reason=f'{what}; another {where}')
        return Verdict(is_enough=True, reason=what)

    def is_placed(self, found: LocatedReleases) -> bool:
        """Return whether there are releases, all of them placed well enough."""
        return bool(found.releases) and widest_m(found) <= self.region_m


def widest_m(found: LocatedReleases) -> float:
    """Return the radius of a circle as large as the largest region of 0.95, metres."""
    return max(release.region_radius_m for release in found.releases)


def _doubted_wind(found: LocatedReleases) -> str:
    turned = math.degrees(found.turn_rad)
    side = 'anticlockwise' if turned > 0.0 else 'clockwise'
    return (
        f'the direction of the wind is wrong with a probability of {found.wrong_wind:.2f}: the '
        f'readings fit wind turned {side} by {abs(turned):.0f} degrees'
    )


def _moves(release: FoundRelease) -> str:
    if release.velocity_mps is None:
        return f'it moves with a probability of {release.moves:.2f}: measure again'
    east, north = release.velocity_mps
    side = _SIDES[round(math.degrees(math.atan2(east, north)) / 45.0) % 8]
    speed = math.hypot(east, north)
    return f'it moves with {speed:.1g} m/s to the {side}: that place is of the last reading'


def _is_beyond(release: FoundRelease, found: LocatedReleases) -> str:
    side = _SIDES[round(release.beyond_deg / 45.0) % 8]
    which = f'that of {release.rate_g_s:.2g} {found.amount.rate_unit}'
    return (
        f'{which} is outside of the ground searched with a probability of {release.beyond:.2f}, '
        f'to the {side}: measure there'
    )
