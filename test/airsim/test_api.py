# SPDX-License-Identifier: Apache-2.0
"""AirSim's methods over vehicles without ROS: the core of the simulation in real code."""

import asyncio
import math
import re
from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

import numpy as np
import pytest
from test.sim.flights import AIRFRAME, START_NS

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.api import Api
from rocsafe_airsim.ned import Origin
from rocsafe_airsim.protocol.wire import Call
from rocsafe_airsim.vehicle import Picture, VehicleNow
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.battery import HOVER_POWER_W
from rocsafe_geo.position import GeoPosition
from rocsafe_sim.errors import CommandRefusedError
from rocsafe_sim.flight.segment import Mode
from rocsafe_sim.vehicle.free_vehicle import FreeVehicle

DOCS = Path(__file__).resolve().parents[2] / 'docs'
FRAME = LocalFrame(GeoPosition(53.28, -9.06, 60.0))
# Simulated seconds a look at the vehicle: the waits of the methods end at once.
STEP_NS = 200_000_000
STATES = {
    Mode.DISARMED: 1, Mode.TAKING_OFF: 3, Mode.FLYING: 4, Mode.HOLDING: 5, Mode.RETURNING: 6,
    Mode.LANDING: 7, Mode.LANDED: 8,
}  # fmt: skip
DEPTH = np.linspace(1.0, 200.0, 12, dtype=np.float32).reshape(3, 4)
DEPTH[0, 0] = np.inf
LABELS = np.arange(12, dtype=np.uint16).reshape(3, 4)
PIXELS = np.arange(36, dtype=np.uint8).reshape(3, 4, 3)
ANY_YAW = {'is_rate': True, 'yaw_or_rate': 0.0}


@dataclass
class World:
    """Vehicles that fly on by a step each time that somebody asks for the time."""

    vehicles: dict = field(default_factory=dict)
    now_ns: int = START_NS
    paused: bool = False
    drawn: list = field(default_factory=list)

    def to_geodetic(self, place):
        """Return latitude, longitude, altitude."""
        return tuple(FRAME.to_geodetic([place])[0].tolist())

    def to_enu(self, position):
        """Return east, north, up."""
        return tuple(FRAME.to_enu(*position)[0].tolist())

    def time_ns(self):
        """Fly on."""
        if not self.paused:
            self.now_ns += STEP_NS
            for vehicle in self.vehicles.values():
                vehicle.core.step(self.now_ns)
        return self.now_ns

    def is_paused(self):
        """Return whether time stands."""
        return self.paused

    async def pause(self, *, is_paused):
        """Stop or start time."""
        self.paused = is_paused

    @property
    def drawings(self):
        """Where it is drawn: here."""
        return self

    def draw(self, lines, rgba, size_m, *, kind, duration_s):
        """Keep what is drawn."""
        self.drawn.append((lines, rgba, size_m, kind, duration_s))

    def write(self, texts, rgba, size_m, duration_s):
        """Keep what is written."""
        self.drawn.append((texts, rgba, size_m, 'text', duration_s))

    def trace(self, vehicle, rgba, size_m):
        """Keep what is traced."""
        self.drawn.append((vehicle, rgba, size_m))

    def clear(self):
        """Forget it."""
        self.drawn.clear()


class Vehicle:
    """A vehicle of the simulation's core."""

    def __init__(self, world, name, home, *, is_simulated=True):
        self.name, self.world, self.is_simulated = name, world, is_simulated
        self.core = FreeVehicle(AIRFRAME, home)
        self.core.step(START_NS)
        self.origin = Origin(home)
        self.home = world.to_geodetic(home)
        self.cameras = ['camera', 'oblique']
        self.leads, self.orders = False, 0
        self.smells, self.light, self.fov_deg = False, None, 70.0
        world.vehicles[name] = self

    def now(self):
        """Return its state."""
        seen = self.core.observe()
        yaw, place = seen.pose.yaw_rad, seen.pose.position_enu
        return VehicleNow(
            stamp_ns=seen.time_ns, state=STATES[seen.mode], text='', place_enu=place,
            velocity_enu=seen.pose.velocity_enu, true_enu=place,
            attitude=(0.0, 0.0, math.sin(yaw / 2), math.cos(yaw / 2)),
            position=self.world.to_geodetic(place), std_m=(1.0, 2.0),
        )  # fmt: skip

    @property
    def is_led(self):
        """Return whether the lease is held."""
        return self.leads

    async def take(self):
        """Lead it."""
        self.leads = True

    async def release(self):
        """Lead it no more."""
        self.leads = False

    async def along(self, places, speed_mps):
        """Fly along places."""
        up = self.origin.home_enu[2]
        goals = [(*self.world.to_enu((p[0], p[1], 60.0))[:2], up + p[2]) for p in places]
        self._do(lambda: self.core.fly_along(goals, speed_mps))

    async def at_velocity(self, velocity_enu, duration_s, turn):
        """Fly at a velocity."""
        await asyncio.sleep(0)
        self.orders += 1
        how = (turn.rate_radps, turn.yaw_enu_rad)
        self._do(lambda: self.core.fly_at(velocity_enu, duration_s, *how))

    async def turn(self, yaw_enu_rad):
        """Turn."""
        self._do(lambda: self.core.turn_to(yaw_enu_rad))

    async def plain(self, verb):
        """Hold, land or return."""
        self._do(getattr(self.core, verb))

    async def set_home(self, position):
        """Stand elsewhere."""
        self._do(lambda: self.core.set_home(self.world.to_enu(position)))
        self.origin = Origin(self.core.home_enu)

    async def set_wind(self, east_mps, north_mps):
        """Fly in another wind."""
        self._do(lambda: self.core.set_wind((east_mps, north_mps)))

    async def set_light(self, light):
        """Keep it."""
        self.light = light

    async def point(self, camera, pitch_rad, yaw_rad):
        """Keep it."""
        self.pointed = (camera, pitch_rad, yaw_rad)

    async def set_fov(self, _camera, fov_deg):
        """Keep it."""
        self.fov_deg = fov_deg

    async def look(self, camera, *, with_truth):
        """Return a picture."""
        down = (math.sqrt(0.5), -math.sqrt(0.5), 0.0, 0.0)
        truth = {'depth_m': DEPTH, 'labels': LABELS} if with_truth and camera == 'camera' else {}
        return Picture(
            stamp_ns=5, pixels=PIXELS, place_enu=(1.0, 2.0, 33.0), attitude=down,
            fov_deg=self.fov_deg, **truth,
        )  # fmt: skip

    def label_table(self, camera) -> Sequence[dict]:
        """Return two instances."""
        wagon = {'number': 3, 'name': 'wagon_1', 'place': [-30.0, 27.0, 2.0], 'yaw': 0.0}
        rows = [wagon, {'number': 300, 'name': 'drum'}]
        return rows if camera == 'camera' else ()

    def reading(self, kind):
        """Return a reading."""
        if kind == 'imu':
            return {'time_stamp': 7, 'linear_acceleration': {'z_val': -9.80665}}
        return {'dose_rate_usvh': 2.5} if kind == 'radiation' else self._none()

    def _none(self):
        raise AirsimError(f'{self.name} has no gas reading')

    def _do(self, order):
        try:
            order()
        except (CommandRefusedError, ValueError) as error:
            raise AirsimError(str(error)) from error


@pytest.fixture
def world() -> World:
    """Return a world with two vehicles; the second is real."""
    world = World()
    Vehicle(world, 'rav1', (-40.0, 25.0, 0.0))
    Vehicle(world, 'rav2', (10.0, 0.0, 0.0), is_simulated=False)
    return world


def ask(world: World, *calls):
    """Carry out calls one after the other; return the last result."""
    api = Api(world, print)

    async def all_of_them():
        result = None
        for method, *arguments in calls:
            call = Call(call_id=1, method=method, arguments=tuple(arguments))
            result = await api.handle(call)
        return result

    return asyncio.run(all_of_them())


def position(state):
    """Return the place of a MultirotorState."""
    place = state['kinematics_estimated']['position']
    return place['x_val'], place['y_val'], place['z_val']


LED = (('enableApiControl', True, ''), ('takeoff', 20, ''))


@pytest.mark.slow
def test_a_script_takes_off_flies_and_lands(world):
    """As hello_drone does; places are north, east, down about home."""
    state = ask(world, *LED, ('getMultirotorState', ''))
    assert position(state) == pytest.approx((0.0, 0.0, -3.0), abs=0.1)
    assert state['landed_state'] == 1
    move = ('moveToPosition', 10.0, -20.0, -15.0, 5.0, 3e38, 0, ANY_YAW, -1, 1, '')
    state = ask(world, LED[0], move, ('getMultirotorState', ''))
    assert position(state) == pytest.approx((10.0, -20.0, -15.0), abs=0.1)
    assert ask(world, LED[0], ('land', 60, '')) is True
    assert world.vehicles['rav1'].core.mode is Mode.LANDED


MOVEMENTS = {
    'path': (
        'moveOnPath',
        [{'x_val': 300.0, 'y_val': 0.0, 'z_val': -9.0}],
        5.0,
        3e38,
        0,
        ANY_YAW,
        -1,
        1,
        '',
    ),
    'velocity': ('moveByVelocity', 5.0, 0.0, 0.0, 3600.0, 0, ANY_YAW, ''),
    'landing': ('land', 60, ''),
}


@pytest.mark.slow
@pytest.mark.parametrize('movement', MOVEMENTS)
def test_a_vehicle_holds_when_its_client_goes(world, movement):
    """Nobody watches it any more; one that lands goes on."""
    method, *arguments = MOVEMENTS[movement]
    vehicle = world.vehicles['rav1']

    async def leave():
        api = Api(world, print)
        for name, *given in LED:
            await api.handle(Call(call_id=1, method=name, arguments=tuple(given)))
        call = Call(call_id=1, method=method, arguments=tuple(arguments))
        moving = asyncio.create_task(api.handle(call))
        while vehicle.core.mode not in (Mode.FLYING, Mode.LANDING):
            await asyncio.sleep(0.01)
        moving.cancel()
        await asyncio.sleep(0.1)
        return vehicle.core.mode

    ended = asyncio.run(asyncio.wait_for(leave(), 20.0))
    assert ended is (Mode.LANDING if movement == 'landing' else Mode.HOLDING)


@pytest.mark.slow
def test_path_velocity_and_turns(world):
    """Each ends where it should; forward only faces the way."""
    path = [{'x_val': x, 'y_val': y, 'z_val': -8.0} for x, y in ((0.0, 30.0), (30.0, 30.0))]
    done = ask(world, *LED, ('moveOnPath', path, 6.0, 1e9, 1, {'is_rate': False, 'yaw_or_rate': 0},
                             -1, 1, ''))  # fmt: skip
    assert done is True
    seen = world.vehicles['rav1'].now()
    assert world.vehicles['rav1'].origin.to_ned(seen.true_enu) == pytest.approx(
        (30.0, 30.0, -8.0), abs=0.1
    )
    velocity = ('moveByVelocity', 0.0, 3.0, 0.0, 4.0, 0, ANY_YAW, '')
    assert ask(world, LED[0], velocity) is True
    ask(world, LED[0], ('rotateToYaw', 180.0, 1e9, 5.0, ''))
    pose = ask(world, ('simGetVehiclePose', ''))
    assert abs(pose['orientation']['z_val']) == pytest.approx(1.0, abs=0.01)
    assert ask(world, LED[0], ('rotateByYawRate', 30.0, 9.0, '')) is True


@pytest.mark.slow
def test_another_order_ends_the_wait_for_the_first(world):
    """The first answers false, as AirSim's does."""
    api = Api(world, print)

    async def both():
        for method, *arguments in LED:
            await api.handle(Call(call_id=1, method=method, arguments=tuple(arguments)))
        far = (500.0, 0.0, -20.0, 5.0, 3e38, 0, ANY_YAW, -1, 1, '')
        first = asyncio.create_task(
            api.handle(Call(call_id=2, method='moveToPosition', arguments=far))
        )
        await asyncio.sleep(0.1)
        await api.handle(Call(call_id=3, method='cancelLastTask', arguments=('',)))
        return await first

    assert asyncio.run(both()) is False
    assert world.vehicles['rav1'].core.mode is Mode.HOLDING


def test_documents_list_every_method_and_no_other(world):
    """And the comparison counts them."""
    served = Api(world, print).served
    table = (
        (DOCS / 'airsim.md').read_text().partition('## Methods')[2].partition('\nEvery other')[0]
    )
    listed = set(re.findall(r'`(\w+)`', table))
    assert served <= listed
    assert f'{len(served)} methods of it' in (DOCS / 'comparison.md').read_text()


def test_control_that_was_taken_over_is_told(world):
    """By an operator's console, for example."""
    api = Api(world, print)

    async def is_enabled():
        return await api.handle(Call(call_id=1, method='isApiControlEnabled', arguments=('',)))

    async def all_three():
        before = await is_enabled()
        await api.handle(Call(call_id=1, method='enableApiControl', arguments=(True, '')))
        during = await is_enabled()
        world.vehicles['rav1'].leads = False
        return before, during, await is_enabled()

    assert asyncio.run(all_three()) == (False, True, False)


ODD_VALUES = (
    None, True, -1, 2**63, math.nan, math.inf, -1e308, '', 'x' * 5000, '[', b'\xff', [], [[]],
    ['a'] * 3, [math.nan] * 3, {}, {'x_val': math.nan, 'y_val': 0, 'z_val': 0}, {'position': 1},
    {'is_rate': True, 'yaw_or_rate': math.nan}, [{'camera_name': [], 'image_type': {}}],
    [{'camera_name': '0', 'image_type': 0}] * 20_000, list(range(20_000)),
)  # fmt: skip


@pytest.mark.slow
def test_parameters_of_any_kind_and_number_are_carried_out_or_refused_by_name(world):
    """Each refusal is ours, short, and none is the interpreter's."""
    api, rng = Api(world, print), np.random.default_rng(5)
    refusals = []

    async def all_of_them():
        for name in sorted(api.served) * 30:
            world.paused = False
            number = rng.integers(0, 10)
            given = tuple(ODD_VALUES[one] for one in rng.integers(0, len(ODD_VALUES), number))
            call = Call(call_id=1, method=name, arguments=given)
            try:
                await asyncio.wait_for(api.handle(call), 20.0)
            except AirsimError as error:
                refusals.append(f'{name}: {error}')
            await api.handle(Call(call_id=1, method='enableApiControl', arguments=(True, '')))

    asyncio.run(all_of_them())
    assert len(refusals) > 500
    assert [one for one in refusals if len(one) > 300] == []


@pytest.mark.slow
@pytest.mark.parametrize(
    ('calls', 'words'),
    [
        ([('ping', 1)], '1 parameters: must be 0'),
        ([('getMultirotorState', ['rav1'])], 'vehicle_name is .*rav1.*: must be a text'),
        ([('simGetImages', [{'image_type': 0}] * 65)], '65 images: must be 64 at most'),
        ([('simContinueForTime', 3e38)], 'must be within 0 and 3600'),
        ([('simSetWind', 3)], 'a Vector3r is 3: must be a map'),
        ([('simPlotPoints', [], [1.0], 1.0, 1.0, True)], 'color_rgba has 1 numbers: must have 4'),
        ([*LED, ('rotateToYaw', math.nan, 9.0, 5.0, '')], 'yaw is nan: must be a finite number'),
        ([('takeoff', 20, '')], 'enableApiControl first'),
        ([('moveByMotorPWMs', 1, 1, 1, 1, 1, '')], 'not served here'),
        ([('getRotorStates', 'rav2')], 'rav2 is a real vehicle: it tells nothing of its rotors'),
        ([('simSetCameraFov', '0', 30.0, 'rav2')], 'real vehicle'),
        ([('simSetCameraFov', '0', math.nan, '')], 'fov_degrees is nan'),
        ([('getMultirotorState', 'rav9')], 'there are rav1, rav2'),
        ([('simGetVehiclePose', 'rav2')], 'real vehicle'),
        ([('simGetImages', [{'camera_name': '0', 'image_type': 0}], 'rav2')], 'real vehicle'),
        ([('simGetImages', [{'camera_name': 'x', 'image_type': 0}])], "camera 'x' of rav1"),
        ([('simGetImages', [{'camera_name': '0', 'image_type': 7}])], 'image_type is 7'),
        ([('simGetImages', [{'camera_name': 'oblique', 'image_type': 1}])], 'no'),
        ([*LED, ('moveToPosition', 1.0, 1.0, 5.0, 5.0, 9, 0, ANY_YAW, -1, 1, '')], 'height_m'),
        ([*LED, ('moveToPosition', 1.0, 1.0, -5.0, 0.0, 9, 0, ANY_YAW, -1, 1, '')], 'velocity is'),
        ([*LED, ('moveByVelocity', 5.0, 0.0, 0.0, -9.0, 0, ANY_YAW, '')], 'duration is -9'),
        ([('getGasData', '', '')], 'no gas reading'),
        ([('simSetSegmentationObjectID', '[', 3, True)], 'no regular expression'),
        # Searches of hours.
        ([('simSetSegmentationObjectID', '(.*)*x', 3, True)], 'no repeated group'),
        ([('simListSceneObjects', '.*.*.*.*x')], '3 repeats at most'),
        ([*LED, ('moveToPosition', 1e9, 1.0, -5.0, 5.0, 9, 0, ANY_YAW, -1, 1, '')], 'within 1e'),
        ([*LED, ('moveByVelocity', math.nan, 0.0, 0.0, 9.0, 0, ANY_YAW, '')], 'within 1e'),
        ([*LED, ('moveByVelocityZ', 1.0, 0.0, math.inf, 9.0, 0, ANY_YAW, '')], 'within 1e'),
        ([('simSetSegmentationObjectID', 'drum', 300, False)], 'within 0 and 255'),
    ],
)
def test_what_cannot_be_done_is_refused_by_name(world, calls, words):
    """One line, with the limit where there is one."""
    with pytest.raises(AirsimError, match=words):
        ask(world, *calls)


def test_images_have_what_clients_read(world):
    """Sizes, forms, colours by instance; depth as floats in metres, the sky a large one."""
    requests = [
        {'camera_name': '0', 'image_type': 0, 'pixels_as_float': False, 'compress': False},
        {'camera_name': '0', 'image_type': 1, 'pixels_as_float': True, 'compress': False},
        {'camera_name': '0', 'image_type': 5, 'pixels_as_float': False, 'compress': False},
        {'camera_name': '0', 'image_type': 0, 'pixels_as_float': False, 'compress': True},
    ]
    scene, depth, segments, packed = ask(world, ('simGetImages', requests, ''))
    assert (scene['width'], scene['height']) == (4, 3)
    assert scene['image_data_uint8'] == PIXELS.tobytes()
    assert depth['image_data_float'].tolist()[1:] == DEPTH.ravel().tolist()[1:]
    assert depth['image_data_float'][0] == 65_504.0
    colours = np.frombuffer(segments['image_data_uint8'], np.uint8).reshape(12, 3)
    assert len({tuple(colour) for colour in colours.tolist()}) == 12
    assert packed['image_data_uint8'].startswith(b'\x89PNG')
    # The camera looks down: its pitch is -90 degrees in NED.
    w, y = scene['camera_orientation']['w_val'], scene['camera_orientation']['y_val']
    x, z = scene['camera_orientation']['x_val'], scene['camera_orientation']['z_val']
    assert math.asin(max(-1.0, min(1.0, 2 * (w * y - z * x)))) == pytest.approx(-math.pi / 2)


@pytest.mark.parametrize('name', ['', '0', '2', '4', 'front_left', 'back_center', 'camera'])
def test_the_cameras_that_every_vehicle_of_airsim_has_are_the_first(world, name):
    """By number and by name; the first has a depth, the other of this vehicle has none."""
    (found,) = ask(world, ('simGetImages', [{'camera_name': name, 'image_type': 1}]))
    assert (found['height'], found['width']) == DEPTH.shape


@pytest.mark.parametrize('name', ['5', 'high_res', 'fixed1'])
def test_a_camera_that_a_script_set_up_for_itself_is_refused(world, name):
    """With the names of those that there are."""
    with pytest.raises(AirsimError, match=f"camera '{name}' of rav1: has camera, oblique"):
        ask(world, ('simGetImages', [{'camera_name': name, 'image_type': 0}]))


def test_the_field_of_view_of_a_camera_is_told_as_it_is_set(world):
    """With the projection that follows of it."""
    ask(world, ('simSetCameraFov', '0', 40.0, ''))
    info = ask(world, ('simGetCameraInfo', '0', ''))
    assert info['fov'] == 40.0
    assert info['proj_mat']['matrix'][0][0] == pytest.approx(1.0 / math.tan(math.radians(20.0)))


def test_rotors_carry_the_vehicle_in_the_air_and_stand_on_the_ground(world):
    """Four alike bear the weight of 2 kg at 9.8 m/s2, and turn nobody."""
    on_ground = ask(world, ('getRotorStates', ''))
    assert [rotor['speed'] for rotor in on_ground['rotors']] == [0.0] * 4
    hovering = ask(world, *LED, ('getRotorStates', ''))
    assert hovering['timestamp'] == 7
    rotors = hovering['rotors']
    assert sum(rotor['thrust'] for rotor in rotors) == pytest.approx(2.0 * 9.80665)
    assert sum(rotor['torque_scaler'] for rotor in rotors) == pytest.approx(0.0)
    # Static tests of such propellers (10 x 4.7 inches): 5 N at some 5500 turns a minute.
    assert rotors[0]['speed'] * 60.0 / (2.0 * math.pi) == pytest.approx(5500.0, rel=0.1)
    # All shafts together take less than the motors do.
    shafts_w = sum(abs(rotor['torque_scaler']) * rotor['speed'] for rotor in rotors)
    assert 0.56 * HOVER_POWER_W < shafts_w < HOVER_POWER_W


def test_a_camera_is_turned_by_its_gimbal(world):
    """30 degrees down and 90 to the right; neither moved nor rolled."""

    def pose(roll, pitch, yaw, x=0.0):
        cr, sr = math.cos(roll / 2), math.sin(roll / 2)
        cp, sp = math.cos(pitch / 2), math.sin(pitch / 2)
        cy, sy = math.cos(yaw / 2), math.sin(yaw / 2)
        orientation = {
            'w_val': cr * cp * cy + sr * sp * sy, 'x_val': sr * cp * cy - cr * sp * sy,
            'y_val': cr * sp * cy + sr * cp * sy, 'z_val': cr * cp * sy - sr * sp * cy,
        }  # fmt: skip
        return {'position': {'x_val': x, 'y_val': 0.0, 'z_val': 0.0}, 'orientation': orientation}

    ask(world, ('simSetCameraPose', '0', pose(0.0, math.radians(-30.0), math.pi / 2), ''))
    camera, pitch_rad, yaw_rad = world.vehicles['rav1'].pointed
    assert camera == 'camera'
    assert (pitch_rad, yaw_rad) == pytest.approx((math.radians(-30.0), -math.pi / 2))
    for wrong, words in ((pose(0.3, 0, 0), 'roll is 17.2 deg'), (pose(0, 0, 0, 1.0), 'position')):
        with pytest.raises(AirsimError, match=words):
            ask(world, ('simSetCameraPose', '0', wrong, ''))


def test_segmentation_ids_are_chosen_by_name(world):
    """By a regular expression or the name; what is not there is -1."""
    assert ask(world, ('simGetSegmentationObjectID', 'WAGON_1')) == 3
    assert ask(world, ('simGetSegmentationObjectID', 'nothing')) == -1
    chosen = ('simSetSegmentationObjectID', 'wag.*', 20, True)
    assert ask(world, chosen, ('simGetSegmentationObjectID', 'wagon_1')) == 20
    assert ask(world, ('simSetSegmentationObjectID', 'x', 20, False)) is False
    assert ask(world, ('simListSceneObjects', '.*')) == ['wagon_1', 'drum']


@pytest.mark.slow
def test_a_loop_of_orders_is_obeyed_at_the_pace_of_the_vehicle(world):
    """As orbit sends them: the newest of those that came meanwhile; the others answer false."""
    api = Api(world, print)
    vehicle = world.vehicles['rav1']

    def ask_for(method, *arguments):
        return api.handle(Call(call_id=1, method=method, arguments=arguments))

    async def flood():
        for method, *arguments in LED:
            await ask_for(method, *arguments)
        moves = [
            ask_for('moveByVelocityZ', n / 40, 0.0, -3.0, 1, 0, {'is_rate': False,
                    'yaw_or_rate': 90.0}, '')
            for n in range(200)
        ]  # fmt: skip
        return await asyncio.gather(*moves)

    answers = asyncio.run(flood())
    assert answers.count(True) == 1
    assert answers[-1] is True
    assert vehicle.orders < 5
    assert vehicle.core.flight.command.velocity_enu[1] == pytest.approx(199 / 40)


@pytest.mark.slow
def test_a_velocity_upwards_takes_off(world):
    """As pause_continue_drone begins; one that is level stays refused on the ground."""
    calls = ('moveByVelocityZ', 0.0, 0.0, -9.0, 8.0, 0, ANY_YAW, '')
    state = ask(world, LED[0], calls, ('getMultirotorState', ''))
    assert position(state)[2] == pytest.approx(-9.0, abs=0.5)
    on_ground = World()
    Vehicle(on_ground, 'rav1', (0.0, 0.0, 0.0))
    with pytest.raises(AirsimError, match='disarmed'):
        ask(on_ground, LED[0], ('moveByVelocity', 1.0, 0.0, 0.0, 1.0, 0, ANY_YAW, ''))


@pytest.mark.slow
def test_reset_answers_when_the_vehicles_stand_at_home(world):
    """Also one that is landing already; what takes off then takes off from the ground."""
    core = world.vehicles['rav1'].core
    ask(world, *LED, ('reset',))
    assert (core.mode, world.vehicles['rav1'].leads) == (Mode.LANDED, False)
    ask(world, *LED)
    core.land()
    ask(world, LED[0], ('reset',))
    assert core.mode is Mode.LANDED
    ask(world, *LED)
    core.land()
    assert ask(world, *LED) is True
    assert core.mode is Mode.HOLDING


@pytest.mark.slow
def test_a_wait_ends_with_the_flight(world):
    """A battery that runs low brings the vehicle home: the movement answers false."""
    core = world.vehicles['rav1'].core
    core.airframe = replace(core.airframe, endurance_s=120.0)
    far = ('moveByVelocity', 0.05, 0.0, 0.0, 3000.0, 0, ANY_YAW, '')
    assert ask(world, *LED, far) is False
    assert core.mode is Mode.LANDED


def test_disarming_needs_no_control(world):
    """As hello_drone ends: after its reset."""
    assert ask(world, LED[0], ('reset',), ('armDisarm', False, '')) is True


def test_wind_is_set_for_all_simulated_vehicles(world):
    """North, east, down; not beside gas, which drifts with the scenario's wind."""
    ask(world, ('simSetWind', {'x_val': 4.0, 'y_val': 1.0, 'z_val': 0.0}))
    assert world.vehicles['rav1'].core.record.wind_mps == (1.0, 4.0)
    with pytest.raises(AirsimError, match='wind_mps is 90'):
        ask(world, ('simSetWind', {'x_val': 90.0, 'y_val': 0.0, 'z_val': 0.0}))
    world.vehicles['rav1'].smells = True
    with pytest.raises(AirsimError, match='a wind of its own'):
        ask(world, ('simSetWind', {'x_val': 1.0, 'y_val': 1.0, 'z_val': 0.0}))


def test_weather_counts_when_it_is_enabled(world):
    """What the scene does not draw is refused by its name, but may be switched off."""
    vehicle = world.vehicles['rav1']
    ask(world, ('simSetWeatherParameter', 7, 0.5))
    assert vehicle.light.fog == 0.0
    fog, wet = ('simSetWeatherParameter', 7, 0.5), ('simSetWeatherParameter', 1, 0.25)
    ask(world, ('simEnableWeather', True), fog, wet, ('simSetWeatherParameter', 0, 0.0))
    assert (vehicle.light.fog, vehicle.light.wetness) == (0.5, 0.25)
    ask(world, ('simEnableWeather', True), fog, ('simEnableWeather', False))
    assert vehicle.light.fog == 0.0
    for call, words in (
        (('simSetWeatherParameter', 0, 0.5), 'Rain is not drawn here'),
        (('simSetWeatherParameter', 7, 1.5), 'Fog is 1.5'),
        (('simSetWeatherParameter', 8, 0.5), 'parameter is 8'),
    ):
        with pytest.raises(AirsimError, match=words):
            ask(world, call)


def test_the_sun_follows_the_time_of_day(world):
    """In UTC, an hour less in summer time; without a time, from now."""
    vehicle = world.vehicles['rav1']
    ask(world, ('simSetTimeOfDay', True, '2025-06-01 18:00:00', True, 60.0, 30.0, True))
    assert (vehicle.light.sun_ns, vehicle.light.sun_speed) == (1_748_797_200_000_000_000, 60.0)
    ask(world, ('simSetTimeOfDay', True, '', False, 60.0, 30.0, False))
    assert (vehicle.light.sun_ns, vehicle.light.sun_speed) == (world.now_ns, 0.0)
    ask(world, ('simSetTimeOfDay', False, '', False, 1.0, 60.0, True))
    assert vehicle.light.sun_ns is None
    with pytest.raises(AirsimError, match='must be as 2025'):
        ask(world, ('simSetTimeOfDay', True, 'noon', False, 1.0, 60.0, True))


def test_things_that_stand_have_a_pose_about_the_first_vehicle(world):
    """It stands 10 m east and 2 m north of home, and looks east.

    What moves is refused; what is not there has no numbers in its pose, as scripts expect.
    """
    found = ask(world, ('simGetObjectPose', 'Wagon_1', True))
    assert found['position'] == {'x_val': 2.0, 'y_val': 10.0, 'z_val': -2.0}
    half = math.sqrt(0.5)
    assert found['orientation'] == pytest.approx(
        {'w_val': half, 'x_val': 0.0, 'y_val': 0.0, 'z_val': half}
    )
    with pytest.raises(AirsimError, match='moves'):
        ask(world, ('simGetObjectPose', 'drum'))
    nothing = ask(world, ('simGetObjectPose', 'nothing'))
    parts = [*nothing['position'].values(), *nothing['orientation'].values()]
    assert len(parts) == 7
    assert all(math.isnan(part) for part in parts)


def test_detections_are_boxes_of_the_wanted_instances_within_the_radius(world):
    """The label 3 is the last pixel of the first row, 49.3 m deep; instance 300 is not seen."""
    wanted = ('simAddDetectionFilterMeshName', '0', 0, 'Wagon*', '')
    assert ask(world, ('simGetDetections', '0', 0, '')) == []
    (found,) = ask(world, wanted, ('simGetDetections', '0', 0, ''))
    depth_m = float(DEPTH[0, 3])
    assert found['name'] == 'wagon_1'
    assert found['box2D'] == {key: {'x_val': 3.0, 'y_val': 0.0} for key in ('min', 'max')}
    ahead = found['relative_pose']['position']['x_val']
    assert ahead == pytest.approx(depth_m)
    # The camera looks down from 33 m, the top of its image to the east: right is south.
    east, north, up = world.to_enu(tuple(found['geo_point'].values()))
    slope = math.tan(math.radians(35.0)) / 2.0 * depth_m
    assert (east, north, up) == pytest.approx((1 + slope, 2 - 1.5 * slope, 33 - depth_m), abs=1e-3)
    near = ('simSetDetectionFilterRadius', '0', 0, 100.0 * (depth_m - 1.0), '')
    assert ask(world, wanted, near, ('simGetDetections', '0', 0, '')) == []
    gone = ('simClearDetectionMeshNames', '0', 0, '')
    assert ask(world, wanted, gone, ('simGetDetections', '0', 0, '')) == []


def test_time_is_paused_and_goes_on_for_some_seconds(world):
    """Nothing flies meanwhile."""
    ask(world, ('simPause', True))
    before = world.time_ns()
    assert ask(world, ('simIsPaused',)) is True
    assert world.time_ns() == before
    ask(world, ('simContinueForTime', 2.0))
    assert 2.0 <= (world.now_ns - before) / 1e9 <= 2.5
    assert world.paused


@pytest.mark.slow
def test_a_vehicle_is_placed_before_its_first_flight(world):
    """Its origin goes with it, as that of a start pose does."""
    pose = {'position': {'x_val': 5.0, 'y_val': 6.0, 'z_val': -4.0}, 'orientation': {}}
    with pytest.raises(AirsimError, match='enableApiControl first'):
        ask(world, ('simSetVehiclePose', pose, True, ''))
    ask(world, LED[0], ('simSetVehiclePose', pose, True, ''))
    assert world.vehicles['rav1'].origin.home_enu == world.vehicles['rav1'].core.home_enu
    assert world.vehicles['rav1'].core.home_enu[:2] == pytest.approx((-34.0, 30.0), abs=1e-6)
    with pytest.raises(AirsimError, match='has flown'):
        ask(world, *LED, ('simSetVehiclePose', pose, True, ''))


def test_poses_are_drawn_as_their_axes_with_their_names(world):
    """Ahead red, right green, down blue; one that looks east has its right to the south."""
    half = math.sqrt(0.5)
    pose = {
        'position': {'x_val': 1.0, 'y_val': 2.0, 'z_val': -3.0},
        'orientation': {'w_val': half, 'x_val': 0.0, 'y_val': 0.0, 'z_val': half},
    }
    red = [1.0, 0.0, 0.0, 1.0]
    ask(world, ('simPlotTransformsWithNames', [pose], ['camp'], 200.0, 5.0, 10.0, red, 1e300))
    *axes, (texts, _, size_m, _, duration_s) = world.drawn
    place = np.array([-38.0, 26.0, 3.0])
    for (lines, rgba, _, _, _), reach in zip(
        axes, ([2.0, 0.0, 0.0], [0.0, -2.0, 0.0], [0.0, 0.0, -2.0]), strict=True
    ):
        assert np.allclose(lines, [[place, place + reach]])
        assert sum(rgba) == 2.0
    assert texts[0][0] == 'camp'
    assert np.allclose(texts[0][1], place)
    assert (size_m, duration_s) == (1.0, 1e9)


def test_drawings_lie_in_the_frame_of_the_mission(world):
    """Lines of pairs; for ever or for some seconds."""
    points = [{'x_val': float(n), 'y_val': 0.0, 'z_val': -1.0} for n in range(4)]
    ask(world, ('simPlotLineList', points, [1.0, 0.0, 0.0, 1.0], 10.0, 3.0, False))
    ((lines, rgba, size_m, kind, duration_s),) = world.drawn
    assert lines[1][0] == pytest.approx((-40.0, 27.0, 1.0))
    assert (len(lines), rgba, size_m, kind, duration_s) == (2, (1, 0, 0, 1), 0.1, 'lines', 3.0)
