# SPDX-License-Identifier: Apache-2.0
"""A console without ROS: a mission that flies on a stage, and vehicles that answer orders."""

import functools
import math
import os
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from io import BytesIO
from pathlib import Path

from PIL import Image

from rocsafe_console.evidence.desk import Desk
from rocsafe_console.orders.order_book import Order, Outcome, Result
from rocsafe_console.people.missions import Missions
from rocsafe_console.people.users import User, Users
from rocsafe_console.picture.gas import GasNow
from rocsafe_console.picture.live import Live
from rocsafe_console.picture.map_image import DOSE, PLUME, Grid, corners_of, png_of
from rocsafe_console.picture.picture import MissionNow, Picture, Reading
from rocsafe_console.picture.vehicle import Holder, VehicleReport
from rocsafe_console.web.context import Context, WebOptions
from rocsafe_console.web.server import ServerThread
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition

TOKEN = 'token-of-the-stage'  # noqa: S105 - of tests
ORIGIN = (53.2800, -9.0633)
M_PER_DEG = 111_320.0
CELLS = 80
# Whom the agents of the first vehicles hear: the third hears nobody, and is heard by one.
CONTACTS = (('rav2', 'rav3'), ('rav1',), ())
ROVER = 'rgv1'
SCENARIOS = Path(__file__).parents[2] / 'config' / 'scenarios'


class Crew:
    """Vehicles that answer every order, or refuse it."""

    def __init__(self) -> None:
        self.sent: list[tuple[Order, tuple[str, ...]]] = []
        self.refusal = ''
        self.is_silent = False

    def send_order(
        self, order: Order, names: tuple[str, ...], finish: Callable[[tuple[Result, ...]], None]
    ) -> None:
        """Answer at once."""
        self.sent.append((order, names))
        outcome = Outcome.REFUSED if self.refusal else Outcome.DONE
        outcome = Outcome.SILENT if self.is_silent else outcome
        finish(tuple(Result(vehicle=n, outcome=outcome, text=self.refusal) for n in names))

    def plan_drive(self, order: Order, finish: Callable[[dict | None, str], None]) -> None:
        """Offer a drive at once, or refuse it."""
        if self.refusal:
            finish(None, self.refusal)
            return
        target, (name,) = order.target, order.revisions
        finish(drive_to((target.latitude_deg, target.longitude_deg), name), '')


def place_of(east_m: float, north_m: float) -> tuple[float, float]:
    """Return latitude and longitude of a point beside the origin, degrees."""
    scale = M_PER_DEG * math.cos(math.radians(ORIGIN[0]))
    return ORIGIN[0] + north_m / M_PER_DEG, ORIGIN[1] + east_m / scale


def drive_to(place: tuple[float, float], vehicle: str = 'rgv1') -> dict:
    """Return a drive from the home of the vehicle to a place and back."""
    home = place_of(-150.0, 0.0)
    return {
        'route_id': 'r1', 'vehicle': vehicle, 'line': [home, place_of(-80.0, 20.0), place, home],
        'stands': [{'id': 'anna-1', 'place': place}], 'duration_s': 184.0, 'dose_usv': 49.3,
        'dose_upper_usv': 61.0, 'dose_budget_usv': 100.0, 'lower_bound_s': 183.0, 'left_out': [],
    }  # fmt: skip


class Stage:
    """A picture in which a mission flies."""

    def __init__(
        self,
        folder: Path,
        vehicles: int = 3,
        users: dict[str, User] | None = None,
        *,
        has_rover: bool = False,
    ) -> None:
        self.names = [f'rav{number + 1}' for number in range(vehicles)]
        self.names += [ROVER] if has_rover else []
        self.crew = Crew()
        self.steps = 0
        self.phase = 2
        # What says no more: mission, fix, dose, detector.
        self.silent: set[str] = set()
        self.state = dict.fromkeys(self.names, 4)
        self.context = Context(
            options=WebOptions(
                port=0,
                runs=folder,
                scenarios=SCENARIOS,
                token='' if users else TOKEN,
                token_user='anna',  # noqa: S106
            ),
            live=Live(Picture(1000)),
            desk=Desk(folder),
            users=Users(users or {}),
            missions=Missions(folder),
            clock=time.time,
            environment=dict(os.environ),
            fleet=self.crew,
        )

    def begin(self) -> None:
        """Put everything that the page can show."""
        now_s = time.time()
        live = self.context.live
        with live.lock:
            picture = live.picture
            for second in (2.0, 1.0):
                picture.on_mission(self._mission(now_s - second), now_s - second)
            for name in self.names:
                picture.on_report(self._report(name, now_s), now_s)
                picture.on_holder(
                    name, Holder(holder='orchestrator@stage', lease='x/1', epoch=1), now_s
                )
                picture.on_home(name, (*place_of(-150.0, 0.0), 40.0))
            for name, heard in zip(self.names[:3], CONTACTS, strict=False):
                picture.on_agent(name, heard, now_s, now_s)
            put = picture.sections.put
            corners = [place_of(*c) for c in ((-120, -80), (120, -80), (120, 80), (-120, 80))]
            put('region', {'name': 'yard', 'rings': [corners]})
            picture.on_plan(self._plan())
            put('sources', {
                'stamp_s': now_s, 'verdict': 'enough: both error rates are met', 'doubts': [],
                'background_usvh': 0.1,
                'sources': [{
                    'id': 0, 'place': place_of(20, 10), 'half_axes_m': [9.0, 5.0],
                    'angle_deg': 30.0, 'dose_rate_at_1m_usvh': 9e4,
                    'dose_rate_at_1m_std_usvh': 4e3, 'probability': 'over 99.9 %',
                    'nuclide': 'Cs-137',
                }],
            })  # fmt: skip
            put(
                'cordons',
                [self._cordon(level, size) for level, size in ((25.0, 70.0), (100.0, 30.0))],
            )
            put('releases', {
                'stamp_s': now_s, 'rate_unit': 'g/s', 'agent': 'ammonia', 'sensor': 'pid',
                'verdict': 'enough', 'is_enough': True,
                'releases': [{
                    'id': 0, 'place': place_of(-60, -30), 'radius_95_m': 8.0, 'rate': 90.0,
                    'rate_low': 60.0, 'rate_high': 140.0,
                }],
            })  # fmt: skip
            zone = {'level': 'AEGL-2 160 ppm', 'colour': '#ff8000'}
            put('zones', [
                {**zone, 'is_mean': size < 60.0, 'ring': self._cordon(0.0, size)['ring']}
                for size in (50.0, 65.0)
            ])  # fmt: skip
            put(
                'wind',
                {
                    'vehicle': 'rav1',
                    'stamp_s': now_s,
                    'from_deg': 240.0,
                    'speed_mps': 3.4,
                    'std_mps': 0.3,
                    'heard_s': now_s,
                },
            )
            self._images(now_s)
            if ROVER in self.names:
                put('drive', drive_to(place_of(0.0, 25.0)))
        self.step()

    def step(self) -> None:
        """Fly on by a tenth of a second."""
        now_s = time.time()
        self.steps += 1
        live = self.context.live
        with live.lock:
            picture = live.picture
            if 'mission' not in self.silent:
                picture.on_mission(self._mission(now_s), now_s)
            for number, name in enumerate(self.names):
                angle = self.steps * 0.02 + number * 2 * math.pi / len(self.names)
                east, north = 100 * math.cos(angle), 60 * math.sin(angle)
                if name == ROVER:
                    east, north = -150.0 + self.steps % 700 * 0.1, 0.03 * (self.steps % 700)
                place = place_of(east, north)
                if number < len(CONTACTS):
                    picture.on_agent(name, CONTACTS[number], now_s, now_s)
                if self.steps % 10 == number % 10 or self.state[name] != 4:
                    picture.on_report(self._report(name, now_s), now_s)
                if 'fix' not in self.silent:
                    picture.on_fix(name, (*place, 90.0), now_s, now_s)
                if 'dose' not in self.silent:
                    picture.on_dose(name, 3.2, now_s, now_s, is_lower_limit=False)
                if 'detector' in self.silent:
                    continue
                rate = 0.1 + 9e4 / (400.0 + (east - 20) ** 2 + (north - 10) ** 2)
                picture.on_reading(
                    Reading(vehicle=name, stamp_s=now_s, dose_rate_usvh=rate, std_usvh=0.1,
                            latitude_deg=place[0], longitude_deg=place[1], detector='nai_3x3'),
                    now_s,
                )  # fmt: skip
                picture.on_gas(
                    GasNow(vehicle=name, stamp_s=now_s, value=rate / 20.0, std=0.5, unit='ppm',
                           sensor='pid_10_6_ev', calibration_gas='isobutylene',
                           latitude_deg=place[0], longitude_deg=place[1]),
                    now_s,
                )  # fmt: skip

    def fly(self, seconds: float) -> None:
        """Fly at the pace of the wall for some seconds."""
        end_s = time.monotonic() + seconds
        while time.monotonic() < end_s:
            self.step()
            time.sleep(0.1)

    def _mission(self, stamp_s: float) -> MissionNow:
        return MissionNow(
            mission_id='yard-20260601-100000', phase=self.phase, stamp_s=stamp_s,
            images_stored=21 + self.steps // 20, images_expected=59,
            mission_time_s=130.0 + self.steps / 10,
        )  # fmt: skip

    def _report(self, name: str, now_s: float) -> VehicleReport:
        return VehicleReport(
            name=name, state=self.state[name], stamp_s=now_s, is_simulated=True,
            viewpoint_count=20, viewpoints_visited=7, battery_fraction=0.8 - self.steps * 1e-4,
            speed_mps=8.0, is_ground=name == ROVER, plan_id='p1',
        )  # fmt: skip

    def _plan(self) -> dict:
        line = [place_of(x, y) for y in (-60, 0, 60) for x in ((-100, 100) if y else (100, -100))]
        routes = {
            name: {
                'home': place_of(-150, 0),
                'line': line,
                'viewpoints': [[*line[0], 0.0]],
                'duration_s': 384.0,
            }
            for name in self.names[:3]
        }
        return {
            'plan_id': 'p1', 'makespan_s': 384.0, 'lower_bound_s': 375.0,
            'footprint_m': [30.0, 22.0], 'routes': routes,
            'exclusions': [[[place_of(40, 40), place_of(70, 40), place_of(60, 70)]]],
        }  # fmt: skip

    def _cordon(self, level: float, size_m: float) -> dict:
        turns = [n * math.pi / 24 for n in range(49)]
        ring = [place_of(20 + size_m * math.cos(a), 10 + size_m * math.sin(a)) for a in turns]
        return {'level_usvh': level, 'is_mean': False, 'ring': ring}

    def _images(self, now_s: float) -> None:
        live = self.context.live
        images, corners = _drawn()
        live.images.update(images)
        put = live.picture.sections.put
        for name in ('dose_map', 'plume'):
            put(name, {'stamp_s': now_s, 'heard_s': now_s, 'corners': corners})
        put('mosaic', {
            'stamp_s': now_s, 'heard_s': now_s, 'images_placed': 21, 'is_final': False,
            'ground_resolution_m': 0.1, 'corners': [place_of(-110, -70), place_of(60, 70)],
        })  # fmt: skip


@functools.cache
def _drawn() -> tuple[dict[str, bytes], list[list[float]]]:
    """Return the images of a stage, and the corners of the two maps."""
    cells = [
        min(100, int(16 * math.log10(10 + 9e5 / (400 + (5 * x - 220) ** 2 + (5 * y - 210) ** 2))))
        for y in range(CELLS)
        for x in range(CELLS)
    ]
    grid = Grid(cells=cells, columns=CELLS, corner_m=(-200.0, -200.0), cell_m=5.0)
    buffer = BytesIO()
    Image.linear_gradient('L').convert('RGB').save(buffer, 'PNG')
    images = {
        'dose_map': png_of(grid, DOSE),
        'plume': png_of(grid, PLUME),
        'mosaic': buffer.getvalue(),
    }
    return images, corners_of(grid, LocalFrame(GeoPosition(*ORIGIN, 0.0)))


@contextmanager
def served(stage: Stage) -> Iterator[str]:
    """Serve a stage; gives the address of the page, which ends in a slash."""
    server = ServerThread(stage.context, print)
    try:
        yield server.address
    finally:
        server.close()
        stage.context.desk.close()
