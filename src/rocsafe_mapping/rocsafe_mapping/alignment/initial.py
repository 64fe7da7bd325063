# SPDX-License-Identifier: Apache-2.0
"""First poses of photographs from their pairs: turns and heights, then places.

Seen from straight above, photograph i shows at the complex ground point c + h e^(i delta) a what
its prior attitude puts at the slope a: c is the place below it, h its height, delta what its yaw
lacks. A pair gives a_j = m a_i + b with m = (h_i / h_j) e^(i (delta_i - delta_j)): all log m are
linear in the log heights and the turns. With both known the places are linear too. The height is
not solved together with the places: against robust fixes that system shrinks to nothing.
"""

import math
from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.sparse import coo_matrix
from scipy.sparse.linalg import spsolve

from rocsafe_mapping.alignment.matching import Pair
from rocsafe_mapping.alignment.photo import FloatArray, Photo, Pose, rays_of_pixels

ComplexArray = NDArray[np.complex128]
BoolArray = NDArray[np.bool_]
ROUNDS = 12
ANGLE_SCALE_RAD = math.radians(2.0)
LOG_SCALE = 0.03
# What a loop of pairs may be off before one of them is disbelieved.
LARGEST_TURN_RAD = math.radians(9.0)
LARGEST_LOG_SCALE = 0.16
# The same of shifts, over the flying height; tilts alone move them by a tenth of it.
SHIFT_SHARE, LARGEST_SHIFT_SHARE = 0.03, 0.25
MOST_PASSES = 4
# Yaws of a group that are this far from what the fixes say are not believed.
# A height less certain than this is taken from the fixes.
GUESSED_HEIGHT_SHARE = 0.2
YAW_DISBELIEF_RAD = math.radians(20.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class Start:
    """Where the adjustment begins.

    Attributes
    ----------
    poses: of the photographs that pairs tie together; of none that stands alone.
    pairs: those of the pairs that agree with each other.
    groups: names of the photographs that hang together, largest group first.
    is_yaw_believed: whether the yaws of each group agree with its fixes.
    """

    poses: Mapping[str, Pose]
    pairs: tuple[Pair, ...]
    groups: tuple[tuple[str, ...], ...]
    is_yaw_believed: tuple[bool, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Edge:
    """A pair as a similarity: a_second = m a_first + b, with middles of its ties on both sides."""

    pair: Pair
    first: int
    second: int
    factor: complex
    first_middle: complex
    second_middle: complex


def start(photos: Mapping[str, Photo], pairs: Sequence[Pair]) -> Start:
    """Return first poses for all photographs that agreeing `pairs` tie to another."""
    found = _start(photos, pairs)
    for _ in range(MOST_PASSES):
        if len(found.pairs) == len(pairs):
            break
        # Without the pairs that contradict the others, groups may fall apart and values change.
        pairs = found.pairs
        found = _start(photos, pairs)
    return found


def _start(photos: Mapping[str, Photo], pairs: Sequence[Pair]) -> Start:
    poses: dict[str, Pose] = {}
    kept: list[Pair] = []
    groups, believed = [], []
    for names in _groups(pairs):
        index = {name: number for number, name in enumerate(names)}
        edges = [_edge(photos, pair, index) for pair in pairs if pair.first in index]
        turns, heights, is_turned = _turned(photos, names, edges)
        places, is_believed, is_placed = _placed(photos, names, edges, turns, heights)
        for name, turn, height, place in zip(names, turns, heights, places, strict=True):
            poses[name] = _pose(photos[name], turn, height, place)
        agrees = is_turned & is_placed
        kept += [edge.pair for edge, is_kept in zip(edges, agrees, strict=True) if is_kept]
        groups.append(names)
        believed.append(is_believed)
    return Start(
        poses=poses, pairs=tuple(kept), groups=tuple(groups), is_yaw_believed=tuple(believed)
    )


def groups_of(pairs: Sequence[Pair]) -> tuple[tuple[str, ...], ...]:
    """Return the names that pairs tie together, largest group first."""
    return tuple(_groups(pairs))


def _groups(pairs: Sequence[Pair]) -> list[tuple[str, ...]]:
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


def _edge(photos: Mapping[str, Photo], pair: Pair, index: Mapping[str, int]) -> _Edge:
    used = ~pair.is_held_out
    first = _slopes(photos[pair.first], pair.first_px[used])
    second = _slopes(photos[pair.second], pair.second_px[used])
    first_middle, second_middle = complex(first.mean()), complex(second.mean())
    spread = first - first_middle
    factor = complex(np.vdot(spread, second - second_middle) / np.vdot(spread, spread).real)
    return _Edge(
        pair=pair,
        first=index[pair.first],
        second=index[pair.second],
        factor=factor,
        first_middle=first_middle,
        second_middle=second_middle,
    )


def _slopes(photo: Photo, pixels: FloatArray) -> ComplexArray:
    """Return where pixels lie on the ground in heights, with the prior attitude; complex."""
    rays = rays_of_pixels(photo.camera, pixels) @ photo.prior.rotation.T
    drop = np.maximum(-rays[:, 2], 1e-3)
    slopes: ComplexArray = (rays[:, 0] + 1j * rays[:, 1]) / drop
    return slopes


def _turned(
    photos: Mapping[str, Photo], names: Sequence[str], edges: list[_Edge]
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return each photograph's turn and height, and which pairs agree with them."""
    guess = _spanned(len(names), edges)
    log_prior = np.log([photos[name].prior.centre[2] for name in names])
    turns = _averaged(len(names), edges, guess.imag, ANGLE_SCALE_RAD, wrapped=True)
    logs = _averaged(len(names), edges, guess.real, LOG_SCALE, wrapped=False)
    off = np.array([_misfit(edge, turns, logs) for edge in edges])
    agrees = np.all(np.abs(off) < (LARGEST_TURN_RAD, LARGEST_LOG_SCALE), axis=1)
    turns -= _common_turn(turns, photos, names)
    logs += np.median(log_prior - logs)
    return turns, np.exp(logs), agrees


def _misfit(edge: _Edge, turns: FloatArray, logs: FloatArray) -> tuple[float, float]:
    log = np.log(edge.factor)
    turn = turns[edge.first] - turns[edge.second] - log.imag
    scale = logs[edge.first] - logs[edge.second] - log.real
    return _wrap(turn), float(scale)


def _wrap(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _spanned(count: int, edges: Sequence[_Edge]) -> ComplexArray:
    """Return log height + i turn of each photograph along the strongest pairs from the first."""
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


def _averaged(
    count: int, edges: Sequence[_Edge], guess: FloatArray, scale: float, *, wrapped: bool
) -> FloatArray:
    """Return the values whose differences over `edges` fit best, robustly; the first stays."""
    first = np.array([edge.first for edge in edges])
    second = np.array([edge.second for edge in edges])
    logs = np.log(np.array([edge.factor for edge in edges]))
    wanted = logs.imag if wrapped else logs.real
    strength = np.sqrt([len(edge.pair) for edge in edges])
    values = guess.copy()
    rows = np.arange(len(edges))
    for _ in range(ROUNDS):
        off = wanted - (values[first] - values[second])
        off = np.angle(np.exp(1j * off)) if wrapped else off
        weight = strength / (1.0 + (off / scale) ** 2)
        design = coo_matrix(
            (
                np.concatenate([weight, -weight]),
                (np.tile(rows, 2), np.concatenate([first, second])),
            ),
            shape=(len(edges), count),
        ).tocsr()[:, 1:]
        if count == 1:
            break
        normal = (design.T @ design).tocsc()
        step = spsolve(normal, design.T @ (weight * off))
        values[1:] += step
        if np.max(np.abs(step)) < 1e-6:
            break
    return values


def _common_turn(turns: FloatArray, photos: Mapping[str, Photo], names: Sequence[str]) -> float:
    """Return the turn that most of the yaws agree on, as a circular median."""
    known = np.array([photos[name].has_yaw for name in names])
    votes = turns[known] if np.any(known) else turns
    costs = np.abs(np.angle(np.exp(1j * (votes[:, np.newaxis] - votes)))).sum(axis=0)
    return float(votes[int(np.argmin(costs))])


def _placed(
    photos: Mapping[str, Photo],
    names: Sequence[str],
    edges: Sequence[_Edge],
    turns: FloatArray,
    heights: FloatArray,
) -> tuple[ComplexArray, bool, BoolArray]:
    """Return the place below each photograph, whether the yaws were of use, and which pairs agree.

    Changes `turns` and `heights` where the fixes say that all of them are wrong alike.
    """
    fixes = np.array([complex(*photos[name].prior.centre[:2]) for name in names])
    std_m = np.array([photos[name].horizontal_std_m for name in names])
    steps = heights * np.exp(1j * turns)
    shifts = np.array(
        [
            steps[edge.first] * edge.first_middle - steps[edge.second] * edge.second_middle
            for edge in edges
        ]
    )
    free, agrees = _chained(len(names), edges, shifts, float(np.median(heights)))
    turn, scale = _laid_on_fixes(free, fixes, std_m)
    guesses = [photos[name].vertical_std_m / photos[name].prior.centre[2] for name in names]
    if np.median(guesses) > GUESSED_HEIGHT_SHARE and len(names) > 2:
        heights *= scale
        free = free * scale
    has_yaw = any(photos[name].has_yaw for name in names)
    spread_m = float(np.sqrt(np.mean(np.abs(free - free.mean()) ** 2)))
    turn_std = float(np.median(std_m)) / max(spread_m * math.sqrt(len(names)), 1e-9)
    is_believed = has_yaw and abs(turn) < max(YAW_DISBELIEF_RAD, 4.0 * turn_std)
    if not is_believed and turn_std < YAW_DISBELIEF_RAD:
        turns += turn
        free = free * np.exp(1j * turn)
    return free + _robust_middle(fixes - free, std_m), is_believed, agrees


def _chained(
    count: int, edges: Sequence[_Edge], shifts: ComplexArray, height_m: float
) -> tuple[ComplexArray, BoolArray]:
    """Return places whose differences, second less first, are `shifts`, the first at 0, robustly.

    With them which pairs agree: one that ties look-alikes contradicts the loops that it closes.
    """
    first = np.array([edge.first for edge in edges])
    second = np.array([edge.second for edge in edges])
    strength = np.sqrt([len(edge.pair) for edge in edges])
    rows = np.arange(len(edges))
    places = np.zeros(count, complex)
    off = np.zeros(len(edges))
    for _ in range(ROUNDS):
        weight = strength / np.sqrt(1.0 + (off / (SHIFT_SHARE * height_m)) ** 2)
        entries = np.concatenate([weight, -weight])
        design = coo_matrix(
            (entries, (np.tile(rows, 2), np.concatenate([second, first]))),
            shape=(len(edges), count),
        ).tocsr()[:, 1:]
        wanted = np.column_stack([(weight * shifts).real, (weight * shifts).imag])
        solved = spsolve((design.T @ design).tocsc(), design.T @ wanted)
        solved = np.asarray(solved).reshape(-1, 2)
        places[1:] = solved[:, 0] + 1j * solved[:, 1]
        off = np.abs(places[second] - places[first] - shifts)
    return places, off < LARGEST_SHIFT_SHARE * height_m


def _laid_on_fixes(
    places: ComplexArray, fixes: ComplexArray, std_m: FloatArray
) -> tuple[float, float]:
    """Return the turn and the scale that lay `places` best on `fixes`, robustly."""
    weight: FloatArray = np.ones(len(places))
    factor = 1.0 + 0.0j
    for _ in range(ROUNDS):
        middle = np.average(places, weights=weight), np.average(fixes, weights=weight)
        spread, wanted = places - middle[0], fixes - middle[1]
        size = max(float(np.sum(weight * np.abs(spread) ** 2)), 1e-9)
        factor = complex(np.sum(weight * np.conj(spread) * wanted) / size)
        off = np.abs(spread * factor - wanted) / std_m
        weight = 1.0 / (1.0 + (off / 2.0) ** 2)
    return float(np.angle(factor)), abs(factor)


def _robust_middle(values: ComplexArray, std_m: FloatArray) -> complex:
    middle = complex(np.median(values.real), np.median(values.imag))
    for _ in range(ROUNDS):
        weight = 1.0 / (std_m**2 + (np.abs(values - middle) / 2.0) ** 2)
        middle = complex(np.average(values, weights=weight))
    return middle


def _pose(photo: Photo, turn: float, height_m: float, place: complex) -> Pose:
    cos, sin = math.cos(turn), math.sin(turn)
    about_up = np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])
    return Pose(
        centre=np.array([place.real, place.imag, height_m]),
        rotation=about_up @ photo.prior.rotation,
    )
