# SPDX-License-Identifier: Apache-2.0
"""Pairs as edges of a graph: connected groups, and values whose differences fit the edges."""

from collections import deque
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment_options import InitialOptions

ComplexArray = NDArray[np.complex128]
IntArray = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Edge:
    """A pair as a similarity a_second = m a_first + b, with the means of its ties."""

    pair: Pair
    first: int
    second: int
    factor: complex
    first_middle: complex
    second_middle: complex


def groups_of(pairs: Sequence[Pair]) -> list[tuple[str, ...]]:
    """Return the names that pairs tie together, largest group first."""
    near: dict[str, list[str]] = {}
    for pair in pairs:
        near.setdefault(pair.first, []).append(pair.second)
        near.setdefault(pair.second, []).append(pair.first)
    groups, seen = [], set()
    for name in sorted(near):
        if name in seen:
            continue
        group, waiting = {name}, deque([name])
        while waiting:
            fresh = set(near[waiting.popleft()]) - group
            group |= fresh
            waiting += sorted(fresh)
        seen |= group
        groups.append(tuple(sorted(group)))
    return sorted(groups, key=lambda group: (-len(group), group))


def spanned(count: int, edges: Sequence[Edge]) -> ComplexArray:
    """Return log height + i turn of each photograph, along a spanning tree of strongest pairs."""
    near: dict[int, list[tuple[int, int, complex]]] = {}
    for edge in edges:
        log = complex(np.log(edge.factor))
        near.setdefault(edge.first, []).append((len(edge.pair), edge.second, -log))
        near.setdefault(edge.second, []).append((len(edge.pair), edge.first, log))
    found = np.zeros(count, complex)
    reached = {0}
    rim = [(-strength, 0, other, log) for strength, other, log in near[0]]
    while rim:
        rim.sort(reverse=True)
        _, start_at, other, log = rim.pop()
        if other in reached:
            continue
        reached.add(other)
        found[other] = found[start_at] + log
        rim += [(-strength, other, further, log) for strength, further, log in near[other]]
    return found


def averaged(
    edges: Sequence[Edge],
    guess: FloatArray,
    scale: float,
    options: InitialOptions,
    *,
    wrapped: bool,
) -> FloatArray:
    """Return the values whose differences fit `edges` best, robustly; the first is kept."""
    first = np.array([edge.first for edge in edges])
    second = np.array([edge.second for edge in edges])
    logs = np.log(np.array([edge.factor for edge in edges]))
    wanted = logs.imag if wrapped else logs.real
    strength = np.sqrt([len(edge.pair) for edge in edges])
    values = guess.copy()
    for _ in range(options.rounds):
        off = wanted - (values[first] - values[second])
        off = np.angle(np.exp(1j * off)) if wrapped else off
        weight = strength / (1.0 + (off / scale) ** 2)
        step = _fitted((second, first), weight**2, off, len(guess), options.most_full)
        values += step
        if np.max(np.abs(step)) < options.converged:
            break
    return values


def chained(
    count: int,
    edges: Sequence[Edge],
    shifts: ComplexArray,
    height_m: float,
    options: InitialOptions,
) -> tuple[ComplexArray, BoolArray]:
    """Return places whose differences, second less first, fit `shifts` robustly.

    The first place is 0. Also which pairs agree: a pair of different ground that looks alike
    contradicts the loops that it closes.
    """
    first = np.array([edge.first for edge in edges])
    second = np.array([edge.second for edge in edges])
    strength = np.sqrt([len(edge.pair) for edge in edges])
    places: NDArray[Any] = np.zeros(count, complex)
    off = np.zeros(len(edges))
    for _ in range(options.rounds):
        weight = strength / np.sqrt(1.0 + (off / (options.shift_share * height_m)) ** 2)
        before = places
        places = _fitted((first, second), weight**2, shifts, count, options.most_full)
        off = np.abs(places[second] - places[first] - shifts)
        if np.max(np.abs(places - before)) < options.converged * height_m:
            break
    return places, off < options.largest_shift_share * height_m


def _fitted(
    ends: tuple[IntArray, IntArray],
    weight: FloatArray,
    wanted: NDArray[Any],
    count: int,
    most_full: int,
) -> NDArray[Any]:
    """Return values (count,) whose differences, second less first, fit `wanted` (n,) best.

    The first value is 0. Small graphs are solved as full matrices: building a sparse one takes
    longer than solving it.
    """
    first, second = ends
    pull = weight * wanted
    right = np.zeros(count, wanted.dtype)
    np.add.at(right, second, pull)
    np.add.at(right, first, -pull)
    rows = np.concatenate([first, second, first, second])
    columns = np.concatenate([first, second, second, first])
    entries = np.concatenate([weight, weight, -weight, -weight])
    values = np.zeros(count, wanted.dtype)
    if count <= most_full:
        full = np.bincount(rows * count + columns, entries, count * count).reshape(count, count)
        values[1:] = np.linalg.solve(full[1:, 1:], right[1:])
    else:
        graph = coo_matrix((entries, (rows, columns)), shape=(count, count)).tocsc()[1:, 1:]
        parts = spsolve(graph, np.column_stack([right[1:].real, right[1:].imag]))
        values[1:] = parts[:, 0] if wanted.dtype == float else parts @ [1.0, 1.0j]
    return values
