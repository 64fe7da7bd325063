# SPDX-License-Identifier: Apache-2.0
"""Kinds of ground that a scene file can name: their marks, classes and earthworks."""

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import shapely

from rocsafe_scene.ground.relief import Course
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.painting import farmland, roads
from rocsafe_scene.painting.marks import Mark, Paint, normals_of, polygon, ribbon, stroke
from rocsafe_scene.painting.outlines import blob, faded, generator, smooth_line

Rgb = Sequence[int]

_CESS = Paint((112, 108, 88), 150, 0.6, 0.3)
_SHOULDER = Paint((104, 100, 92), 235)
_BALLAST = Paint((128, 123, 117), 250)
_STAIN = Paint((92, 74, 58), 220, 0.5, 0.3)
_GOUGE = Paint((84, 62, 44), 200, 0.8, 0.3)
_EARTH = Paint((112, 86, 60), 190, 0.85)
_SCORCHED = Paint((34, 30, 28), 150, 0.82)
_SHEEN = Paint((44, 32, 40), 25, 0.86, 0.15)
_WET_RIM = Paint((96, 92, 52), 90, 0.5, 0.35)


@dataclass(frozen=True, slots=True, eq=False)
class Stencil:
    """Outlines (k, 2), metres east and north, within which the ground has a class."""

    label: str
    outlines: Sequence[Floats]


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class GroundWork:
    """Marks, classes and earthworks of one entry of a scene's ground."""

    marks: tuple[Mark, ...] = ()
    stencils: tuple[Stencil, ...] = ()
    courses: tuple[Course, ...] = field(default=())


def ploughed_field(outline: Floats, seed: int, yaw_rad: float = 0.0) -> GroundWork:
    """Return soil in furrows."""
    marks = farmland.ploughed_field(outline, yaw_rad, seed)
    return GroundWork(marks=marks, stencils=(Stencil('soil', [outline]),))


def meadow(
    outline: Floats,
    seed: int,
    yaw_rad: float = 0.0,
    colour: Rgb = (104, 126, 62),
    swath_m: float = 3.2,
) -> GroundWork:
    """Return a mown meadow."""
    red, green, blue = colour
    marks = farmland.meadow(outline, yaw_rad, (red, green, blue), seed, swath_m)
    return GroundWork(marks=marks, stencils=(Stencil('meadow', [outline]),))


def yard(
    outline: Floats, seed: int, colour: Rgb = (164, 152, 128), label: str = 'gravel'
) -> GroundWork:
    """Return a gravelled or paved yard, worn here and there."""
    red, green, blue = colour
    rng = generator(seed, 81)
    low, high = outline.min(axis=0), outline.max(axis=0)
    marks: list[Mark] = list(farmland.yard(outline, (red, green, blue)))
    for _ in range(9):
        worn = Paint((red - 26, green - 28, blue - 26), 140, 0.35)
        patch = blob(
            rng, rng.uniform(low, high), tuple(rng.uniform(0.8, 3.4, 2)), rng.uniform(0, 3)
        )
        marks.append(faded(patch, worn))
    return GroundWork(marks=tuple(marks), stencils=(Stencil(label, [outline]),))


def road(line: Floats, seed: int, width_m: float = 6.2, lift_m: float = 0.25) -> GroundWork:
    """Return an asphalt road, a little above the fields."""
    course = smooth_line(line, 2.0)
    return GroundWork(
        marks=roads.road(line, width_m, seed),
        stencils=(Stencil('asphalt', [ribbon(course, width_m)]),),
        courses=(_course(course, 0.5 * width_m + 1.0, lift_m, 5.0),),
    )


def gravel_track(line: Floats, seed: int, width_m: float = 3.4) -> GroundWork:
    """Return a farm track."""
    course = smooth_line(line, 2.0)
    return GroundWork(
        marks=roads.gravel_track(line, width_m, seed),
        stencils=(Stencil('gravel', [ribbon(course, width_m)]),),
        courses=(_course(course, 0.5 * width_m + 0.5, 0.08, 3.0),),
    )


def stream(line: Floats, seed: int, width_m: float = 2.4, depth_m: float = 1.1) -> GroundWork:
    """Return a stream in its bed."""
    course = smooth_line(line, 2.0)
    return GroundWork(
        marks=roads.stream(line, width_m, seed),
        stencils=(Stencil('water', [ribbon(course, width_m)]),),
        courses=(_course(course, 0.45 * width_m, -depth_m, 3.2),),
    )


def railway(line: Floats, seed: int, lift_m: float = 0.7) -> GroundWork:
    """Return the ballast bed of a single track; rails and sleepers are objects."""
    course = smooth_line(line, 2.0)
    rng = generator(seed, 82)
    marks: list[Mark] = [
        stroke(course, 7.6, _CESS),
        stroke(course + rng.normal(0.0, 0.06, course.shape), 5.2, _SHOULDER),
        stroke(course, 4.2, _BALLAST),
        stroke(course, 0.9, _STAIN),
    ]
    for start in range(0, len(course) - 6, 7):
        reach = int(rng.integers(2, 6))
        marks.append(stroke(course[start : start + reach], float(rng.uniform(1.2, 3.0)), _STAIN))
    return GroundWork(
        marks=tuple(marks),
        stencils=(Stencil('ballast', [ribbon(course, 5.0)]),),
        courses=(_course(course, 2.6, lift_m, 2.6),),
    )


def torn_earth(outline: Floats, seed: int) -> GroundWork:
    """Return earth torn up: a ragged patch with gouges through it."""
    rng = generator(seed, 83)
    middle, spread = outline.mean(axis=0), np.ptp(outline, axis=0)
    radii = (0.5 * float(spread[0]), 0.5 * float(spread[1]))
    marks: list[Mark] = [faded(blob(rng, middle, radii, 0.0), _EARTH, spread=0.35)]
    for _ in range(3):
        ends = middle + rng.normal(0.0, 0.3, (3, 2)) * spread
        marks.append(
            stroke(smooth_line(ends[np.argsort(ends[:, 0])], 1.0), rng.uniform(0.5, 1.3), _GOUGE)
        )
    return GroundWork(marks=tuple(marks), stencils=(Stencil('soil', [_shrunk(outline)]),))


def scorch(outline: Floats, seed: int) -> GroundWork:
    """Return burnt ground, fading outwards."""
    rng = generator(seed, 84)
    middle, spread = outline.mean(axis=0), 0.5 * np.ptp(outline, axis=0)
    marks = [
        faded(
            blob(rng, middle + rng.normal(0.0, 0.2, 2) * spread, tuple(spread * s), 0.0), _SCORCHED
        )
        for s in (1.0, 0.7, 0.5)
    ]
    return GroundWork(marks=tuple(marks), stencils=(Stencil('scorch', [_shrunk(outline)]),))


def spill(line: Floats, seed: int, width_m: float = 1.6) -> GroundWork:
    """Return liquid that ran along `line`, wide at its start, in pools where it stood."""
    rng = generator(seed, 85)
    course = smooth_line(line, 0.6)
    wet = shapely.union_all([_stream(rng, course, width_m), *_pools(rng, course, width_m)])
    rim = wet.buffer(0.3 * width_m)
    flows = [np.asarray(part.exterior.coords) for part in shapely.get_parts(wet)]
    marks = [
        *(polygon(np.asarray(p.exterior.coords), _WET_RIM) for p in shapely.get_parts(rim)),
        *(polygon(flow, _SHEEN) for flow in flows),
    ]
    # The labels end where the liquid does; the wet rim counts as the ground around.
    return GroundWork(marks=tuple(marks), stencils=(Stencil('spill', flows),))


def _stream(rng: np.random.Generator, course: Floats, width_m: float) -> shapely.Polygon:
    """Return the outline of a stream of liquid along `course`, which gets thinner."""
    along = np.linspace(0.0, 1.0, len(course))
    bays = np.linspace(0.0, 1.0, max(4, len(course) // 5))
    fade = np.interp(along, [0.0, 0.1, 0.6, 1.0], [0.75, 0.5, 0.33, 0.12])
    left, right = (
        width_m * fade * np.interp(along, bays, rng.uniform(0.55, 1.35, len(bays)))
        for _ in range(2)
    )
    normals = normals_of(course)
    banks = [course + left[:, None] * normals, (course - right[:, None] * normals)[::-1]]
    return shapely.Polygon(np.vstack(banks)).buffer(0.0)


def _pools(rng: np.random.Generator, course: Floats, width_m: float) -> list[shapely.Polygon]:
    """Return pools: one at the start of `course`, and a few on its way."""
    places = np.concatenate([[0.03], np.sort(rng.uniform(0.1, 0.9, 3))])
    pools = []
    for place, size in zip(places, (1.9, *rng.uniform(0.8, 1.3, 3)), strict=True):
        centre = course[int(place * (len(course) - 1))]
        half_m = width_m * float(size)
        pools.append(blob(rng, centre, (half_m, 0.6 * half_m), rng.uniform(0.0, 3.0)))
    return [shapely.Polygon(pool).buffer(0.0) for pool in pools]


def _course(line: Floats, half_width_m: float, lift_m: float, slope_m: float) -> Course:
    return Course(line=line, half_width_m=half_width_m, lift_m=lift_m, slope_m=slope_m)


def _shrunk(outline: Floats) -> Floats:
    middle = outline.mean(axis=0)
    return np.asarray(middle + 0.62 * (outline - middle))


GroundMaker = Callable[..., GroundWork]
# By kind: its function, and whether that takes an outline or a line.
GROUND_KINDS: Mapping[str, tuple[GroundMaker, str]] = {
    'ploughed_field': (ploughed_field, 'outline'),
    'meadow': (meadow, 'outline'),
    'yard': (yard, 'outline'),
    'road': (road, 'line'),
    'gravel_track': (gravel_track, 'line'),
    'stream': (stream, 'line'),
    'railway': (railway, 'line'),
    'torn_earth': (torn_earth, 'outline'),
    'scorch': (scorch, 'outline'),
    'spill': (spill, 'line'),
}


def yaw_of(options: dict[str, object]) -> dict[str, object]:
    """Return `options` with a yaw in degrees turned into radians."""
    if 'yaw_deg' not in options:
        return options
    rest = {name: value for name, value in options.items() if name != 'yaw_deg'}
    return {**rest, 'yaw_rad': math.radians(float(str(options['yaw_deg'])))}
