# SPDX-License-Identifier: Apache-2.0
"""Random poses of the images; each depends only on the seed and the number of the image."""

import math
from dataclasses import dataclass

import numpy as np

from rocsafe_dataset.options import SPLITS, DatasetOptions
from rocsafe_dataset.poses.ground_splits import GroundSplits
from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_scene.ground.terrain import Terrain
from rocsafe_scene.mesh.mesh import Floats


@dataclass(frozen=True, slots=True, kw_only=True)
class PoseOptions:
    """Tuning of the poses; the values are chosen so that aimed objects are seen whole.

    Attributes
    ----------
    largest_foreign_share
        A pose is drawn again until at most this share of the visible ground is of other splits.
    attempts
        Limit of the poses drawn for one image; the best one is taken.
    reach_m
        Ground farther than this is too small in the image to count, metres.
    nadir_deg
        Largest pitch and roll of images that look straight down, degrees.
    oblique_deg
        Least and largest angle of oblique images below the horizon, degrees.
    clearance_m
        Least distance of the camera from objects, metres.
    aimed_share
        Share of the images that are aimed at an object.
    aim_std_m
        Standard deviation of the aim around that object, metres.
    """

    largest_foreign_share: float = 0.1
    attempts: int = 120
    reach_m: float = 120.0
    nadir_deg: float = 6.0
    oblique_deg: tuple[float, float] = (25.0, 75.0)
    clearance_m: float = 2.5
    aimed_share: float = 0.6
    aim_std_m: float = 7.0


POSES = PoseOptions()


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ImagePose:
    """Pose of the camera for one image.

    Attributes
    ----------
    number
        Number of the image, from 0.
    split
        Split to which the image belongs.
    position : (3,)
        Position of the camera: east, north, up, metres.
    rotation : (3, 3)
        Rotation of the camera: columns right, down, ahead.
    foreign_share
        Share of the visible ground within 120 m that belongs to other splits.
    """

    number: int
    split: str
    position: Floats
    rotation: Floats
    foreign_share: float

    @property
    def name(self) -> str:
        """Name of its files, without suffix."""
        return f'{self.number:06d}'


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Site:
    """The place over which poses are drawn.

    Attributes
    ----------
    terrain
        Terrain below the cameras.
    places
        Splits of the ground.
    aims : (n, 2)
        East and north of the objects that images are aimed at, metres.
    boxes : (n, 2, 3)
        Bounds of the objects that a camera must not be inside of.
    """

    terrain: Terrain
    places: GroundSplits
    aims: Floats
    boxes: Floats


def split_of(number: int, options: DatasetOptions) -> int:
    """Return the split of an image; splits are spread evenly over the numbers by their shares."""
    golden = (number * 0.6180339887498949 + 0.5) % 1.0
    return int(np.searchsorted(np.cumsum(options.splits)[:-1], golden, side='right'))


def draw_pose(number: int, site: Site, options: DatasetOptions) -> ImagePose:
    """Return the pose of image `number`."""
    rng = np.random.default_rng([options.seed, 21, number])
    split = split_of(number, options)
    best: ImagePose | None = None
    for _ in range(POSES.attempts):
        position, rotation = _pose(rng, site, options, split)
        if _is_inside_something(position, site.boxes):
            continue
        foreign = _foreign_share(position, rotation, site, options.lens, split)
        if best is None or foreign < best.foreign_share:
            best = ImagePose(
                number=number, split=SPLITS[split], position=position, rotation=rotation,
                foreign_share=foreign,
            )  # fmt: skip
        if foreign <= POSES.largest_foreign_share:
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
        pitch, roll = np.radians(rng.uniform(-POSES.nadir_deg, POSES.nadir_deg, 2)).tolist()
        eye = target
    else:
        down = math.radians(float(rng.uniform(*POSES.oblique_deg)))
        # Negative pitch raises the nose, and with it the view of a nadir camera.
        pitch, roll = down - 0.5 * math.pi, 0.0
        back = height / math.tan(down)
        eye = target - back * np.array([math.cos(yaw), math.sin(yaw)])
    up = float(site.terrain.height_at(eye[None])[0]) + height
    return np.array([*eye, up]), rotation_enu_from_optical(yaw, pitch, roll)


def _target(rng: np.random.Generator, site: Site, split: int) -> Floats:
    """Return (east, north) of the place at which an image is aimed, on the ground of its split."""
    aims = site.aims[site.places.split_of(site.aims) == split] if len(site.aims) else site.aims
    if len(aims) and rng.uniform() < POSES.aimed_share:
        return np.asarray(rng.choice(aims) + rng.normal(0.0, POSES.aim_std_m, 2))
    corner = rng.choice(site.places.blocks_of(split))
    return np.asarray(corner + rng.uniform(0.0, 1.0, 2) * site.places.block_m)


def _is_inside_something(position: Floats, boxes: Floats) -> bool:
    low, high = boxes[:, 0] - POSES.clearance_m, boxes[:, 1] + POSES.clearance_m
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
    near = np.hypot(*(places - position[:2]).T) < POSES.reach_m
    found = site.places.split_of(places[near])
    return float(np.mean((found != split) & (found >= 0))) if near.any() else 0.0
