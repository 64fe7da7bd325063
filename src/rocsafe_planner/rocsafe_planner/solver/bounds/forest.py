# SPDX-License-Identifier: Apache-2.0
"""The forest bound: k routes contain a forest of k trees and 2k legs to and from the ends.

Prices on the customers (Lagrange multipliers of "two legs each", after Held and Karp, Operations
Research 18, 1970) leave every plan's cost as it is but raise that of the cheapest forest. Any
prices give a valid bound; the ascent looks for good ones.
"""

from dataclasses import dataclass, field

import numpy as np

from rocsafe_planner.solver.bounds.relaxation import Relaxation
from rocsafe_planner.solver.bounds.trees import grow_tree, join_edges
from rocsafe_planner.solver.model.neighbours import near_points, near_rows
from rocsafe_planner.solver.model.tables import Floats, Ints

SPARSE_FROM = 700
"""From here on the ascent works on a sparse graph, and only its result is checked densely."""
NEAR = 8
ROUNDING = 1e-9
"""Relative; by so much a sum may be wrong."""


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Forest:
    """The cheapest forests under some prices."""

    level: float
    """Least over k of what k routes cost the costliest of them (all of them, for the sum)."""
    degree: Ints
    """(size,) legs at each member in the forest that gave the level."""


@dataclass(slots=True, kw_only=True, eq=False)
class Ascent:
    """Price ascent for the customers `members`, served by the vehicles of a relaxation."""

    relaxed: Relaxation
    members: Ints
    total: bool
    """Whether the sum of the routes is bounded, not the costliest."""
    price: Floats = field(default_factory=lambda: np.zeros(0))
    best: float = 0.0
    best_price: Floats = field(default_factory=lambda: np.zeros(0))
    _stride: float = 1.0
    _stale: int = 0
    _momentum: Floats = field(default_factory=lambda: np.zeros(0))
    _edges: Ints = field(default_factory=lambda: np.zeros((0, 2), np.int32))
    _lengths: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        """Start from the prices given, or none."""
        n = len(self.relaxed.start)
        if not len(self.price):
            self.price = np.zeros(n)
        self.best_price = self.price.copy()
        self._momentum = np.zeros(len(self.members))
        if len(self.members) >= SPARSE_FROM:
            self._make_sparse()

    def _make_sparse(self) -> None:
        """Keep only edges to near neighbours, and those of the unpriced tree, which connect."""
        ends, _ = self._dense_tree(np.zeros(len(self.relaxed.start)))
        local = np.full(len(self.relaxed.start), -1, np.int32)
        local[self.members] = np.arange(len(self.members), dtype=np.int32)
        if len(self.relaxed.costs):
            near = near_rows(self.relaxed.costs[np.ix_(self.members, self.members)], NEAR)
        else:
            near = near_points(self.relaxed.points[self.members], NEAR)
        own = np.repeat(np.arange(len(self.members), dtype=np.int32), near.shape[1])
        pairs = np.vstack([np.column_stack([own, near.ravel()]), local[ends]])
        pairs = np.unique(np.sort(pairs, axis=1), axis=0).astype(np.int32)
        self._edges = np.ascontiguousarray(pairs)
        self._lengths = edge_lengths(
            self.relaxed, self.members[pairs[:, 0]], self.members[pairs[:, 1]]
        )

    def _dense_tree(self, price: Floats) -> tuple[Ints, Floats]:
        """Return the ends of the edges of the least priced tree, and their weights."""
        size = len(self.members)
        members = self.members.copy()
        open_nodes, nearest, parent = (np.zeros(size, np.int32) for _ in range(3))
        reach, weight = np.zeros(size), np.zeros(size)
        relaxed = self.relaxed
        grow_tree(
            relaxed.costs,
            relaxed.points,
            relaxed.pace,
            members,
            price,
            open_nodes,
            nearest,
            reach,
            parent,
            weight,
        )
        return np.column_stack([members[1:], parent[1:]]), weight[1:]

    def _sparse_tree(self, price: Floats) -> tuple[Ints, Floats]:
        """Return the same for the sparse graph: an upper estimate of the least priced tree."""
        tolls = price[self.members]
        weights = self._lengths + tolls[self._edges[:, 0]] + tolls[self._edges[:, 1]]
        order = np.argsort(weights, kind='stable').astype(np.int32)
        size = len(self.members)
        chosen: Ints = np.zeros(size, np.int32)
        count = join_edges(self._edges, order, np.zeros(size, np.int32), chosen)
        chosen = chosen[:count]
        return self.members[self._edges[chosen]], weights[chosen]

    def evaluate(self, dense: bool) -> Forest:
        """Return the forest under the present prices; only the dense one proves anything."""
        tree = self._dense_tree if dense else self._sparse_tree
        ends, weights = tree(self.price)
        return cheapest_forest(self.relaxed, self.members, self.price, ends, weights, self.total)

    def step(self, target: float) -> None:
        """Move the prices once towards two legs at every member.

        `target` is the cost of a known plan: the step length aims at it (Polyak's rule).
        """
        sparse = len(self._edges) > 0
        forest = self.evaluate(dense=not sparse)
        if forest.level > self.best * (1 + 1e-9):
            self.best, self.best_price, self._stale = forest.level, self.price.copy(), 0
        else:
            self._stale += 1
            if self._stale >= 8:
                self._stride, self._stale = self._stride * 0.7, 0
        slope = (forest.degree - 2).astype(np.float64)
        self._momentum = 0.7 * slope + 0.3 * self._momentum
        norm = float(self._momentum @ self._momentum)
        if norm == 0:
            return
        shares = 1.0 if self.total else float(self.relaxed.shares[-1])
        gap = max(target - forest.level, 0.005 * abs(target)) * shares
        self.price = self.price.copy()
        self.price[self.members] += self._stride * gap / norm * self._momentum

    @property
    def exhausted(self) -> bool:
        """Whether the steps have become too short to gain anything."""
        return self._stride < 1e-3

    def proven(self) -> float:
        """Return the bound under the best prices, checked on the complete graph."""
        if len(self._edges) == 0:
            return self.best
        present, self.price = self.price, self.best_price
        try:
            return self.evaluate(dense=True).level
        finally:
            self.price = present


def edge_lengths(relaxed: Relaxation, one: Ints, other: Ints) -> Floats:
    """Return the cheapest legs between pairs of customers."""
    if len(relaxed.costs):
        return np.asarray(relaxed.costs[one, other], np.float64)
    distance = np.linalg.norm(relaxed.points[one] - relaxed.points[other], axis=1)
    least = np.full(len(distance), np.inf)
    for slowness, ramp, short, factor, stay in relaxed.pace:
        flown = np.where(distance >= short, distance * slowness + ramp, factor * np.sqrt(distance))
        least = np.minimum(least, flown + stay)
    return least


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class EndLegs:
    """First and last legs of k = 1, 2, .. routes, priced."""

    sums: Floats
    """(most,) what those of k routes cost at least."""
    firsts: Ints
    """Members that they lead to, the cheapest routes first."""
    lasts: Ints
    lone: bool
    """Whether the k-th route's last leg is that of the member after the k-th first."""

    def add_to(self, degree: Ints, members: Ints, k: int) -> None:
        """Count the legs of k + 1 routes at the customers that they lead to."""
        np.add.at(degree, members[self.firsts[: k + 1]], 1)
        lasts = self.lasts[: k + 1]
        if self.lone:
            lasts = np.concatenate([self.lasts[:k], self.firsts[k + 1 : k + 2]])
        np.add.at(degree, members[lasts], 1)


def shared_end_legs(relaxed: Relaxation, members: Ints, tolls: Floats, most: int) -> EndLegs:
    """Return end legs as if any start and end were everybody's: to k members, and from k."""
    first, last = relaxed.start[members] + tolls, relaxed.end[members] + tolls
    firsts = np.argsort(first, kind='stable')[: most + 1]
    lasts = np.argsort(last, kind='stable')[:most]
    sums = np.cumsum(first[firsts[:most]]) + np.cumsum(last[lasts])
    lone = relaxed.one_depot and len(members) > most
    if lone:  # not all routes serve one customer: some first and last customers differ
        sums += first[firsts[1:]] - last[lasts]
    return EndLegs(sums=sums, firsts=firsts, lasts=lasts, lone=lone)


def own_end_legs(relaxed: Relaxation, members: Ints, tolls: Floats, most: int) -> EndLegs:
    """Return end legs of the k vehicles that have the cheapest, wherever they lead."""
    first, last = relaxed.own[:, :, members] + tolls
    firsts, lasts = first.argmin(axis=1), last.argmin(axis=1)
    costs = first.min(axis=1) + last.min(axis=1)
    crew = np.argsort(costs, kind='stable')[:most]
    return EndLegs(sums=np.cumsum(costs[crew]), firsts=firsts[crew], lasts=lasts[crew], lone=False)


def cheapest_forest(
    relaxed: Relaxation, members: Ints, price: Floats, ends: Ints, weights: Floats, total: bool
) -> Forest:
    """Take the cheapest number of routes, and their forest, out of a least tree.

    k routes need the tree without its k - 1 heaviest edges, k first and k last legs to customers
    that differ among the first, and among the last, and of different vehicles.
    """
    size = len(members)
    most = min(len(relaxed.shares), size)
    heavy = np.argsort(-weights, kind='stable')[: most - 1]
    trees = weights.sum() - np.concatenate([[0.0], np.cumsum(weights[heavy])])
    tolls = price[members]
    ways = [shared_end_legs(relaxed, members, tolls, most)]
    if relaxed.own.shape[1]:
        ways.append(own_end_legs(relaxed, members, tolls, most))
    legs = np.maximum.reduce([way.sums for way in ways])
    levels = _levels(relaxed, trees + legs - 2 * tolls.sum(), size, total)
    k = int(np.argmin(levels))
    degree = np.zeros(len(relaxed.start), np.int32)
    kept = np.ones(len(weights), np.bool_)
    kept[heavy[:k]] = False
    np.add.at(degree, ends[kept].ravel(), 1)
    max(ways, key=lambda way: float(way.sums[k])).add_to(degree, members, k)
    return Forest(level=float(levels[k]), degree=degree[members])


def _levels(relaxed: Relaxation, sums: Floats, size: int, total: bool) -> Floats:
    """Return what k = 1, 2, .. routes of these summed legs cost; inf where more are needed."""
    most = len(sums)
    levels = sums if total else sums / relaxed.shares[:most] + relaxed.fixed[:most]
    routes = np.arange(1, most + 1)
    enough = sums <= relaxed.longest * routes * (1 + ROUNDING)
    enough &= (routes >= relaxed.fewest) | (routes == size)
    return np.where(enough, levels, np.inf) if enough.any() else levels
