# SPDX-License-Identifier: Apache-2.0
"""Tuning of the search: how its cycles are divided, cooled and crossed.

The values are our own, found by trials; none of them comes from a publication.
"""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class CycleTuning:
    """Numbers of the schedule of cycles; pairs that are drawn from have equal chances.

    A problem is *large* if it has many customers in all and for each vehicle: it is then nearly
    that of one traveller, whose route many cheap moves find.

    Attributes
    ----------
    chunk
        Proposals between two looks at the clock.
    least_cycle, middle_cycle
        Least and most proposals a customer of a cycle from hot to cold.
    large_least_cycle, large_most_cycle
        The same for large problems.
    cycles, large_cycles
        Number of cycles of a search that is long enough: small problems gain by crosses, large
        ones by slow cooling.
    large_customers, large_route
        Customers in all, and for each vehicle, from which on a problem is large.
    short_cycle, longer_cycle
        Most proposals a customer of a cycle of a small problem, and the increase for each
        customer: few customers settle soon, and crosses then find more than longer cycles.
    single_cycles
        A search shorter than this number of least cycles is one cycle.
    founders
        Cycles from a construction before plans are crossed.
    members
        Plans that are kept for crossing.
    tours
        Probability that two plans are crossed as tours instead of route by route.
    ruins, large_ruins
        Ruin-and-recreate proposals of 4096 where there is a table of legs, for small and large
        problems; one takes the time of about thirty others.
    sparse_ruins, sparse_single_ruins
        The same without a table of legs, and there for a search of one cycle.
    hasty_ruins, hasty_share
        The same for searches of fewer proposals a customer than `hasty_share`.
    hot_share
        Proposals a customer in all from which on a first cycle begins hot.
    long_share
        Proposals a customer in all from which on cycles are drawn from the values `long_floors`
        and `long_sharper`.
    floors, long_floors
        Worth of a unit of cost in a short route, against 1 in the longest. The smaller it is, the
        nearer comes the longest route to its least, and the longer the others stay hot.
    sharper, long_sharper
        Power of two by which that width shrinks until the end of a cycle.
    widths
        Share of the target cost over which that worth rises to 1, at the start of a cycle.
    first_hot, later_hot, crossed_hots
        Temperature at the start of a first cycle of a long search, of a first cycle of another
        search, and of a cycle after a cross: powers of two of the mean distance between near
        neighbours.
    cold
        Temperature at the end of a cycle, as such a power.
    longs
        Of 16 segments that are moved, how many may be long.
    rate, sparse_rate
        Proposals a second that are assumed before any were made: with a table of legs, without.
    """

    chunk: int = 16384
    least_cycle: int = 5_000
    middle_cycle: int = 20_000
    large_least_cycle: int = 30_000
    large_most_cycle: int = 120_000
    cycles: int = 12
    large_cycles: int = 4
    large_customers: int = 500
    large_route: int = 100
    short_cycle: int = 2_500
    longer_cycle: int = 25
    single_cycles: int = 4
    founders: int = 4
    members: int = 10
    tours: float = 0.5
    ruins: tuple[int, ...] = (600, 1500)
    large_ruins: tuple[int, ...] = (40, 120)
    sparse_ruins: int = 40
    sparse_single_ruins: int = 10
    hasty_ruins: int = 200
    hasty_share: int = 5000
    hot_share: int = 2000
    long_share: int = 100_000
    floors: tuple[float, ...] = (0.1, 0.2)
    long_floors: tuple[float, ...] = (0.01, 0.03, 0.1)
    sharper: tuple[float, ...] = (3.0,)
    long_sharper: tuple[float, ...] = (3.0, 4.0)
    widths: tuple[float, ...] = (0.01, 0.02)
    first_hot: float = 0.0
    later_hot: float = -2.0
    crossed_hots: tuple[float, ...] = (-1.0, -2.0, -3.0)
    cold: float = -5.5
    longs: tuple[int, ...] = (0, 3)
    rate: float = 6e6
    sparse_rate: float = 2.5e6


USUAL = CycleTuning()
"""The tuning of every search."""
