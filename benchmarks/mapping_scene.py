# SPDX-License-Identifier: Apache-2.0
"""The derailment as its engine camera sees it: photographs with the truth of each pixel.

The places are those of a lawnmower flight over the region of the scenario with the paper's
spacing; fixes and tilts are as noisy as the scenario says.
"""

import math
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
import yaml
from mapping_sets import HEIGHT_M, Flight, record_of
from shapely.geometry import Point

from rocsafe_geo.arrays import BoolArray, FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera, rotation_enu_from_optical
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_mapping.alignment.model.photo import rays_of_pixels
from rocsafe_mapping.drawing.placed_photo import PlacedPhoto
from rocsafe_mapping.photographs.label_images import LABELS, TABLE
from rocsafe_mapping.photographs.shot import ShotRecord
from rocsafe_scene.cameras.engine_camera import (
    GROUND_NUMBERS,
    EngineCamera,
    EngineRequest,
    EngineScene,
)
from rocsafe_scene.scene.map_cache import default_folder

SCENARIO = Path(__file__).parents[1] / 'config' / 'scenarios' / 'derailment_engine.yaml'
# Every so many pixels the truth is asked.
CHECK_EVERY_PX = 20
Floats = FloatArray


@dataclass(frozen=True, slots=True)
class SceneShot:
    """A photograph and where some of its pixels (n, 2) truly are: (east, north), (n, 2).

    `is_ground` (n,) tells which of them show ground; the others show what stands on it.
    """

    record: ShotRecord
    jpeg: bytes
    pixels: Floats
    true_m: Floats
    is_ground: BoolArray


def derailment_shots(folder: Path) -> tuple[LocalFrame, list[SceneShot]]:
    """Return the mission's frame and the flight; label images go to `folder`/labels."""
    scenario = yaml.safe_load(SCENARIO.read_text())
    area = SurveyArea(tuple(GeoPosition(*corner) for corner in scenario['region']['polygon']))
    middle, ground_m = area.centroid(), scenario['origin']['ground_altitude_m']
    origin = GeoPosition(middle.latitude_deg, middle.longitude_deg, ground_m)
    frame = LocalFrame(origin)
    lens = PinholeCamera(math.radians(60.0), 640, 480)
    request = EngineRequest(
        scene_file=SCENARIO.parent / scenario['camera']['scene_file'],
        seed=scenario['seed'],
        origin=origin,
        start_ns=int(scenario['clock']['start'].timestamp()) * 10**9,
        cache=default_folder(),
    )
    scene = EngineScene(request)
    camera = EngineCamera(scene, lens, scenario['camera']['oversampling'])
    noise = scenario['simulation']
    flight = Flight(
        camera=lens,
        fix_std_m=noise['gps_horizontal_std_m'],
        height_std_m=noise['gps_vertical_std_m'],
        tilt_std_rad=math.radians(noise['tilt_std_deg']),
    )
    labels = folder / LABELS
    labels.mkdir(parents=True)
    (labels / TABLE).write_text(scene.label_table)
    rng = np.random.default_rng(61)
    shots = []
    for number, place in enumerate(_places(lens, flight.overlap, area, frame)):
        shots.append(_taken(camera, flight, frame, number, place, rng, labels))
    return frame, shots


def errors_m(shot: SceneShot, placed: PlacedPhoto, shift_m: Floats) -> Floats:
    """Return how far the map is off (n, 2) at what a photograph shows.

    `shift_m` is (east, north) of the map's frame in that of the truth.
    """
    seen, _ = placed.pixels_of(shot.true_m - shift_m)
    return (seen - shot.pixels) * placed.photo.ground_resolution_m


def shown_m(shot: SceneShot, placed: PlacedPhoto) -> Floats:
    """Return where the map shows what a photograph's pixels show, (east, north), (n, 2).

    The camera has no distortion.
    """
    rays = rays_of_pixels(placed.photo.camera, shot.pixels) @ placed.pose.rotation.T
    slopes = rays[:, :2] / -rays[:, 2:]
    place: Floats = placed.pose.centre[:2] + slopes * placed.pose.centre[2]
    for _ in range(3):
        reach = placed.pose.centre[2] - placed.surface.at(place)
        place = placed.pose.centre[:2] + slopes * reach[:, np.newaxis]
    return place


def _places(
    lens: PinholeCamera, overlap: float, area: SurveyArea, frame: LocalFrame
) -> list[tuple[float, float]]:
    width, height = (side * (1.0 - overlap) for side in lens.footprint_m(HEIGHT_M))
    polygon = area.polygon(frame)
    west, south, east, north = polygon.bounds
    places = []
    for row in range(math.ceil((north - south) / height) + 1):
        columns = range(math.ceil((east - west) / width) + 1)
        for column in columns if row % 2 == 0 else reversed(columns):
            place = west + column * width, north - row * height
            if polygon.distance(Point(place)) < 0.5 * max(width, height):
                places.append(place)
    return places


def _taken(
    camera: EngineCamera,
    flight: Flight,
    frame: LocalFrame,
    number: int,
    place: tuple[float, float],
    rng: np.random.Generator,
    labels: Path,
) -> SceneShot:
    pitch, roll = rng.normal(0.0, flight.tilt_std_rad, 2)
    rotation = rotation_enu_from_optical(math.pi / 2, pitch, roll)
    centre = np.array([*place, HEIGHT_M]) + rng.normal(0.0, [0.3, 0.3, 0.1])
    image = camera.photograph((*centre.tolist(),), rotation, 10**9 * number)
    told = centre + rng.normal(0.0, [flight.fix_std_m, flight.fix_std_m, flight.height_std_m])
    level = rotation_enu_from_optical(math.pi / 2 + rng.normal(0.0, flight.yaw_std_rad))
    record = record_of(frame, flight, number, told, level)
    truth = camera.truth
    if truth is None:
        raise ValueError('the engine told no truth')
    numbers = np.minimum(truth.numbers, 65_535).astype(np.uint16)
    cv2.imwrite(str(labels / f'{record.shot_id}.png'), numbers)
    rows, columns = np.mgrid[10:480:CHECK_EVERY_PX, 10:640:CHECK_EVERY_PX].reshape(2, -1)
    is_solid = (numbers[rows, columns] > 0) & (numbers[rows, columns] < 65_535)
    rows, columns = rows[is_solid], columns[is_solid]
    is_ground = numbers[rows, columns] >= GROUND_NUMBERS
    pixels = np.column_stack([columns, rows]).astype(float)
    lens = record.camera
    rays = np.column_stack([
        (pixels[:, 0] - lens.cx_px) / lens.fx_px,
        (pixels[:, 1] - lens.cy_px) / lens.fy_px,
        np.ones(len(pixels)),
    ])  # fmt: skip
    depth = truth.depth_m[rows, columns][:, np.newaxis].astype(float)
    true = centre + (rays * depth) @ rotation.T
    jpeg = bytes(cv2.imencode('.jpg', image, [cv2.IMWRITE_JPEG_QUALITY, 90])[1])
    return SceneShot(record, jpeg, pixels, true[:, :2], is_ground)
