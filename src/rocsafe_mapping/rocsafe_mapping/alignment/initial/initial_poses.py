# SPDX-License-Identifier: Apache-2.0
"""First poses of photographs from their pairs: turns and heights, then places.

Points of the ground are complex numbers. With its prior attitude, a pixel of photograph i points
along the slope a (metres over the ground for each metre down) and shows the ground point c + h
e^(i delta) a; c is the nadir, h the height, delta the error of the yaw. A pair gives a_j = m a_i +
b with m = (h_i / h_j) e^(i (delta_i - delta_j)): log m is linear in the log heights and the errors
of yaw. With both known, the places c are linear, too. Heights and places are not solved together:
with robust fixes all heights would go to zero.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_mapping.alignment.initial.pair_graph import (
    ComplexArray,
    Edge,
    IntArray,
    averaged,
    chained,
    groups_of,
    spanned,
)
from rocsafe_mapping.alignment.matching.pair_matching import Pair
from rocsafe_mapping.alignment.model.mark import Mark
from rocsafe_mapping.alignment.model.photo import Photo, Pose, rays_of_pixels
from rocsafe_mapping.alignment_options import InitialOptions

# Median distance of points of a normal distribution in the plane, over its standard deviation.
NORMAL_MEDIAN_RADIUS = 1.1774


@dataclass(frozen=True, slots=True, kw_only=True)
class InitialPoses:
    """Poses with which the adjustment begins.

    Attributes
    ----------
    poses
        Of the photographs that pairs tie together; of none that stands alone.
    pairs
        Those of the pairs that agree with each other.
    groups
        Names of the photographs that hang together, largest group first.
    is_yaw_believed
        Whether the yaws of each group agree with its fixes.
    anchors
        How many fixes and surveyed marks hold each group.
    """

    poses: Mapping[str, Pose]
    pairs: tuple[Pair, ...]
    groups: tuple[tuple[str, ...], ...]
    is_yaw_believed: tuple[bool, ...]
    anchors: tuple[int, ...]


def initial_poses(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    options: InitialOptions,
    marks: Sequence[Mark] = (),
) -> InitialPoses:
    """Return first poses of all photographs in `pairs`, contradicting pairs left out.

    Fixes and surveyed marks hold them; a group without any lies about the origin.
    """
    found = _poses(photos, pairs, options, marks)
    for _ in range(options.most_passes):
        if len(found.pairs) == len(pairs):
            break
        # A group may fall apart without the rejected pairs, which changes the values.
        pairs = found.pairs
        found = _poses(photos, pairs, options, marks)
    return found


def _poses(
    photos: Mapping[str, Photo],
    pairs: Sequence[Pair],
    options: InitialOptions,
    marks: Sequence[Mark],
) -> InitialPoses:
    poses: dict[str, Pose] = {}
    kept: list[Pair] = []
    groups, believed, anchors = [], [], []
    for names in groups_of(pairs):
        index = {name: number for number, name in enumerate(names)}
        edges = [_edge(photos, pair, index) for pair in pairs if pair.first in index]
        turns, heights, is_turned = _turned(photos, names, edges, options)
        held = _anchors(photos, names, marks)
        places, is_believed, is_placed = _placed(
            photos, names, edges, (turns, heights), held, options
        )
        for name, turn, height, place in zip(names, turns, heights, places, strict=True):
            poses[name] = _pose(photos[name], turn, height, place)
        agrees = is_turned & is_placed
        kept += [edge.pair for edge, is_kept in zip(edges, agrees, strict=True) if is_kept]
        groups.append(names)
        believed.append(is_believed)
        anchors.append(len(held))
    return InitialPoses(
        poses=poses,
        pairs=tuple(kept),
        groups=tuple(groups),
        is_yaw_believed=tuple(believed),
        anchors=tuple(anchors),
    )


def _edge(photos: Mapping[str, Photo], pair: Pair, index: Mapping[str, int]) -> Edge:
    used = ~pair.is_held_out
    first = _slopes(photos[pair.first], pair.first_px[used])
    second = _slopes(photos[pair.second], pair.second_px[used])
    first_middle, second_middle = complex(first.mean()), complex(second.mean())
    spread = first - first_middle
    factor = complex(np.vdot(spread, second - second_middle) / np.vdot(spread, spread).real)
    return Edge(
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
    photos: Mapping[str, Photo], names: Sequence[str], edges: list[Edge], options: InitialOptions
) -> tuple[FloatArray, FloatArray, BoolArray]:
    """Return each photograph's turn and height, and which pairs agree with them."""
    guess = spanned(len(names), edges)
    log_prior = np.log([photos[name].prior.centre[2] for name in names])
    turns = averaged(edges, guess.imag, options.angle_scale_rad, options, wrapped=True)
    logs = averaged(edges, guess.real, options.log_scale, options, wrapped=False)
    off = np.array([_misfit(edge, turns, logs) for edge in edges])
    largest = options.largest_turn_rad, options.largest_log_scale
    agrees = np.all(np.abs(off) < largest, axis=1)
    turns -= _common_turn(turns, photos, names)
    logs += np.median(log_prior - logs)
    return turns, np.exp(logs), agrees


def _misfit(edge: Edge, turns: FloatArray, logs: FloatArray) -> tuple[float, float]:
    log = np.log(edge.factor)
    turn = turns[edge.first] - turns[edge.second] - log.imag
    scale = logs[edge.first] - logs[edge.second] - log.real
    return _wrap(turn), float(scale)


def _wrap(angle: float) -> float:
    return math.remainder(angle, 2.0 * math.pi)


def _common_turn(turns: FloatArray, photos: Mapping[str, Photo], names: Sequence[str]) -> float:
    """Return the turn that most of the yaws agree on, as a circular median."""
    known = np.array([photos[name].has_yaw for name in names])
    votes = turns[known] if np.any(known) else turns
    costs = np.abs(np.angle(np.exp(1j * (votes[:, np.newaxis] - votes)))).sum(axis=0)
    return float(votes[int(np.argmin(costs))])


@dataclass(frozen=True, slots=True, kw_only=True)
class _Anchor:
    """A place that is known: that of a fix, or of a surveyed mark.

    Attributes
    ----------
    known, std_m
        The place, east + i north, and its uncertainty.
    seen_by
        Indices of the photographs that show it (k,).
    slopes
        Along which they show it (k,), complex; 0 for the nadir of a photograph, which is its fix.
    """

    known: complex
    std_m: float
    seen_by: IntArray
    slopes: ComplexArray

    def place(self, free: ComplexArray, steps: ComplexArray) -> complex:
        """Return where the photographs at `free` show it; `steps` are heights with turns."""
        return complex(np.mean(free[self.seen_by] + steps[self.seen_by] * self.slopes))


def _anchors(
    photos: Mapping[str, Photo], names: Sequence[str], marks: Sequence[Mark]
) -> list[_Anchor]:
    """Return the fixes and marks of a group of photographs."""
    found = [
        _Anchor(
            known=complex(*photos[name].prior.centre[:2]),
            std_m=photos[name].horizontal_std_m,
            seen_by=np.array([number]),
            slopes=np.zeros(1, complex),
        )
        for number, name in enumerate(names)
        if photos[name].has_fix
    ]
    index = {name: number for number, name in enumerate(names)}
    for mark in marks:
        seen = sorted(set(mark.sightings) & set(index))
        if seen:
            slopes = [_slopes(photos[name], mark.sightings[name][np.newaxis]) for name in seen]
            found.append(
                _Anchor(
                    known=complex(*mark.surveyed_m),
                    # Tilts that are not known yet move the mark.
                    std_m=photos[seen[0]].tilt_std_rad * float(photos[seen[0]].prior.centre[2]),
                    seen_by=np.array([index[name] for name in seen]),
                    slopes=np.concatenate(slopes),
                )
            )
    return found


def _placed(
    photos: Mapping[str, Photo],
    names: Sequence[str],
    edges: Sequence[Edge],
    turned: tuple[FloatArray, FloatArray],
    anchors: Sequence[_Anchor],
    options: InitialOptions,
) -> tuple[ComplexArray, bool, BoolArray]:
    """Return the nadirs, whether the yaws agree with the anchors, and which pairs agree.

    Changes the turns and heights (`turned`) where the anchors show that all have a common error.
    """
    turns, heights = turned
    steps = heights * np.exp(1j * turns)
    shifts = np.array(
        [
            steps[edge.first] * edge.first_middle - steps[edge.second] * edge.second_middle
            for edge in edges
        ]
    )
    free, agrees = chained(len(names), edges, shifts, float(np.median(heights)), options)
    has_yaw = any(photos[name].has_yaw for name in names)
    if not anchors:
        return free - free.mean(), has_yaw, agrees
    known = np.array([anchor.known for anchor in anchors])
    std_m = np.array([anchor.std_m for anchor in anchors])
    held = np.array([anchor.place(free, steps) for anchor in anchors])
    turn, scale, scatter = _laid_on_fixes(held, known, std_m, options.rounds)
    spread_m = float(np.sqrt(np.mean(np.abs(held - held.mean()) ** 2)))
    turn_std = float(np.median(std_m)) / max(spread_m * math.sqrt(len(anchors)), 1e-9)
    guesses = [photos[name].vertical_std_m / photos[name].prior.centre[2] for name in names]
    is_guessed = float(np.median(guesses)) > options.guessed_height_share
    told_m = float(np.sqrt(np.mean(np.abs(known - known.mean()) ** 2)))
    is_told = told_m > options.least_baselines * float(np.median(std_m)) and scale > 0.0
    is_contradicted = (
        is_told and abs(math.log(scale)) > options.scale_certainty * scatter * turn_std
    )
    if len(anchors) > 1 and scale > 0.0 and (is_guessed or is_contradicted):
        heights *= scale
        free, held = free * scale, held * scale
    is_believed = has_yaw and abs(turn) < max(options.yaw_disbelief_rad, 4.0 * turn_std)
    if not is_believed and turn_std < options.yaw_disbelief_rad:
        turns += turn
        free, held = free * np.exp(1j * turn), held * np.exp(1j * turn)
    return free + _robust_middle(known - held, std_m, options.rounds), is_believed, agrees


def _laid_on_fixes(
    places: ComplexArray, fixes: ComplexArray, std_m: FloatArray, rounds: int
) -> tuple[float, float, float]:
    """Return the turn and the scale that lay `places` best on `fixes`, robustly.

    The third value is the scatter of the fixes over what they claim, at least 1.
    """
    weight: FloatArray = np.ones(len(places))
    factor, scatter = 1.0 + 0.0j, 1.0
    for _ in range(rounds):
        middle = np.average(places, weights=weight), np.average(fixes, weights=weight)
        spread, wanted = places - middle[0], fixes - middle[1]
        size = max(float(np.sum(weight * np.abs(spread) ** 2)), 1e-9)
        factor = complex(np.sum(weight * np.conj(spread) * wanted) / size)
        off = np.abs(spread * factor - wanted) / std_m
        # Fixes may scatter farther than they claim: then they would prefer too small a scale.
        scatter = max(1.0, float(np.median(off)) / NORMAL_MEDIAN_RADIUS)
        weight = 1.0 / (1.0 + (off / (2.0 * scatter)) ** 2)
    return float(np.angle(factor)), abs(factor), scatter


def _robust_middle(values: ComplexArray, std_m: FloatArray, rounds: int) -> complex:
    middle = complex(np.median(values.real), np.median(values.imag))
    for _ in range(rounds):
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
