# SPDX-License-Identifier: Apache-2.0
"""When the readings of gas are enough."""

from dataclasses import dataclass

from rocsafe_dispersion.estimation.locate import LocatedReleases
from rocsafe_geo.limits import require_between, require_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleaseVerdict:
    """Whether a search may end, and the reason in words."""

    is_enough: bool
    reason: str


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleaseRule:
    """When a search may end.

    Attributes
    ----------
    region_m
        Radius of a circle as large as the region of 0.95 that is precise enough, metres.
    hidden_share
        Share of the ground where a release of the smallest rate may still be.
    """

    region_m: float = 10.0
    hidden_share: float = 0.05

    def __post_init__(self) -> None:
        require_positive('region_m', self.region_m, 'm')
        require_between('hidden_share', self.hidden_share, 1e-3, 0.9)

    def verdict(self, found: LocatedReleases, smallest_g_s: float) -> ReleaseVerdict:
        """Return whether what was found is placed well enough, or nothing is hidden."""
        if not found.releases:
            share = 1.0 if found.hidden is None else found.hidden.share
            text = (
                f'a release of {smallest_g_s:g} g/s may be in {100.0 * share:.0f} % of the ground'
            )
            if share > self.hidden_share:
                return ReleaseVerdict(is_enough=False, reason=text)
            return ReleaseVerdict(is_enough=True, reason=f'no release found: {text}')
        count = len(found.releases)
        what = f'{count} release{"s" if count > 1 else ""}'
        widest = max(release.region_radius_m for release in found.releases)
        within = f'placed within {widest:.0f} m (95 %)'
        if widest > self.region_m:
            wanted = f'{self.region_m:g} m are wanted'
            return ReleaseVerdict(is_enough=False, reason=f'{what}, {within}: {wanted}')
        return ReleaseVerdict(is_enough=True, reason=f'{what}, {within}')
