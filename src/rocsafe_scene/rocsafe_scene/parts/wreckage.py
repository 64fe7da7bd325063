# SPDX-License-Identifier: Apache-2.0
"""Damaged rails and sleepers, and dry stone walls."""

import math

import numpy as np

from rocsafe_scene.mesh.lines import resampled, run_of
from rocsafe_scene.mesh.mesh import Floats, Mesh, joined
from rocsafe_scene.mesh.shapes import ball, box, strip
from rocsafe_scene.mesh.surfaces import Surface
from rocsafe_scene.parts.clutter import GAUGE_M, RAIL_SECTION


def bent_rails(rng: np.random.Generator, course: Floats, sway_m: float = 1.8) -> Mesh:
    """Return both rails of a torn track along `course` (k, 3), bent aside and up."""
    line = resampled(course, 0.8)
    share = np.linspace(0.0, 1.0, len(line))
    ahead = np.gradient(line[:, :2], axis=0)
    left = np.column_stack([-ahead[:, 1], ahead[:, 0]])
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    parts = []
    for side in (-1.0, 1.0):
        waves = rng.uniform(1.5, 3.5), rng.uniform(0.0, 3.0)
        swing = sway_m * np.sin(math.pi * share) * np.sin(waves[0] * math.pi * share + waves[1])
        lift = 0.5 * np.sin(math.pi * share) ** 2 * np.abs(np.sin(5.0 * share + waves[1]))
        aside = side * 0.5 * GAUGE_M + swing
        rail = line + np.column_stack([left * aside[:, None], lift])
        parts.append(strip(rail, RAIL_SECTION))
    return joined(parts).painted((128, 104, 88), Surface.RUSTY)


def torn_sleepers(rng: np.random.Generator, course: Floats, kept: float = 0.75) -> Mesh:
    """Return scattered sleepers along `course` (k, 3); the share `kept` lies in place."""
    run = run_of(course)
    parts = []
    for along in np.arange(0.3, run[-1], 0.65):
        place = np.array([np.interp(along, run, course[:, k]) for k in range(3)])
        if rng.uniform() > kept:
            continue
        yaw = math.degrees(math.atan2(*(course[-1] - course[0])[[1, 0]])) + rng.normal(0.0, 22.0)
        pitch, roll = rng.normal(0.0, 7.0, 2).tolist()
        aside = rng.normal(0.0, 0.55, 2)
        board = box(0.25, 2.6, 0.2, 0.02).turned(float(yaw), pitch, roll)
        tone = int(rng.normal(96.0, 14.0))
        board = board.moved(place[0] + aside[0], place[1] + aside[1], place[2] - 0.1)
        parts.append(board.painted((tone, round(0.9 * tone), round(0.78 * tone)), Surface.WOOD))
    return joined(parts or [box(0.25, 2.6, 0.2).moved(*course[0])])


def stone_wall(rng: np.random.Generator, course: Floats, height_m: float = 1.1) -> Mesh:
    """Return a dry stone wall along `course` (k, 3)."""
    line = resampled(course, 0.32)
    pebble, parts = ball(1.0, 7), []
    for place in line:
        for layer in range(max(1, round(height_m / 0.28))):
            size = rng.uniform(0.8, 1.25, 3) * np.array([0.22, 0.24, 0.17])
            tone = int(rng.normal(142.0, 20.0))
            aside = rng.normal(0.0, 0.05, 2)
            stone = pebble.scaled(*size).turned(float(rng.uniform(0, 360)))
            stone = stone.moved(place[0] + aside[0], place[1] + aside[1], place[2] + 0.28 * layer)
            parts.append(stone.painted((tone, tone - 2, tone - 12), Surface.STONE))
    return joined(parts)
