# SPDX-License-Identifier: Apache-2.0
"""What a vehicle collects at prices of customers, and on which walks."""

import numpy as np

from rocsafe_planner.solver.bounds.stepped_flights import Kind
from rocsafe_planner.solver.bounds.walks import (
    NO_FLIGHT,
    best_ends,
    chain_flights,
    collect,
    count_visits,
)
from rocsafe_planner.solver.model.tables import Floats, Ints


class Table:
    """The dynamic program of the walks of one flight: written again in each round."""

    def __init__(self, customers: int, moments: int) -> None:
        self.best, self.second = np.empty((2, moments, customers))
        self.before, self.before_second = np.empty((2, moments, customers), np.int32)


class Collected:
    """What a vehicle collects at prices.

    Parameters
    ----------
    kind
        Of the vehicle.
    price
        Of each customer.
    tables
        One for each flight of the kind, written.
    steps
        Until when.

    Attributes
    ----------
    whole : (steps + 1,)
        The most by each moment.
    """

    def __init__(self, kind: Kind, price: Floats, tables: list[Table], steps: int) -> None:
        self._kind, self._tables = kind, tables
        moments = steps + 1
        self._by: list[Floats] = []
        for flight, table in zip(kind.flights, tables, strict=False):
            most = np.zeros(moments)
            in_time = min(flight.longest + 1, moments)
            collect(
                kind.legs, flight.first, flight.last, price,
                table.best, table.before, table.second, table.before_second, most[:in_time],
            )  # fmt: skip
            most[in_time:] = most[in_time - 1]
            self._by.append(most)
        self.whole = self._by[0]
        if kind.chain is not None:
            first, middle, last = (self._by[number] for number in kind.chain)
            self._before, self._flown = np.empty(moments), np.empty(moments, np.int32)
            before = self._before
            chain_flights(first, before, middle, kind.change, before, self._flown)
            self.whole, flown = np.empty(moments), np.empty(moments, np.int32)
            chain_flights(self._by[0], before, last, kind.change, self.whole, flown)

    def visits(self, steps: int, most: int) -> Ints:
        """Return how often the best walks done by `steps` visit each customer, (k, n)."""
        flight = self._kind.flights[0]
        end = min(steps, flight.longest)
        ends, times = best_ends(self._tables[0].best, flight.last, end, most)
        alone = self._visits_of(0, ends, times)
        if self._kind.chain is None or steps <= self._kind.change:
            return alone
        chain = self._kind.chain
        repeated = self._visits_of_repeated(chain[1], steps, most)
        return np.vstack([alone, repeated, self._visits_of_chains(chain, steps, most)])

    def _visits_of(self, number: int, ends: Ints, times: Ints) -> Ints:
        table, legs = self._tables[number], self._kind.legs
        visits: Ints = np.empty((len(ends), len(legs)), np.int32)
        count_visits(legs, table.before, table.before_second, ends, times, visits)
        return visits

    def _visits_of_repeated(self, number: int, steps: int, most: int) -> Ints:
        """Return the visits of the best flights, each flown as often as there is time for."""
        flight, change = self._kind.flights[number], self._kind.change
        end = min(steps, flight.longest)
        flown = np.arange(end + 1)[:, None] + flight.last[None, :]
        often = (steps + change) // np.maximum(flown + change, 1)
        prizes = self._tables[number].best[: end + 1] * often
        ends, times = best_ends(prizes, flight.last, end, most)
        visits: Ints = self._visits_of(number, ends, times) * often[times, ends][:, None]
        return visits

    def _visits_of_chains(self, chain: tuple[int, int, int], steps: int, most: int) -> Ints:
        """Return the visits of the best last flights, each after the best flights before it."""
        number, left = chain[2], steps - self._kind.change
        flight = self._kind.flights[number]
        end = min(left, flight.longest)
        # What is collected before the last flight counts for where and when that ends.
        moments = np.arange(end + 1)
        rest = left - moments[:, None] - flight.last[None, :]
        before = np.where(rest >= 0, self._before[np.maximum(rest, 0)], 0.0)
        ends, times = best_ends(
            self._tables[number].best[: end + 1] + before, flight.last, end, most
        )
        visits = self._visits_of(number, ends, times)
        for row, (place, time) in enumerate(zip(ends.tolist(), times.tolist(), strict=True)):
            visits[row] += self._visits_before(chain, left - time - int(flight.last[place]))
        return visits

    def _visits_before(self, chain: tuple[int, int, int], steps: int) -> Ints:
        """Return the visits of the best flights that end with a change at home by some time."""
        visits: Ints = np.zeros(len(self._kind.legs), np.int32)
        while True:
            flown = int(self._flown[steps])
            number = chain[0] if flown == NO_FLIGHT else chain[1]
            flight = self._kind.flights[number]
            end = min(steps if flown == NO_FLIGHT else flown, flight.longest)
            ends, times = best_ends(self._tables[number].best, flight.last, end, 1)
            visits += self._visits_of(number, ends, times).sum(axis=0, dtype=np.int32)
            if flown == NO_FLIGHT:
                return visits
            steps -= flown + self._kind.change
