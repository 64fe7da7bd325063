# SPDX-License-Identifier: Apache-2.0
"""A finished run as the nodes leave it, made without flying it."""

import io
import json
import math
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.plan import Route, Sortie, SurveyPlan
from rocsafe_planner.plan.plan_json import plan_document
from rocsafe_planner.plan.request import SurveyRequest
from rocsafe_planner.plan.survey_options import CoverageOptions, Effort, SeparationOptions
from rocsafe_planner.plan.survey_region import SurveyRegion
from rocsafe_planner.plan.vehicle import Vehicle
from rocsafe_planner.plan.viewpoint import Viewpoint

NS = 1_000_000_000
START_NS = 1_748_772_000 * NS
HEIGHT_M = 32.0
SPEED_MPS = 8.0
GROUND_M = 66.0
SIGMA_USVPS = 25.0
SOURCE = (53.27985, -9.06330, 1.0)
CORNERS = [
    (53.27959959, -9.0617270785),
    (53.2805257315, -9.0621271428),
    (53.2801009832, -9.0648776011),
    (53.2791748417, -9.0644775368),
]
CRANE = [(53.2797, -9.0632), (53.2799, -9.0632), (53.2798, -9.0635)]
HOMES = {'rav1': (53.2800, -9.0700), 'rav2': (53.2860, -9.0588), 'rav3': (53.2798, -9.0565)}
SCENARIO = {
    'name': 'derailment',
    'description': 'Derailed train with a gamma source, three RAVs',
    'seed': 2018,
    'origin': {'ground_altitude_m': GROUND_M},
    'region': {'polygon': [list(corner) for corner in CORNERS]},
    'survey': {'height_agl_m': HEIGHT_M},
    'vehicles': [{'name': n, 'home': list(h), 'cruise_speed_mps': 8.0} for n, h in HOMES.items()],
    'radiation': {
        'sources': [
            {'name': 'wreck <1>', 'position': list(SOURCE[:2]), 'height_m': SOURCE[2],
             'sigma_usvps': SIGMA_USVPS}
        ]
    },
}  # fmt: skip


def _area(name, corners):
    return SurveyArea(boundary=tuple(GeoPosition(*corner) for corner in corners), name=name)


@dataclass(frozen=True)
class Synthetic:
    """How fine a synthetic run is made."""

    spacing_m: float = 24.634
    fix_rate_hz: float = 5.0
    mosaic_resolution_m: float = 0.5
    image_size: tuple[int, int] = (160, 120)


COARSE = Synthetic(spacing_m=40.0, fix_rate_hz=1.0, mosaic_resolution_m=2.0, image_size=(64, 48))


class SyntheticRun:
    """Writes the files of a run that never flew, each as its node would."""

    def __init__(self, path: Path, detail: Synthetic) -> None:
        from rocsafe_geo.frame import LocalFrame
        from rocsafe_geo.position import GeoPosition
        from rocsafe_geo.regions.area import SurveyArea

        self.path = path
        self.detail = detail
        self.area = SurveyArea(
            boundary=tuple(GeoPosition(latitude_deg=a, longitude_deg=b) for a, b in CORNERS)
        )
        centre = self.area.centroid()
        self.frame = LocalFrame(
            GeoPosition(
                latitude_deg=centre.latitude_deg,
                longitude_deg=centre.longitude_deg,
                altitude_m=GROUND_M,
            )
        )
        self.routes = self._routes()
        self.flights = {name: self._flight(name) for name in HOMES}
        self.ground = self._ground()

    def write(self) -> Path:
        """Write all files and return the run directory."""
        import yaml

        self.path.mkdir(parents=True)
        (self.path / 'scenario.yaml').write_text(yaml.safe_dump(SCENARIO), encoding='utf-8')
        info = {
            'command': ['rocsafe', 'run', 'config/scenarios/derailment.yaml'],
            'git_revision': '0123abcd' * 5,
            'git_dirty': False,
            'versions': {'python': '3.11.7', 'rocsafe_orchestrator': '0.1.0', 'mcap': '1.6.0'},
            'platform': 'Linux-6.1-x86_64-with-glibc2.36',
            'ros_distro': 'jazzy (wheels)',
            'outcome': 'complete',
            'outcome_text': '',
            'wall_time_s': 27.5,
            'restarts': {'rav2': 1},
        }
        (self.path / 'run.json').write_text(json.dumps(info), encoding='utf-8')
        (self.path / 'plan.json').write_text(json.dumps(self.plan()), encoding='utf-8')
        self.write_recording()
        self.write_mosaic()
        self.write_images()
        return self.path

    # Geometry.

    def _home(self, name):
        latitude, longitude = HOMES[name]
        return self.frame.to_enu(latitude, longitude, GROUND_M)[0]

    def _routes(self):
        """Lanes over the region, shared out in turn."""
        polygon = self.area.polygon(self.frame).buffer(self.detail.spacing_m * 0.4)
        west, south, east, north = polygon.bounds
        import shapely

        lanes = []
        for number, y in enumerate(np.arange(south + 8, north, self.detail.spacing_m)):
            xs = np.arange(west + 8, east, self.detail.spacing_m)
            lane = [(x, y) for x in xs if polygon.contains(shapely.Point(x, y))]
            lanes.append(lane if number % 2 else lane[::-1])
        points = [point for lane in lanes for point in lane]
        shares = np.array_split(np.array(points), len(HOMES))
        return dict(zip(HOMES, [share.tolist() for share in shares], strict=True))

    def _flight(self, name):
        """Times since the start, s, and positions at the fix rate; shots as (time, point)."""
        home = self._home(name)
        corners, times, shots, clock = [home], [0.0], [], 0.0

        def go(point, speed, wait=0.0):
            nonlocal clock
            clock += max(float(np.linalg.norm(np.subtract(point, corners[-1]))) / speed, 0.01)
            corners.append(np.array(point))
            times.append(clock)
            if wait:
                clock += wait
                corners.append(np.array(point))
                times.append(clock)

        go((home[0], home[1], home[2] + HEIGHT_M), 2.5)
        for x, y in self.routes[name]:
            go((x, y, HEIGHT_M), SPEED_MPS, wait=1.0)
            shots.append((clock, (x, y)))
        go((home[0], home[1], HEIGHT_M), SPEED_MPS)
        go(home, 1.5)
        step = 1.0 / self.detail.fix_rate_hz
        ticks = np.arange(0.0, clock + step, step)
        track = np.array([np.interp(ticks, times, axis) for axis in np.array(corners).T]).T
        return ticks, track, shots, clock

    def doses(self, track):
        """Dose rates by the paper's model along `track`, uSv/h."""
        source = self.frame.to_enu(SOURCE[0], SOURCE[1], GROUND_M + SOURCE[2])[0]
        squares = np.sum((track - source) ** 2, axis=1)
        return SIGMA_USVPS * 3600.0 / np.maximum(squares, 0.01)

    # Messages.

    def write_recording(self) -> None:
        """Write one segment with all that happened."""
        from rclpy.serialization import serialize_message

        from rocsafe_orchestrator.recording.message_definitions import MessageDefinitions
        from rocsafe_orchestrator.recording.recorded_topics import channel_of
        from rocsafe_orchestrator.recording.segments import SegmentWriter

        writer = SegmentWriter(self.path, MessageDefinitions.of_environment())
        numbers = {}
        for time_ns, spec, topic, message in sorted(self._messages(), key=lambda m: m[0]):
            if topic not in numbers:
                numbers[topic] = writer.add_channel(channel_of(spec, topic))
            writer.write(numbers[topic], serialize_message(message), time_ns)
        writer.flush()

    def _messages(self):

        for name in HOMES:
            yield from self._vehicle_messages(name)
        end = max(flight[3] for flight in self.flights.values())
        phases = [(0.0, 1), (0.1, 2), (end / 2, 2), (end, 2), (end + 1, 3), (end + 2, 4),
                  (end + 2.1, 5)]  # fmt: skip
        for seconds, phase in phases:
            yield self._mission_message(seconds, phase)

    def _mission_message(self, seconds, phase):
        from rocsafe_interfaces.msg import MissionState
        from rocsafe_ros.interfaces import topics

        message = MissionState(phase=phase, mission_time_s=seconds, wall_time_s=4 + seconds / 25)
        message.header.stamp = _stamp(seconds)
        return _ns(seconds), topics.MISSION_STATE, '/mission/state', message

    def _vehicle_messages(self, name):
        from sensor_msgs.msg import NavSatFix

        from rocsafe_interfaces.msg import RadiationReading, VehicleState
        from rocsafe_ros.interfaces import topics

        ticks, track, shots, end = self.flights[name]
        places = self.frame.to_geodetic(track)
        for seconds, place, dose in zip(ticks, places, self.doses(track), strict=True):
            fix = NavSatFix(latitude=place[0], longitude=place[1], altitude=place[2])
            fix.header.stamp = _stamp(seconds)
            fix.status.status = 0
            yield _ns(seconds), topics.GROUND_TRUTH_FIX, f'/{name}/ground_truth/fix', fix
            reading = RadiationReading(dose_rate_usvh=float(dose), model='paper')
            reading.header.stamp = fix.header.stamp
            reading.live_time_s = math.nan
            reading.position.latitude, reading.position.longitude = place[0], place[1]
            reading.position.altitude = place[2]
            yield _ns(seconds), topics.RADIATION, f'/{name}/radiation', reading
        visited = np.array([time for time, _ in shots])
        states = [(0.0, 1), (0.1, 3), (14.0, 4), (end - 60, 6), (end - 22, 7), (end, 8)]
        for seconds, state in states:
            count = int(np.sum(visited <= seconds))
            message = VehicleState(
                state=state, plan_id='0a1b2c' if state > 1 else '', viewpoint_count=len(shots),
                viewpoints_visited=count, shots_taken=count,
                battery_fraction=1.0 - seconds / 1500.0, distance_flown_m=SPEED_MPS * seconds,
            )  # fmt: skip
            message.header.stamp = _stamp(seconds)
            yield _ns(seconds), topics.STATE, f'/{name}/state', message

    def plan(self):
        """The plan as the planner writes it to plan.json."""
        routes, number = [], 0
        for name, points in self.routes.items():
            views = []
            for x, y in points:
                place = GeoPosition(*self.frame.to_geodetic((x, y, HEIGHT_M))[0].tolist())
                views.append(
                    Viewpoint(
                        id=number, position=place, height_agl_m=32.0, yaw_rad=0.0, footprint=()
                    )
                )
                number += 1
            duration_s = self.flights[name][3] * 0.99
            sortie = Sortie(
                viewpoints=tuple(views),
                bends=((),) * (len(views) + 1),
                length_m=SPEED_MPS * duration_s,
                duration_s=duration_s,
                energy_wh=0.0,
            )
            vehicle = Vehicle(name=name, home=GeoPosition(*HOMES[name], GROUND_M))
            routes.append(Route(vehicle=vehicle, sorties=(sortie,)))
        request = SurveyRequest(
            regions=(SurveyRegion(area=_area('derailment', CORNERS)),),
            exclusions=(_area('crane', CRANE),),
            camera=PinholeCamera(math.radians(60.0), 640, 480),
            vehicles=tuple(route.vehicle for route in routes),
            coverage=CoverageOptions(height_agl_m=HEIGHT_M),
            separation=SeparationOptions(distance_m=12.0),
            effort=Effort(method='paper_greedy'),
        )
        plan = SurveyPlan(
            plan_id='0a1b2c',
            request=request,
            routes=tuple(routes),
            spacing_m=self.detail.spacing_m,
            spacing_along_m=self.detail.spacing_m,
            lower_bound_s=max(route.finish_s for route in routes) / 1.23,
            lower_bound_method='held_karp',
            region_area_m2=19880.0,
            covered_area_m2=19880.0,
            minimum_separation_m=26.5,
        )
        return plan_document(plan)

    # Pictures.

    def _ground(self):
        """A picture of the ground: field, track, train; RGB, north up, and its bounds, m."""
        resolution = self.detail.mosaic_resolution_m
        polygon = self.area.polygon(self.frame).buffer(16.0)
        west, south, east, north = polygon.bounds
        columns, rows = np.arange(west, east, resolution), np.arange(north, south, -resolution)
        xs, ys = np.meshgrid(columns, rows)
        random = np.random.default_rng(7)
        grass = np.array([112, 122, 84]) + random.normal(0, 9, (*xs.shape, 3))
        grass += 10 * np.sin(xs / 17)[..., None] + 8 * np.cos(ys / 11 + xs / 40)[..., None]
        across = ys * 0.97 - xs * 0.24
        grass[np.abs(across + 8) < 5] = (128, 118, 108)
        for rail in (-9.0, -7.0):
            grass[np.abs(across - rail) < 0.5] = (70, 66, 66)
        for wagon in range(-3, 5):
            inside = (np.abs(xs - 17 * wagon) < 7) & (np.abs(across + 8 + wagon % 3) < 2)
            grass[inside] = (120, 60 + 12 * wagon, 50)
        import shapely

        mask = shapely.contains_xy(polygon, xs, ys)
        return np.clip(grass, 0, 255).astype(np.uint8), mask, (west, north)

    def write_mosaic(self) -> None:
        """Write mosaic.tif in UTM, as the mosaic node does."""
        import rasterio
        from pyproj import Transformer
        from rasterio.transform import Affine

        picture, mask, (west, north) = self.ground
        latitude, longitude, _ = self.frame.to_geodetic((west, north, 0.0))[0]
        to_utm = Transformer.from_crs(4326, 32629, always_xy=True)
        left, top = to_utm.transform(longitude, latitude)
        resolution = self.detail.mosaic_resolution_m
        transform = Affine(resolution, 0.0, left, 0.0, -resolution, top)
        with rasterio.open(
            self.path / 'mosaic.tif', 'w', driver='GTiff', width=picture.shape[1],
            height=picture.shape[0], count=4, dtype='uint8', crs='EPSG:32629',
            transform=transform, compress='deflate', photometric='RGB', alpha='yes',
        ) as raster:  # fmt: skip
            raster.write(picture.transpose(2, 0, 1), [1, 2, 3])
            raster.write(mask.astype(np.uint8) * 255, 4)

    def write_images(self) -> None:
        """Write the image store, photograph by photograph."""
        folder = self.path / 'images'
        folder.mkdir()
        number = 0
        with (folder / 'manifest.jsonl').open('w', encoding='utf-8') as manifest:
            for name, flight in self.flights.items():
                for sequence, (seconds, point) in enumerate(flight[2]):
                    shot = f'{name}-{sequence:05d}'
                    place = self.frame.to_geodetic((*point, HEIGHT_M))[0]
                    record = {
                        'shot_id': shot, 'vehicle': name, 'viewpoint_id': number,
                        'time_ns': _ns(seconds), 'latitude_deg': place[0],
                        'longitude_deg': place[1], 'altitude_m': place[2],
                        'height_agl_m': HEIGHT_M, 'orientation_xyzw': [-1.0, 0.0, 0.0, 0.0],
                        'camera': {'width_px': 640, 'height_px': 480, 'fx_px': 554.2562584},
                    }  # fmt: skip
                    number += 1
                    (folder / f'{shot}.json').write_text(json.dumps(record), encoding='utf-8')
                    (folder / f'{shot}.jpg').write_bytes(self._photograph(point))
                    manifest.write(json.dumps({'shot_id': shot}) + '\n')

    def _photograph(self, point):
        from PIL import Image

        picture, _, (west, north) = self.ground
        resolution = self.detail.mosaic_resolution_m
        column, row = (point[0] - west) / resolution, (north - point[1]) / resolution
        half_w, half_h = 18 / resolution, 14 / resolution
        box = (int(column - half_w), int(row - half_h), int(column + half_w), int(row + half_h))
        stream = io.BytesIO()
        Image.fromarray(picture).crop(box).resize(self.detail.image_size).save(stream, 'JPEG')
        return stream.getvalue()


def _ns(seconds):
    return START_NS + round(seconds * 10) * (NS // 10)


def _stamp(seconds):
    from rocsafe_ros.conversions import stamp_of_ns

    return stamp_of_ns(_ns(seconds))


@pytest.fixture(scope='session')
def flown_run(tmp_path_factory):
    """A run directory as the nodes leave it, coarse."""
    pytest.importorskip('rocsafe_interfaces', reason='no ROS 2 here: source it or run make setup')
    path = tmp_path_factory.mktemp('runs') / 'derailment-20250601-100000'
    return SyntheticRun(path, COARSE).write()
