# SPDX-License-Identifier: Apache-2.0
"""Compares the stated error of maps with the true one, on drawn surveys with exact truth.

Each survey is drawn from its seed: size, overlap, flying height, altitude of the ground, whether
tags tell the height above the ground, scatter and drift of the fixes, what they claim, tilt, and
the error of the focal length. Seeds are in three parts: develop (1000 up), validate (2000 up),
unopened (9000 up). ``--hard`` draws what else goes wrong as well, each in a part of the
surveys: take-off above or below the ground, a rolling shutter, strips flown back and forth without
a yaw, a camera that looks ahead, dark corners, exposures that jump.
"""

import argparse
import dataclasses
import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import cv2
import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import (
    PinholeCamera,
    ground_homography,
    quaternion_of_rotation,
    rotation_enu_from_optical,
)
from rocsafe_geo.position import GeoPosition
from rocsafe_mapping.alignment.model.photo import footprint
from rocsafe_mapping.errors import PlacementError
from rocsafe_mapping.mosaic.map_alignment import Alignment
from rocsafe_mapping.mosaic.mapmaker import Mapmaker, MapOptions, Shot
from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord
from rocsafe_mapping.products.quality import violations

PARTS = {'develop': 1000, 'validate': 2000, 'unopened': 9000}
CAMERA = PinholeCamera(math.radians(60.0), 400, 300)
CLAIMED_M = 2.5


@dataclass(frozen=True, slots=True, kw_only=True)
class Hardship:
    """What goes wrong beside noise; all of it is off by default.

    Attributes
    ----------
    take_off
        Height of the place of take-off above the surveyed ground, over the flying height: told
        heights are too low by it.
    rolling
        Way flown while a photograph is read, over the footprint's width.
    is_turning, ahead_rad
        Whether strips are flown back and forth, without a yaw told; by how much the camera looks
        ahead.
    is_ahead_told
        Whether the tags tell that.
    dark_corners, exposure
        Share of the light that is missing in the corners; standard deviation of the logarithm of
        the exposures.
    """

    take_off: float = 0.0
    rolling: float = 0.0
    is_turning: bool = False
    ahead_rad: float = 0.0
    is_ahead_told: bool = True
    dark_corners: float = 0.0
    exposure: float = 0.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Survey:
    """What was drawn.

    Attributes
    ----------
    rows, columns
        Of the grid of viewpoints.
    overlap
        Of neighbouring photographs, both ways, as a share of the image's side.
    height_m, ground_m
        Flying height above the ground, and the ground's altitude.
    has_height
        Whether the tags tell the height above the ground.
    fix_m, drift
        Standard deviation of the fixes, and the correlation of each with the one before.
    tilt_rad, focal_off
        Standard deviation of the camera's tilt; error of the focal length over itself.
    hardship
        What else is wrong.
    """

    rows: int
    columns: int
    overlap: float
    height_m: float
    ground_m: float
    has_height: bool
    fix_m: float
    drift: float
    tilt_rad: float
    focal_off: float
    hardship: Hardship = field(default_factory=Hardship)


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What came of a survey.

    Attributes
    ----------
    placed
        Share of the photographs placed by features.
    true_m, stated_m
        RMS error of the corners of photographs on the ground, and the stated one.
    scale
        Size of the map over the true one.
    is_georeferenced, cpu_s
        Whether the map calls itself so; cost.
    """

    placed: float
    true_m: float
    stated_m: float
    scale: float
    is_georeferenced: bool
    cpu_s: float


def hardship(seed: int) -> Hardship:
    """Return what goes wrong in the survey of a seed."""
    rng = np.random.default_rng([seed, 16])

    def sometimes(low: float, high: float) -> float:
        value = rng.uniform(low, high)
        return float(value) if rng.random() < 0.35 else 0.0

    return Hardship(
        take_off=sometimes(-0.5, 0.3),
        rolling=sometimes(0.002, 0.02),
        is_turning=bool(rng.random() < 0.35),
        ahead_rad=sometimes(math.radians(8.0), math.radians(30.0)),
        is_ahead_told=bool(rng.random() < 0.5),
        dark_corners=sometimes(0.1, 0.5),
        exposure=sometimes(0.05, 0.3),
    )


def drawn(seed: int, *, is_hard: bool = False) -> Survey:
    """Return the survey of a seed."""
    rng = np.random.default_rng([seed, 14])
    return Survey(
        rows=int(rng.integers(2, 6)),
        columns=int(rng.integers(3, 7)),
        overlap=rng.uniform(0.35, 0.7),
        height_m=rng.uniform(20.0, 90.0),
        ground_m=rng.uniform(0.0, 2500.0),
        has_height=bool(rng.integers(2)),
        fix_m=math.exp(rng.uniform(math.log(0.3), math.log(12.0))),
        drift=float(rng.choice([0.0, 0.0, 0.6, 0.9])),
        tilt_rad=math.radians(rng.uniform(0.5, 5.0)),
        focal_off=rng.normal(0.0, 0.03),
        hardship=hardship(seed) if is_hard else Hardship(),
    )


def viewpoints(survey: Survey) -> FloatArray:
    """Return where the photographs are taken, (east, north) in metres, shape (n, 2)."""
    _, step_m = _steps_m(survey)
    rows, steps = np.divmod(np.arange(survey.rows * survey.columns), survey.columns)
    columns = np.where(rows % 2, survey.columns - 1 - steps, steps)
    middle = (survey.columns - 1) / 2, (survey.rows - 1) / 2
    places: FloatArray = step_m * np.column_stack([columns - middle[0], middle[1] - rows])
    return places


def _steps_m(survey: Survey) -> tuple[float, FloatArray]:
    """Return the width of a footprint, and the steps between viewpoints (east, north)."""
    footprint_m = 2.0 * survey.height_m * math.tan(CAMERA.horizontal_fov_rad / 2.0)
    return footprint_m, np.array([footprint_m, 0.75 * footprint_m]) * (1.0 - survey.overlap)


def flown(survey: Survey, seed: int) -> tuple[list[Shot], list[FloatArray], LocalFrame]:
    """Return the photographs of a survey, the true corners of each, (4, 2), and the true frame."""
    rng = np.random.default_rng([seed, 15])
    frame = LocalFrame(GeoPosition(rng.uniform(-60.0, 60.0), 10.0, survey.ground_m))
    hard, light = survey.hardship, np.random.default_rng([seed, 17])
    footprint_m, step_m = _steps_m(survey)
    side_m = float(max(step_m[0] * survey.columns, step_m[1] * survey.rows) + 2.5 * footprint_m)
    ground = _ground(rng, side_m, survey.height_m / 350.0)
    off: FloatArray = np.zeros(2)
    shots, truths = [], []
    for number, place in enumerate(viewpoints(survey)):
        centre = np.array([*place, survey.height_m + rng.normal(0.0, 0.5)])
        is_back = hard.is_turning and number // survey.columns % 2
        yaw = -math.pi / 2 if is_back else math.pi / 2
        tilts = rng.normal(0.0, survey.tilt_rad, 2) - (hard.ahead_rad, 0.0)
        rotation = rotation_enu_from_optical(yaw, *tilts)
        way_m = hard.rolling * footprint_m * np.array([math.cos(yaw), math.sin(yaw)])
        fresh = rng.normal(0.0, survey.fix_m, 2)
        off = fresh if number == 0 else (
            survey.drift * off + math.sqrt(1.0 - survey.drift**2) * fresh
        )  # fmt: skip
        told = centre + np.array([*off, rng.normal(0.0, 0.5 * survey.fix_m)])
        picture = _seen(ground, side_m, centre, rotation, way_m)
        picture = _lit(picture, hard.dark_corners, math.exp(light.normal(0.0, hard.exposure)))
        shots.append(_shot(survey, number, frame, told, picture, yaw))
        truths.append(_corners(centre, rotation, way_m))
    return shots, truths, frame


def tried(survey: Survey, seed: int) -> Outcome:
    """Map a survey."""
    shots, truths, frame = flown(survey, seed)
    cpu = time.process_time()
    maker = Mapmaker(MapOptions())
    maker.add_all(shots)
    alignment = maker.align()
    cpu = time.process_time() - cpu
    found = np.concatenate([_found(maker, alignment, shot.name, frame) for shot in shots])
    true = np.concatenate(truths)
    names = [shot.name for shot in shots]
    stated = np.array([alignment.errors_m.get(name, alignment.error_m(name)) for name in names])
    spread = true - true.mean(axis=0)
    size = float(np.sum(spread * (found - found.mean(axis=0))) / np.sum(spread**2))
    return Outcome(
        placed=len(maker.block.state.poses) / len(shots),
        true_m=float(np.sqrt(np.mean(np.sum((found - true) ** 2, axis=1)))),
        stated_m=float(np.sqrt(np.mean(stated**2))),
        scale=size,
        is_georeferenced=not violations(alignment, maker.block.state),
        cpu_s=cpu,
    )


def _ground(rng: np.random.Generator, side_m: float, pixel_m: float) -> FloatArray:
    """Return a picture of textured ground, north up, of that pixel."""
    side = min(int(side_m / pixel_m), 3000)
    ground = np.zeros((side, side), np.float32)
    for cells in (8, 40, 160, 480):
        rough = rng.normal(0.0, 1.0, (cells, cells)).astype(np.float32)
        ground += cv2.resize(rough, (side, side), interpolation=cv2.INTER_CUBIC)
    gray = np.clip(120.0 + 30.0 * ground, 0, 255).astype(np.uint8)
    return np.dstack([gray] * 3)


def _seen(
    ground: FloatArray,
    side_m: float,
    centre: FloatArray,
    rotation: FloatArray,
    way_m: FloatArray,
) -> FloatArray:
    """Return what the camera sees of the ground, moving by `way_m` while its rows are read."""
    pixel_m = side_m / len(ground)
    size = (CAMERA.image_width_px, CAMERA.image_height_px)
    columns, rows = np.meshgrid(np.arange(size[0], dtype=float), np.arange(size[1], dtype=float))
    pixels = np.stack([columns, rows, np.ones_like(rows)], axis=-1)
    places = pixels @ np.linalg.inv(ground_homography(CAMERA, centre, rotation)).T
    places = places[..., :2] / places[..., 2:]
    places += (rows[..., np.newaxis] / size[1] - 0.5) * way_m
    at = (places * (1.0, -1.0) + side_m / 2.0) / pixel_m
    seen: FloatArray = cv2.remap(
        ground, at.astype(np.float32), None, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REFLECT
    )
    return seen


def _lit(picture: FloatArray, dark_corners: float, gain: float) -> FloatArray:
    """Return a picture whose corners are dark, with another exposure."""
    height, width = picture.shape[:2]
    down, right = np.mgrid[-1.0 : 1.0 : height * 1j, -1.0 : 1.0 : width * 1j]
    light = gain * (1.0 - dark_corners * (down**2 + right**2) / 2.0)
    lit: FloatArray = np.clip(picture * light[..., np.newaxis], 0, 255).astype(np.uint8)
    return lit


def _shot(
    survey: Survey,
    number: int,
    frame: LocalFrame,
    told: FloatArray,
    picture: FloatArray,
    yaw_rad: float,
) -> Shot:
    """Return a photograph with the record that its tags would give."""
    place = frame.position_of(told)
    jpeg = bytes(cv2.imencode('.jpg', picture, [cv2.IMWRITE_JPEG_QUALITY, 92])[1])
    camera = Intrinsics.of_pinhole(CAMERA)
    focal_px = camera.fx_px * (1.0 + survey.focal_off)
    hard = survey.hardship
    tilt_std = survey.tilt_rad if hard.is_ahead_told else math.radians(6.0)
    yaw_std = math.pi if hard.is_turning else math.sqrt(0.03)
    turn = tilt_std**2
    looks = rotation_enu_from_optical(
        math.pi / 2 if hard.is_turning else yaw_rad, -hard.ahead_rad * hard.is_ahead_told
    )
    height_m = float(told[2]) - hard.take_off * survey.height_m
    record = ShotRecord(
        shot_id=f'rav1-{number:05d}',
        vehicle='rav1',
        sequence=number,
        viewpoint_id=number,
        time_ns=(number + 1) * 3 * 10**9,
        latitude_deg=place.latitude_deg,
        longitude_deg=place.longitude_deg,
        altitude_m=place.altitude_m,
        position_covariance_m2=tuple((np.eye(3) * CLAIMED_M**2).ravel().tolist()),
        height_agl_m=height_m if survey.has_height else math.nan,
        orientation_xyzw=tuple(quaternion_of_rotation(looks).tolist()),
        orientation_covariance_rad2=(turn, 0.0, 0.0, 0.0, turn, 0.0, 0.0, 0.0, yaw_std**2),
        camera=dataclasses.replace(camera, fx_px=focal_px, fy_px=focal_px, focal_std_share=0.03),
        sha256='0' * 64,
    )
    return Shot(name=record.shot_id, record=record, read=lambda: jpeg)


def _corners(centre: FloatArray, rotation: FloatArray, way_m: FloatArray) -> FloatArray:
    """Return where the true corners of a photograph lie on the ground, (4, 2)."""
    homography = np.linalg.inv(ground_homography(CAMERA, centre, rotation))
    right, bottom = CAMERA.image_width_px - 0.5, CAMERA.image_height_px - 0.5
    corners = np.array([[-0.5, -0.5], [right, -0.5], [right, bottom], [-0.5, bottom]])
    ground = np.column_stack([corners, np.ones(4)]) @ homography.T
    moments = np.array([-0.5, -0.5, 0.5, 0.5])[:, np.newaxis]
    places: FloatArray = ground[:, :2] / ground[:, 2:] + moments * way_m
    return places


def _found(maker: Mapmaker, alignment: Alignment, name: str, frame: LocalFrame) -> FloatArray:
    """Return where the map puts the corners of a photograph, in the true frame, (4, 2)."""
    photo = alignment.photos[name]
    lens = maker.block.state.lenses.get(photo.lens)
    factor = math.exp(lens.log_focal) if lens else 1.0
    corners = footprint(photo, alignment.placements[name].pose, factor)
    map_frame = maker.frame
    if map_frame is None:
        raise PlacementError('no photograph is placed')
    degrees = map_frame.geodetic(corners)
    altitude = np.full(4, frame.origin.altitude_m)
    return frame.to_enu(degrees[:, 0], degrees[:, 1], altitude)[:, :2]


def report(part: str, count: int, *, is_hard: bool, is_each: bool) -> None:
    """Try the first surveys of a part and print what came of them."""
    first = PARTS[part]
    outcomes: list[tuple[Survey, Outcome]] = []
    refused = 0
    for seed in range(first, first + count):
        survey = drawn(seed, is_hard=is_hard)
        try:
            outcomes.append((survey, tried(survey, seed)))
        except PlacementError:
            refused += 1
            continue
        if is_each:
            print(seed, survey, outcomes[-1][1], flush=True)
    print(f'{part}: {len(outcomes)} surveys, {refused} refused')
    for title, is_chosen in _GROUPS.items():
        chosen = [outcome for survey, outcome in outcomes if is_chosen(survey, outcome)]
        if chosen:
            print(f'{title:16}' + _row(chosen))


_GROUPS: dict[str, Callable[[Survey, Outcome], bool]] = {
    'all': lambda _s, _o: True,
    'height told': lambda s, _o: s.has_height,
    'height not told': lambda s, _o: not s.has_height,
    'no drift': lambda s, _o: s.drift == 0.0,
    'drift': lambda s, _o: s.drift > 0.0,
    'take-off': lambda s, _o: s.has_height and s.hardship.take_off != 0.0,
    'rolling shutter': lambda s, _o: s.hardship.rolling > 0.0,
    'turning': lambda s, _o: s.hardship.is_turning,
    'ahead, told': lambda s, _o: s.hardship.ahead_rad > 0.0 and s.hardship.is_ahead_told,
    'ahead, not told': lambda s, _o: s.hardship.ahead_rad > 0.0 and not s.hardship.is_ahead_told,
    'dark corners': lambda s, _o: s.hardship.dark_corners > 0.0,
    'exposure': lambda s, _o: s.hardship.exposure > 0.0,
    'georeferenced': lambda _s, o: o.is_georeferenced,
}


def _row(outcomes: Sequence[Outcome]) -> str:
    ratios = np.array([outcome.stated_m / outcome.true_m for outcome in outcomes])
    true = np.sqrt(np.mean([outcome.true_m**2 for outcome in outcomes]))
    stated = np.sqrt(np.mean([outcome.stated_m**2 for outcome in outcomes]))
    inside = (ratios > 2.0 / 3.0) & (ratios < 1.5)
    scales = np.abs(np.array([outcome.scale for outcome in outcomes]) - 1.0)
    return (
        f'n {len(outcomes):3d}  placed {np.mean([o.placed for o in outcomes]):.3f}  '
        f'true {true:5.2f} m  stated/true: of RMS {stated / true:.2f}, median '
        f'{np.median(ratios):.2f}, from {np.quantile(ratios, 0.1):.2f} to '
        f'{np.quantile(ratios, 0.9):.2f}, within 0.67 to 1.5 {np.mean(inside):.2f}, below 0.4 '
        f'{np.mean(ratios < 0.4):.2f}  scale off p90 {100 * np.quantile(scales, 0.9):.1f} %  '
        f'{np.mean([o.cpu_s for o in outcomes]):.2f} CPU-s'
    )


def main() -> None:
    """Run the part that the command line names."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--part', choices=sorted(PARTS), default='develop')
    parser.add_argument('--count', type=int, default=100)
    parser.add_argument('--hard', action='store_true', help='with what else goes wrong')
    parser.add_argument('--each', action='store_true', help='print each survey')
    options = parser.parse_args()
    report(options.part, options.count, is_hard=options.hard, is_each=options.each)


if __name__ == '__main__':
    main()
