# SPDX-License-Identifier: Apache-2.0
"""Tilts and ties of photographs that look in any direction.

Elsewhere a photograph looks down but for a few degrees. Here structure from motion finds how each
one is turned against the ground; its matched points near the ground become ties.
"""

import dataclasses
import itertools
import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from scipy.spatial import cKDTree

from rocsafe_geo.arrays import FloatArray
from rocsafe_mapping.alignment.matching.features import Features, Gray, sift_features
from rocsafe_mapping.alignment.matching.pair_matching import Pair, most_alike
from rocsafe_mapping.alignment.model.photo import Photo, Pose
from rocsafe_mapping.alignment.structure.epipolar import Key, Link, linked, tracks_of
from rocsafe_mapping.alignment.structure.growth import Cameras, Grown, all_grown
from rocsafe_mapping.alignment.structure.levelled import levelled
from rocsafe_mapping.alignment_options import AlignmentOptions, StructureOptions

METHOD = 'sift-structure'


@dataclass(frozen=True, slots=True, kw_only=True)
class Structure:
    """What structure from motion found.

    Attributes
    ----------
    photos
        With their tilts, by name.
    pairs
        Ties between them, on or near the ground.
    scenes
        Poses by name, those of each scene fit each other but lie anywhere; also of photographs
        that show no ground nearby.
    """

    photos: Mapping[str, Photo]
    pairs: tuple[Pair, ...]
    scenes: tuple[Mapping[str, Pose], ...]


def find_structure(
    photos: Mapping[str, Photo], read_gray: Callable[[str], Gray], options: AlignmentOptions
) -> Structure | None:
    """Return tilts and ties of photographs from structure from motion; None if it finds none."""
    names = tuple(sorted(photos))
    chosen = [photos[name] for name in names]
    structure = options.structure
    features_options = dataclasses.replace(
        options.features, count=structure.count, search_side_px=structure.search_side_px
    )
    features = [sift_features(read_gray(name), features_options) for name in names]
    offsets = [_offsets_px(photo, f) for photo, f in zip(chosen, features, strict=True)]
    links = _links(chosen, features, offsets, options)
    tracks = tracks_of(links, [len(found) for found in features])
    focal = np.array([photo.camera.fx_px for photo in chosen])
    share = max(photo.focal_std_share for photo in chosen)
    lens_std = np.array([share, *options.adjustment.radial_std]) if share else np.zeros(3)
    scenes = []
    for grown in all_grown(links, tracks, Cameras(offsets, focal, lens_std), structure):
        scene = levelled(grown.scene, structure)
        if scene is not None:
            scenes.append(dataclasses.replace(grown, scene=scene))
    if not scenes:
        return None
    pairs = [pair for grown in scenes for pair in _ties(chosen, grown, structure)]
    # All look through one lens: each scene tells of it as much as it has sightings.
    focal_factor = math.exp(
        np.average(
            [grown.scene.lens[0] for grown in scenes],
            weights=[len(grown.seen.photos) for grown in scenes],
        )
    )
    return Structure(
        photos={
            name: photo
            for grown in scenes
            for name, photo in _tilted(chosen, grown, focal_factor, structure).items()
        },
        pairs=tuple(sorted(pairs, key=lambda pair: (pair.first, pair.second))),
        scenes=tuple(_poses(names, grown) for grown in scenes),
    )


def _poses(names: Sequence[str], grown: Grown) -> dict[str, Pose]:
    scene = grown.scene
    return {
        names[number]: Pose(centre=centre, rotation=rotation)
        for number, centre, rotation in zip(
            grown.names, scene.centres, scene.rotations, strict=True
        )
    }


def _offsets_px(photo: Photo, features: Features) -> FloatArray:
    """Return the features' pixels less the principal point, rows scaled like columns."""
    camera = photo.camera
    offsets: FloatArray = features.points_px - np.array([camera.cx_px, camera.cy_px])
    return offsets * (1.0, camera.fx_px / camera.fy_px)


def _links(
    photos: Sequence[Photo],
    features: Sequence[Features],
    offsets: Sequence[FloatArray],
    options: AlignmentOptions,
) -> dict[Key, Link]:
    """Return what ties photographs: of the nearest fixes, and those that look most alike."""
    rays = [part / photo.camera.fx_px for part, photo in zip(offsets, photos, strict=True)]
    links = {}
    for key in _candidates(photos, features, options):
        one, other = key
        link = linked(
            features[one], features[other], (rays[one], rays[other]),
            photos[one].camera.fx_px, options.matching, options.structure,
        )  # fmt: skip
        if link is not None:
            links[key] = link
    return links


def _candidates(
    photos: Sequence[Photo], features: Sequence[Features], options: AlignmentOptions
) -> list[Key]:
    structure = options.structure
    if len(photos) <= structure.all_up_to:
        return list(itertools.combinations(range(len(photos)), 2))
    located = [number for number, photo in enumerate(photos) if photo.is_located]
    keys = set()
    if len(located) > structure.neighbours:
        places = np.array([photos[number].prior.centre[:2] for number in located])
        _, near = cKDTree(places).query(places, structure.neighbours + 1)
        pairs = {(located[a], located[b]) for a, row in enumerate(near.tolist()) for b in row}
        keys = {(min(pair), max(pair)) for pair in pairs if len(set(pair)) > 1}
    few = {n: f.first(options.neighbours.alike_features) for n, f in enumerate(features)}
    lost = set(few) - (set(located) if keys else set())
    return sorted(keys | most_alike(few, lost, structure.neighbours, options.matching))


def _tilted(
    photos: Sequence[Photo], grown: Grown, focal_factor: float, options: StructureOptions
) -> dict[str, Photo]:
    """Return the photographs with the rotations that were found, north being unknown."""
    found = {}
    scene = grown.scene
    for number, rotation, centre in zip(grown.names, scene.rotations, scene.centres, strict=True):
        photo = photos[number]
        camera = dataclasses.replace(
            photo.camera,
            fx_px=photo.camera.fx_px * focal_factor,
            fy_px=photo.camera.fy_px * focal_factor,
        )
        height_m = photo.prior.centre[2] if photo.has_height else centre[2]
        found[photo.name] = dataclasses.replace(
            photo,
            camera=camera,
            prior=Pose(centre=np.array([*photo.prior.centre[:2], height_m]), rotation=rotation),
            focal_std_share=min(photo.focal_std_share, options.focal_std_share),
            tilt_std_rad=options.tilt_std_rad,
            yaw_std_rad=math.pi,
        )
    return found


def _ties(photos: Sequence[Photo], grown: Grown, options: StructureOptions) -> list[Pair]:
    """Return the sightings of points near the ground as ties of two photographs each."""
    scene, seen = grown.scene, grown.seen
    centres, points = scene.centres[seen.photos], scene.points[seen.points]
    drop = np.maximum(centres[:, 2] - points[:, 2], 1e-9)
    reach = np.linalg.norm((points - centres)[:, :2], axis=1) / drop
    is_used = (np.abs(points[:, 2]) < options.ground_share * centres[:, 2]) & (
        reach < options.longest_reach
    )
    pixels: dict[int, dict[int, FloatArray]] = {}
    for photo, point, offset in zip(
        seen.photos[is_used], seen.points[is_used], seen.offsets_px[is_used], strict=True
    ):
        camera = photos[grown.names[photo]].camera
        pixel = offset * (1.0, camera.fy_px / camera.fx_px) + (camera.cx_px, camera.cy_px)
        pixels.setdefault(int(photo), {})[int(point)] = pixel
    pairs = []
    for one, other in itertools.combinations(sorted(pixels), 2):
        shared = sorted(pixels[one].keys() & pixels[other].keys())
        if len(shared) >= options.least_ties:
            every = -(-len(shared) // options.most_ties)
            shared = shared[::every]
            pairs.append(_pair(photos, grown, (one, other), shared, pixels))
    return pairs


def _pair(
    photos: Sequence[Photo],
    grown: Grown,
    ends: Key,
    shared: Sequence[int],
    pixels: Mapping[int, Mapping[int, FloatArray]],
) -> Pair:
    one, other = sorted(ends, key=lambda at: photos[grown.names[at]].name)
    return Pair(
        first=photos[grown.names[one]].name,
        second=photos[grown.names[other]].name,
        first_px=np.array([pixels[one][point] for point in shared]),
        second_px=np.array([pixels[other][point] for point in shared]),
        is_held_out=np.arange(len(shared)) % 5 == 4,
        method=METHOD,
    )
