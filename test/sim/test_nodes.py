# SPDX-License-Identifier: Apache-2.0
"""World and vehicles as nodes: a flight over real topics, commands, photographs, restarts."""

import hashlib
import math
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from action_msgs.msg import GoalStatus
from diagnostic_msgs.msg import DiagnosticStatus
from rclpy.action import ActionClient
from std_srvs.srv import SetBool, Trigger
from test.sim.node_stand import (
    DEADLINE_S,
    FRAME,
    HOME_ENU,
    Operator,
    common,
    parameters,
    point,
    route,
)  # fmt: skip
from test.sim.vehicle_files import cameras_file, fleet_file

from rocsafe_geo.evidence import shot_store
from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import (
    GeoPoint,
    GeoPolygon,
    VehicleState,
)
from rocsafe_interfaces.srv import GoTo, PushFence, PushRally, Resume, SetHome, SetSpeed
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import ParameterError
from rocsafe_sim.fleet_node import FleetNode
from rocsafe_sim.rav.shared_parts import make_shared
from rocsafe_sim.rav_node import RavNode
from rocsafe_sim.vehicle_node import VehicleInterface


def test_route_is_flown_and_photographed(
    operator: Operator, world: Any, rav: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A goal ends completed, with feedback about every second and every photograph once."""
    # A receipt may be late on a busy machine: its photograph would come again.
    monkeypatch.setattr(shot_store, 'RESEND_S', 10.0 * DEADLINE_S)
    world('rav1', autostart=False, pause_when_idle=True)
    vehicle = rav()
    operator.gives_receipts = True
    shots = operator.store_shots()
    fixes, truths = operator.listen(topics.FIX), operator.listen(topics.GROUND_TRUTH_FIX)
    states = operator.listen(topics.STATE)
    feedback: list[Any] = []
    goal = operator.send(route(), feedback=feedback.append)
    assert goal.accepted
    operator.wait_until_heard(vehicle, topics.SHOT, topics.FIX, topics.GROUND_TRUTH_FIX)
    operator.call('world/run', SetBool.Request(data=True))
    ended = operator.wait(goal.get_result_async())
    assert ended.status == GoalStatus.STATUS_SUCCEEDED
    assert ended.result.outcome == FlyRoute.Result.COMPLETED
    assert ended.result.shots_taken == ended.result.viewpoints_visited == 4
    operator.ros.spin_until(lambda: len(shots) >= 4, DEADLINE_S)
    assert [shot.viewpoint_id for shot in shots] == [10, 11, 12, 13]
    assert len(feedback) == pytest.approx(ended.result.duration_s, abs=2)
    operator.ros.spin_until(lambda: states and states[-1].shots_pending == 0, DEADLINE_S)
    assert states[-1].state == VehicleState.LANDED
    operator.ros.spin_until(lambda: len(fixes) == len(truths), DEADLINE_S)
    stamps = [ns_of_stamp(fix.header.stamp) for fix in fixes]
    assert stamps == [ns_of_stamp(truth.header.stamp) for truth in truths]
    assert {b - a for a, b in pairwise(stamps)} == {200_000_000}
    operator.ros.spin_until(
        lambda: states[-1].distance_flown_m == pytest.approx(ended.result.distance_flown_m),
        DEADLINE_S,
    )


def test_photograph_says_where_it_was_taken(operator: Operator, world: Any, rav: Any) -> None:
    """Position, height, intrinsics and hash of a photograph are those of its viewpoint."""
    world('rav1')
    rav(gps_horizontal_std_m=0.0, gps_vertical_std_m=0.0)
    operator.gives_receipts = True
    shots = operator.store_shots()
    operator.fly(route(count=1))
    operator.ros.spin_until(lambda: bool(shots), DEADLINE_S)
    shot = shots[0]
    wanted = route(count=1).viewpoints[0].position
    assert shot.fix.latitude == pytest.approx(wanted.latitude, abs=1e-9)
    assert shot.fix.longitude == pytest.approx(wanted.longitude, abs=1e-9)
    assert shot.fix.altitude == pytest.approx(wanted.altitude, abs=1e-4)
    assert shot.height_agl_m == pytest.approx(20.0, abs=1e-4)
    assert shot.sha256 == hashlib.sha256(bytes(shot.image.data)).hexdigest()
    assert shot.camera_info.k[0] == pytest.approx(32.0 / math.tan(math.radians(30.0)))
    assert shot.header.frame_id == 'rav1/camera_optical'
    assert bytes(shot.image.data)[:2] == b'\xff\xd8'


def test_a_vehicle_without_cameras_visits_its_viewpoints(
    operator: Operator, world: Any, rav: Any, tmp_path: Path
) -> None:
    """It takes no photographs, and says so."""
    world('rav1')
    rav(cameras_file=cameras_file(tmp_path))
    states, shots = operator.listen(topics.STATE), operator.listen(topics.SHOT)
    ended = operator.fly(route(count=2))
    assert (ended.result.viewpoints_visited, ended.result.shots_taken) == (2, 0)
    operator.ros.spin_until(lambda: states[-1].state == VehicleState.LANDED, DEADLINE_S)
    assert (states[-1].viewpoints_visited, states[-1].shots_taken) == (2, 0)
    assert not shots


def test_commands_by_service(operator: Operator, world: Any, rav: Any) -> None:
    """hold, resume, return_home obey in flight; refused commands say why."""
    world('rav1', speed=20.0)
    rav()
    states, fixes = operator.listen(topics.STATE), operator.listen(topics.FIX)
    operator.ros.spin_until(lambda: bool(fixes), DEADLINE_S)
    assert operator.call('rav1/hold', Trigger.Request()).success
    refused = operator.order(Resume, 'resume')
    assert (refused.success, refused.message) == (False, 'rav1: cannot resume: disarmed')
    goal = operator.send(route())
    operator.ros.spin_until(lambda: states and states[-1].viewpoints_visited >= 1, DEADLINE_S)
    assert operator.call('rav1/hold', Trigger.Request()).success
    operator.ros.spin_until(
        lambda: states and states[-1].state == VehicleState.HOLDING, DEADLINE_S
    )
    assert operator.order(Resume, 'resume').success
    assert operator.call('rav1/return_home', Trigger.Request()).success
    ended = operator.wait(goal.get_result_async())
    assert ended.status == GoalStatus.STATUS_ABORTED
    assert ended.result.outcome == FlyRoute.Result.RETURNED_EARLY
    assert 'told to return home' in ended.result.error_msg


def test_verbs_of_a_real_vehicle_by_service(operator: Operator, rav: Any) -> None:
    """Home, fence, rally points, speed and a place to go to, as the bridge serves them."""
    rav(lock_step=False, fix_rate_hz=20.0)
    states, homes = operator.listen(topics.STATE), operator.listen(topics.HOME)
    moved = point((-10.0, 5.0, 0.0))
    assert operator.order(SetHome, 'set_home', position=moved).success
    operator.ros.spin_until(
        lambda: homes and homes[-1].longitude == pytest.approx(moved.longitude), DEADLINE_S
    )
    corners = [point((east, north, 0.0)) for east, north in ((-60, -60), (60, -60), (0, 90))]
    ring = GeoPolygon(points=corners)
    assert operator.order(PushFence, 'geofence/push', inclusions=[ring]).success
    rally = operator.order(PushRally, 'rallypoint/push', points=[moved], height_m=20.0)
    assert rally.success, rally.message
    far = point((90.0, 0.0, 0.0))
    refused = operator.order(PushRally, 'rallypoint/push', points=[far], height_m=20.0)
    assert refused.message == 'rav1: a rally point is outside of the fence'
    assert operator.order(SetSpeed, 'set_speed', speed_mps=2.0).message.startswith('rav1: cannot')
    wanted = route()
    wanted.home = moved
    operator.send(wanted)
    operator.ros.spin_until(lambda: states and states[-1].state == VehicleState.FLYING, DEADLINE_S)
    assert operator.order(SetSpeed, 'set_speed', speed_mps=4.0).success
    too_fast = operator.order(SetSpeed, 'set_speed', speed_mps=6.0)
    assert too_fast.message == 'rav1: speed_mps is 6 m/s: must be 0 to 5 m/s'
    outside = operator.order(GoTo, 'go_to', position=far, height_m=20.0)
    assert outside.message == 'rav1: cannot go there: the way leaves the fence'
    near = point((-10.0, 10.0, 0.0))
    assert operator.order(GoTo, 'go_to', position=near, height_m=20.0).success
    operator.ros.spin_until(lambda: states[-1].state == VehicleState.HOLDING, DEADLINE_S)
    assert states[-1].position.latitude == pytest.approx(near.latitude, abs=1e-6)


class Mast:
    """Surroundings with a mast on the way to the second viewpoint, as high as you like."""

    def ground_up_m(self, _east_m: float, _north_m: float) -> float:
        """Return level ground."""
        return 0.0

    def first_hit_m(self, *_beam: object) -> float:
        """Return that a beam hits nothing."""
        return math.inf

    def touched(self, place_enu: tuple[float, float, float], radius_m: float) -> str:
        """Return whether the mast is touched."""
        return 'mast' if math.dist(place_enu[:2], (4.0, 0.0)) < radius_m else ''


def test_a_collision_ends_the_goal(
    operator: Operator, world: Any, rav: Any, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The result names what was hit; the vehicle says that it has crashed, and nothing hangs."""
    monkeypatch.setattr(
        'rocsafe_sim.rav_node.make_shared',
        lambda options: replace(make_shared(options), surroundings=Mast()),
    )
    world('rav1', pause_when_idle=True)
    rav()
    states = operator.listen(topics.STATE)
    ended = operator.fly(route())
    assert ended.status == GoalStatus.STATUS_ABORTED
    assert ended.result.outcome == FlyRoute.Result.COLLISION
    assert ended.result.error_msg == 'collided: flew into mast after 1 viewpoints'
    operator.ros.spin_until(
        lambda: states and states[-1].state == VehicleState.CRASHED, DEADLINE_S
    )


def test_cancelled_goal_holds(operator: Operator, world: Any, rav: Any) -> None:
    """A cancelled goal ends cancelled at once and the vehicle stands in the air."""
    world('rav1', speed=20.0)
    rav()
    states = operator.listen(topics.STATE)
    goal = operator.send(route())
    operator.ros.spin_until(lambda: states and states[-1].state == VehicleState.FLYING, DEADLINE_S)
    operator.wait(goal.cancel_goal_async())
    ended = operator.wait(goal.get_result_async())
    assert ended.status == GoalStatus.STATUS_CANCELED
    assert ended.result.outcome == FlyRoute.Result.CANCELLED
    operator.ros.spin_until(
        lambda: states and states[-1].state == VehicleState.HOLDING, DEADLINE_S
    )


@pytest.mark.parametrize(
    ('change', 'reason'),
    [
        ({'vehicle': 'rav7'}, 'rav1: the route is for rav7'),
        ({'viewpoints': []}, 'has 0 viewpoints'),
        ({'home': GeoPoint(latitude=53.29, longitude=-9.06, altitude=60.0)}, 'm from home'),
        ({'home': GeoPoint(latitude=99.0, longitude=-9.06, altitude=60.0)}, 'latitude_deg is 99'),
    ],
)
def test_impossible_routes_are_refused(
    operator: Operator, world: Any, rav: Any, change: dict[str, Any], reason: str
) -> None:
    """The result names what is wrong; nothing takes off."""
    world('rav1', speed=10.0)
    rav()
    wrong = route()
    for field, value in change.items():
        setattr(wrong, field, value)
    client = ActionClient(operator.node, FlyRoute, 'rav1/fly_route')
    operator.ros.spin_until(client.server_is_ready, DEADLINE_S)
    goal = FlyRoute.Goal(route=wrong, plan_id='p', lease=operator.lease())
    goal = operator.wait(client.send_goal_async(goal))
    ended = operator.wait(goal.get_result_async())
    assert ended.status == GoalStatus.STATUS_ABORTED
    assert ended.result.outcome == FlyRoute.Result.REJECTED
    assert reason in ended.result.error_msg


def test_restarted_vehicle_continues(
    operator: Operator, world: Any, rav: Any, tmp_path: Path
) -> None:
    """Stopped in mid-air and started again, it lands as planned, no photograph lost or doubled.

    Its unacknowledged photographs are sent again by the new process.
    """
    world('rav1', speed=20.0)
    first = rav(spool_directory=str(tmp_path))
    states = operator.listen(topics.STATE)
    shots = operator.store_shots()
    operator.send(route())
    operator.ros.spin_until(lambda: len({s.shot_id for s in shots}) >= 2, DEADLINE_S)
    rav.stop(first)
    operator.gives_receipts = True
    shots.clear()
    rav(spool_directory=str(tmp_path))
    ended = operator.fly(route())
    assert ended.result.outcome == FlyRoute.Result.COMPLETED
    assert ended.result.viewpoints_visited == 4
    operator.ros.spin_until(lambda: states and states[-1].shots_pending == 0, DEADLINE_S)
    assert {s.shot_id for s in shots} == {f'rav1-{number:05d}' for number in range(4)}
    assert {path.name for path in tmp_path.iterdir()} == {'journal.json', 'lease.json', 'steps'}


def make_fleet(ros: Any, folder: Path, names: str) -> FleetNode:
    """Return a fleet of vehicles at one home."""
    home = FRAME.position_of(HOME_ENU)
    homes = dict.fromkeys(names, (home.latitude_deg, home.longitude_deg))
    values = {**common(folder), 'fleet_file': fleet_file(folder, homes)}
    return FleetNode(context=ros.context, parameter_overrides=parameters(**values))


def test_fleet_flies_many_in_one_process(
    ros: Any, operator: Operator, world: Any, tmp_path: Path
) -> None:
    """Vehicles of a fleet have namespaces of their own and one participant."""
    world('fleet', autostart=False)
    fleet = make_fleet(ros, tmp_path, 'abc')
    nodes = [fleet, *fleet.vehicle_nodes]
    for node in nodes:
        ros.executor.add_node(node)
    goals = [operator.send(route(name)) for name in 'abc']
    operator.call('world/run', SetBool.Request(data=True))
    results = [operator.wait(goal.get_result_async()).result for goal in goals]
    assert {result.outcome for result in results} == {FlyRoute.Result.COMPLETED}
    assert len({result.duration_s for result in results}) == 1
    for node in nodes:
        node.destroy_node()


def test_a_vehicle_is_commanded_in_the_middle_of_a_step_of_its_fleet(
    ros: Any, operator: Operator, world: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """It is held at the time of the step, which tells of the hold, and has not ended yet."""
    world('fleet', autostart=False)
    fleet = make_fleet(ros, tmp_path, 'ab')
    nodes = [fleet, *fleet.vehicle_nodes]
    for node in nodes:
        ros.executor.add_node(node)
    states = operator.listen(topics.STATE, 'b')
    fixes = operator.listen(topics.GROUND_TRUTH_FIX, 'b')
    assert operator.send(route('b')).accepted
    operator.call('world/run', SetBool.Request(data=True))
    operator.ros.spin_until(
        lambda: fixes and states and states[-1].state == VehicleState.FLYING, DEADLINE_S
    )
    publish, waits = VehicleInterface.publish, [True]

    def publish_later(interface: VehicleInterface) -> None:
        if waits[0]:
            fleet._waiting.append(interface.publish)
        else:
            publish(interface)

    monkeypatch.setattr(VehicleInterface, 'publish', publish_later)
    operator.ros.spin_until(lambda: len(fleet._waiting) == 2, DEADLINE_S)
    step_ns = fleet.get_clock().now().nanoseconds
    assert operator.call('b/hold', Trigger.Request()).success

    def since(messages: list[Any]) -> list[Any]:
        return [one for one in messages if ns_of_stamp(one.header.stamp) >= step_ns]

    operator.ros.spin_until(lambda: since(states), DEADLINE_S)
    assert not since(fixes)
    waits[0] = False
    operator.ros.spin_until(lambda: len(since(fixes)) > 20, DEADLINE_S)
    assert {state.state for state in since(states)} == {VehicleState.HOLDING}
    first = [ns_of_stamp(since(messages)[0].header.stamp) for messages in (states, fixes)]
    assert first == [step_ns, step_ns]
    for node in nodes:
        node.destroy_node()


def test_without_lock_step_the_wall_clock_steps(operator: Operator, rav: Any) -> None:
    """Alone, a vehicle lives in real time and still stamps multiples of its fix period."""
    rav(lock_step=False, fix_rate_hz=20.0)
    fixes = operator.listen(topics.FIX)
    operator.ros.spin_until(lambda: len(fixes) >= 3, DEADLINE_S)
    assert all(ns_of_stamp(fix.header.stamp) % 50_000_000 == 0 for fix in fixes)


def test_world_names_who_it_waits_for(operator: Operator, world: Any, rav: Any) -> None:
    """A participant that is not there is named in its health; the others do not hang."""
    node = world('rav1', 'missing')
    vehicle = rav()
    operator.ros.spin_until(lambda: node.health()[0].message == 'waits for missing', DEADLINE_S)
    assert node.health()[0].level == DiagnosticStatus.WARN
    assert [told.name for told in vehicle.health()] == ['', 'rav1']


def test_world_shows_its_scene(operator: Operator, world: Any) -> None:
    """The latched markers name the things of the scene."""
    world(scene='derailment')
    heard: list[Any] = []
    topics.create_subscription(operator.node, topics.SCENE_MARKERS, heard.append)
    operator.ros.spin_until(lambda: bool(heard), DEADLINE_S)
    assert {'locomotive', 'tank_car_1', 'farm_house'} <= {m.text for m in heard[0].markers}


@pytest.mark.parametrize(
    ('values', 'reason'),
    [
        ({'scene': 'mars'}, "scene is 'mars'"),
        ({'cruise_speed_mps': -1.0}, 'cruise_speed_mps'),
        ({'ground': '/nowhere/photo.tif'}, '/nowhere/photo.tif'),
        ({'cameras': ({'horizontal_fov_deg': 149.0},)}, 'must be 0 to 70 deg'),
        ({'cameras': ({'horizontal_fov_deg': 4.0},)}, r'cameras\[0\]: horizontal_fov_deg is 4'),
        ({'autopilot_file': '/nowhere.yaml'}, '/nowhere.yaml'),
        ({'image_width_px': 64}, 'image_width_px is now image_width_px of a camera in the file'),
        ({'jerk_mps3': 5.0}, 'jerk_mps3 is now jerk_mps3 in the file that autopilot_file names'),
    ],
)
def test_wrong_parameters_are_refused(rav: Any, values: dict[str, Any], reason: str) -> None:
    """One line names parameter, value and limit."""
    with pytest.raises(ParameterError, match=reason):
        rav(**values)


def test_vehicle_needs_a_namespace(ros: Any) -> None:
    """Without one it has no name."""
    with pytest.raises(ParameterError, match='namespace'):
        RavNode(context=ros.context)
