# SPDX-License-Identifier: Apache-2.0
"""Options of the search for releases."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_between, require_count, require_positive


@dataclass(frozen=True, slots=True, kw_only=True)
class SearchArea:
    """Ground on which releases may be.

    Attributes
    ----------
    west_m, south_m, east_m, north_m
        Edges, metres.
    cell_m
        Distance of the places that are tried, metres.
    height_m
        Height of a release above the ground, metres.
    """

    west_m: float
    south_m: float
    east_m: float
    north_m: float
    cell_m: float = 4.0
    height_m: float = 0.5

    def __post_init__(self) -> None:
        require_positive('width of the area', self.east_m - self.west_m, 'm')
        require_positive('height of the area', self.north_m - self.south_m, 'm')
        require_positive('cell_m', self.cell_m, 'm')
        require_between('height_m', self.height_m, 0.0, 30.0, 'm')
        cells = (self.east_m - self.west_m) * (self.north_m - self.south_m) / self.cell_m**2
        require_between('number of cells of the area', cells, 4.0, 40_000.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class LocateOptions:
    """How releases are found.

    Attributes
    ----------
    spread_y, spread_z
        Factors of the crosswind and the vertical size of the plume that are tried first; where
        the readings ask for others, the row goes on by the same factor.
    spread_std
        Standard deviation of the logarithm of these factors before readings.
    turns_deg, turn_std_deg
        Errors of the wind direction that are tried, degrees, and their standard deviation.
    fluctuations
        How readings fluctuate about the mean, as pairs that are tried: the share of the crosswind
        variance that is meander during one reading, and the standard deviation of the
        concentration as a share of its mean within the meandering plume. Readings of seconds
        see the second pair, means over minutes the first.
    missed_probability
        Probability that a sensor within the plume reads nothing of it.
    information_share
        Largest share of the readings' information that counts beside a release: readings that
        follow each other see the same eddies. Whether there is any release
        is asked of more where the noise of the readings is independent. Chosen so that regions
        of simulated surveys hold what they state (docs/dispersion.md).
    shared_error
        Correlation of any two readings within a plume because the plume is not the Gaussian one
        of the model: however many there are, of its place and rate they tell together no more
        than 1 / `shared_error` independent ones. Chosen as `information_share`.
    most_releases
        Largest number of releases, at most 3.
    least_gain
        Logarithm of the odds that one release more needs, where one more and none more were
        equally probable before: 4.6 stands for 99 to 1.
    smallest_g_s
        Rate of the weakest release that matters, g/s: what is said of releases that were not
        found is said of this rate.
    """

    spread_y: tuple[float, ...] = (0.7, 1.4)
    spread_z: tuple[float, ...] = (0.7, 1.4)
    spread_std: float = 0.7
    turns_deg: tuple[float, ...] = (-8.0, 0.0, 8.0)
    turn_std_deg: float = 6.0
    fluctuations: tuple[tuple[float, float], ...] = ((0.0, 0.4), (0.6, 0.6))
    missed_probability: float = 0.1
    information_share: float = 0.3
    shared_error: float = 0.6
    most_releases: int = 3
    least_gain: float = 4.6
    smallest_g_s: float = 0.5

    def __post_init__(self) -> None:
        for name in ('spread_y', 'spread_z'):
            for value in getattr(self, name):
                require_between(name, value, 0.05, 20.0)
        for meander, scatter in self.fluctuations:
            require_between('meander of fluctuations', meander, 0.0, 0.95)
            require_between('scatter of fluctuations', scatter, 0.05, 5.0)
        require_positive('spread_std', self.spread_std)
        require_positive('turn_std_deg', self.turn_std_deg, 'degrees')
        require_between('missed_probability', self.missed_probability, 0.0, 0.9)
        require_between('information_share', self.information_share, 0.0, 1.0)
        require_between('shared_error', self.shared_error, 0.0, 1.0)
        require_between('smallest_g_s', self.smallest_g_s, 1e-9, 1e9, 'g/s')
        require_count('most_releases', self.most_releases, 0, 3)
