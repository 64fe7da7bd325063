# SPDX-License-Identifier: Apache-2.0
"""The relief of the ground: hills, embankments, cuttings, stream beds, level places."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from rocsafe_geo.terrain.height_grid import GridFrame
from rocsafe_scene.ground.terrain import HeightFunction
from rocsafe_scene.mesh.lines import nearest_on, resampled, run_of
from rocsafe_scene.mesh.mesh import Floats
from rocsafe_scene.painting.noise import CM_PER_M, Window, fractal_at


@dataclass(frozen=True, slots=True, kw_only=True)
class ReliefOptions:
    """Form of the noise and of the earthworks, set by the look of the pictures.

    Attributes
    ----------
    local
        Share of the relief of octaves 7 to 13, where octave k has a spacing of 2^k cm: from bumps
        of 1 m to rises of 80 m.
    hills
        Share of octaves 14 to 16.
    plain_m, hilly_m
        Hills grow to full height between these distances from the origin, metres.
    levelled_m, course_step_m
        The height of a course is averaged over this length, from samples of this spacing, metres.
    cell_m
        Spacing of the heights below a course or a pad, metres.
    """

    local: tuple[float, ...] = (0.012, 0.03, 0.07, 0.14, 0.25, 0.5, 0.75)
    hills: tuple[float, ...] = (0.25, 0.6, 1.0)
    plain_m: float = 190.0
    hilly_m: float = 1400.0
    levelled_m: float = 120.0
    course_step_m: float = 4.0
    cell_m: float = 5.12


RELIEF = ReliefOptions()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Course:
    """Earthwork along a line: a levelled and lifted (or lowered) strip with flanks.

    Attributes
    ----------
    line
        Centre line, (k, 2), metres.
    half_width_m
        Half width of the level top or bed, metres.
    lift_m
        Height of the top above the averaged ground, metres; below 0: a cutting or stream bed.
    slope_m
        Width of each flank, metres.
    """

    line: Floats
    half_width_m: float
    lift_m: float
    slope_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Pad:
    """A level place, such as under a house."""

    east_m: float
    north_m: float
    radius_m: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Relief:
    """Heights of a landscape: noise or measured heights, with earthworks.

    Attributes
    ----------
    seed
        Seed of the noise.
    local_m
        Height of rises near the origin, metres.
    hills_m
        Height of hills far from the origin, metres.
    courses
        Earthworks along lines, in the order in which they are made.
    pads
        Level places, made last.
    measured
        Heights in place of noise; None: there are none.
    """

    seed: int
    local_m: float
    hills_m: float
    courses: Sequence[Course] = ()
    pads: Sequence[Pad] = ()
    measured: HeightFunction | None = None

    def heights(self, frame: GridFrame) -> Floats:
        """Return the heights of the points of `frame`, (rows * columns,)."""
        places = frame.places()
        ground = self._natural(frame).ravel()
        for course in self.courses:
            _build(ground, places, course, self._along(course))
        for pad in self.pads:
            self._level(ground, places, pad)
        return ground

    def _natural(self, frame: GridFrame) -> Floats:
        if self.measured is not None:
            return self.measured(frame).reshape(frame.rows, frame.columns)
        octave = round(np.log2(frame.cell_m * CM_PER_M))
        x0, y0 = round(frame.west_m / frame.cell_m), round(frame.south_m / frame.cell_m)
        window = Window(x0, y0, x0 + frame.columns, y0 + frame.rows)
        local = fractal_at(
            self.seed + 71, dict(enumerate(RELIEF.local, 7)), octave, window
        ).astype(float)
        hills = fractal_at(
            self.seed + 72, dict(enumerate(RELIEF.hills, 14)), octave, window
        ).astype(float)
        east = frame.west_m + frame.cell_m * np.arange(frame.columns)[None]
        north = frame.south_m + frame.cell_m * np.arange(frame.rows)[:, None]
        rise = _smooth(
            (np.hypot(east, north) - RELIEF.plain_m) / (RELIEF.hilly_m - RELIEF.plain_m)
        )
        return np.asarray(self.local_m * local + self.hills_m * rise * (0.45 + 0.8 * hills))

    def _natural_at(self, places: Floats) -> Floats:
        """Return heights without earthworks, from a grid around the places."""
        cell = RELIEF.cell_m
        low = np.floor(places.min(axis=0) / cell) - 2
        high = np.ceil(places.max(axis=0) / cell) + 2
        columns, rows = (high - low).astype(int) + 1
        frame = GridFrame(
            west_m=float(low[0] * cell), south_m=float(low[1] * cell), cell_m=cell,
            columns=int(columns), rows=int(rows),
        )  # fmt: skip
        grid = self._natural(frame)
        x, y = (places[:, 0] - frame.west_m) / cell, (places[:, 1] - frame.south_m) / cell
        column, row = x.astype(int), y.astype(int)
        u, v = x - column, y - row
        lower = grid[row, column] * (1 - u) + grid[row, column + 1] * u
        upper = grid[row + 1, column] * (1 - u) + grid[row + 1, column + 1] * u
        return np.asarray(lower * (1 - v) + upper * v)

    def _along(self, course: Course) -> tuple[Floats, Floats]:
        """Return places along a course and its averaged heights there."""
        line = resampled(course.line, RELIEF.course_step_m)
        heights = self._natural_at(line)
        reach = round(0.5 * RELIEF.levelled_m / RELIEF.course_step_m)
        padded = np.pad(heights, reach, mode='edge')
        window = np.hanning(2 * reach + 3)[1:-1]
        return line, np.convolve(padded, window / window.sum(), 'valid') + course.lift_m

    def _level(self, ground: Floats, places: Floats, pad: Pad) -> None:
        middle = np.array([[pad.east_m, pad.north_m]])
        distance = np.linalg.norm(places - middle, axis=1)
        share = 1.0 - _smooth((distance - pad.radius_m) / (0.6 * pad.radius_m))
        height = float(self._natural_at(middle)[0])
        ground += share * (height - ground)


def _build(ground: Floats, places: Floats, course: Course, profile: tuple[Floats, Floats]) -> None:
    line, heights = profile
    reach = course.half_width_m + course.slope_m
    low, high = line.min(axis=0) - reach, line.max(axis=0) + reach
    is_near = np.all((places >= low) & (places <= high), axis=1)
    found = nearest_on(line, places[is_near])
    top = np.interp(found.along_m, run_of(line), heights)
    share = 1.0 - _smooth((found.distance_m - course.half_width_m) / course.slope_m)
    ground[is_near] += share * (top - ground[is_near])


def _smooth(share: Floats) -> Floats:
    """Return 0 below 0, 1 above 1 and a smooth step between."""
    t = np.clip(share, 0.0, 1.0)
    return np.asarray(t * t * (3.0 - 2.0 * t))
