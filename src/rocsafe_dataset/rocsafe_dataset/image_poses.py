# SPDX-License-Identifier: Apache-2.0
"""Where each picture is taken from: drawn from the seed and the number of the picture alone."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_dataset.ground_splits import GroundSplits
from rocsafe_dataset.options import SPLITS, DatasetOptions
from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_scene.ground.terrain import Terrain
from rocsafe_scene.mesh.mesh import Floats

# Drawn again until at most this share of the ground in view belongs to other splits.
_MOST_FOREIGN = 0.1
_ATTEMPTS = 120
# Ground farther than this, metres, is too small in the picture to learn from.
_REACH_M = 120.0
_NADIR_DEG = 6.0
_OBLIQUE_DEG = (25.0, 75.0)
# The camera keeps off things by this, metres.
_CLEARANCE_M = 2.5
# Of the pictures, those that aim at a thing rather than anywhere.
_AIMED_SHARE = 0.6
_AIM_STD_M = 7.0


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImagePose:
    """One picture to be taken.

    Attributes
    ----------
    number : of the picture, from 0.
    split : it belongs to.
    position : of the camera, east, north, up, (3,).
    rotation : columns right, down, ahead, (3, 3).
    foreign_share : of the ground seen within 120 m, what belongs to other splits.
    """

    number: int
    split: str
    position: Floats
    rotation: Floats
    foreign_share: float

    @property
    def name(self) -> str:
        """Of its files."""
        return f'{self.number:06d}'


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Site:
    """What takes are drawn over.

    Attributes
    ----------
    terrain : to fly above.
    places : of the splits.
    aims : (east, north) of things worth a look, (n, 2).
    boxes : bounds of all that one could fly into, (n, 2, 3).
    """

    terrain: Terrain
    places: GroundSplits
    aims: Floats
    boxes: Floats


def split_of(number: int, options: DatasetOptions) -> int:
    """Return the split of a picture: evenly spread over the numbers, in the shares asked for."""
    golden = (number * 0.6180339887498949 + 0.5) % 1.0
    return int(np.searchsorted(np.cumsum(options.splits)[:-1], golden, side='right'))


def draw_pose(number: int, site: Site, options: DatasetOptions) -> ImagePose:
    """Return how picture `number` is taken."""
    rng = np.random.default_rng([options.seed, 21, number])
    split = split_of(number, options)
    best: ImagePose | None = None
    for _ in range(_ATTEMPTS):
        position, rotation = _pose(rng, site, options, split)
        if _is_inside_something(position, site.boxes):
            continue
        foreign = _foreign_share(position, rotation, site, options.lens, split)
        if best is None or foreign < best.foreign_share:
            best = ImagePose(
                number=number, split=SPLITS[split], position=position, rotation=rotation,
                foreign_share=foreign,
            )  # fmt: skip
        if foreign <= _MOST_FOREIGN:
            break
    assert best is not None  # noqa: S101 - the sky is never full
    return best


def _pose(
    rng: np.random.Generator, site: Site, options: DatasetOptions, split: int
) -> tuple[Floats, Floats]:
    target = _target(rng, site, split)
    height = float(np.exp(rng.uniform(*np.log(options.height_m))))
    yaw = float(rng.uniform(-math.pi, math.pi))
    if rng.uniform() < options.nadir_share:
        pitch, roll = np.radians(rng.uniform(-_NADIR_DEG, _NADIR_DEG, 2)).tolist()
        eye = target
    else:
        down = math.radians(float(rng.uniform(*_OBLIQUE_DEG)))
        # Negative pitch raises the nose, and the view of a nadir camera with it.
        pitch, roll = down - 0.5 * math.pi, 0.0
        back = height / math.tan(down)
        eye = target - back * np.array([math.cos(yaw), math.sin(yaw)])
    up = float(site.terrain.height_at(eye[None])[0]) + height
    return np.array([*eye, up]), rotation_enu_from_optical(yaw, pitch, roll)


def _target(rng: np.random.Generator, site: Site, split: int) -> Floats:
    """Return (east, north) of what a picture aims at, on the ground of its split."""
    aims = site.aims[site.places.split_of(site.aims) == split] if len(site.aims) else site.aims
    if len(aims) and rng.uniform() < _AIMED_SHARE:
        return np.asarray(rng.choice(aims) + rng.normal(0.0, _AIM_STD_M, 2))
    corner = rng.choice(site.places.blocks_of(split))
    return np.asarray(corner + rng.uniform(0.0, 1.0, 2) * site.places.block_m)


def _is_inside_something(position: Floats, boxes: Floats) -> bool:
    low, high = boxes[:, 0] - _CLEARANCE_M, boxes[:, 1] + _CLEARANCE_M
    return bool(np.any(np.all((position >= low) & (position <= high), axis=1)))


def _foreign_share(
    position: Floats, rotation: Floats, site: Site, lens: PinholeCamera, split: int
) -> float:
    """Return the share of level ground in view that belongs to other splits."""
    u, v = np.meshgrid(
        np.linspace(0, lens.image_width_px - 1, 12), np.linspace(0, lens.image_height_px - 1, 9)
    )
    pixels = np.stack([u.ravel(), v.ravel(), np.ones(u.size)])
    rays = np.linalg.solve(lens.matrix, pixels).T @ rotation.T
    ground = float(site.terrain.height_at(position[None, :2])[0])
    steepness = np.minimum(rays[:, 2], -1e-6)
    run = (ground - position[2]) / steepness
    places = position[:2] + rays[:, :2] * run[:, None]
    near = np.hypot(*(places - position[:2]).T) < _REACH_M
    found = site.places.split_of(places[near])
    return float(np.mean((found != split) & (found >= 0))) if near.any() else 0.0
