# SPDX-License-Identifier: Apache-2.0
"""The node of the console: hears vehicles, and sends orders by the calls of the command line."""

import math
import time
from collections.abc import Iterator
from dataclasses import replace

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from geometry_msgs.msg import Point, TransformStamped, Vector3
from nav_msgs.msg import OccupancyGrid
from rclpy.action import ActionServer
from rclpy.node import Node
from sensor_msgs.msg import CompressedImage
from std_msgs.msg import ColorRGBA
from std_srvs.srv import Trigger
from test.console.test_video import jpeg_of
from test.orchestrator.test_fleet_verbs import Stand, Vehicle
from tf2_msgs.msg import TFMessage
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_console.console_node import ConsoleNode
from rocsafe_console.evidence.desk import Desk
from rocsafe_console.orders.order_book import Errand, Order, Outcome, Result, Target
from rocsafe_console.people.roles import Action
from rocsafe_console.picture.live import Live
from rocsafe_console.picture.picture import Picture
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition, ecef_m
from rocsafe_interfaces.action import DriveRoute, PlanGroundRoute
from rocsafe_interfaces.msg import AgentState, GroundRoute, MissionState, VehicleState
from rocsafe_ros.interfaces import calls, topics

DEADLINE_S = 60.0
SPEAK_S = 0.1
NAMES = ('rav1', 'rav2')


class Console:
    """The node under test beside vehicles and the node of the fleet's verbs."""

    def __init__(self, ros, folder, *, has_fleet: bool = True) -> None:
        self.ros = ros
        self.has_fleet = has_fleet
        self._spoken_s = -math.inf
        stand = Stand(ros, NAMES) if has_fleet else None
        self.vehicles = stand.vehicles if stand else {n: Vehicle(ros, n) for n in NAMES}
        self.others = [stand.verbs, stand.operator] if stand else []
        self.others += [vehicle.node for vehicle in self.vehicles.values()]
        self.live = Live(Picture(7))
        self.desk = Desk(folder)
        self.node = ConsoleNode(self.live, self.desk, context=ros.context)
        ros.executor.add_node(self.node)
        self.speaker = Node('speaker', context=ros.context)
        ros.executor.add_node(self.speaker)
        self.states = {
            name: topics.create_publisher(self.speaker, topics.STATE, name) for name in NAMES
        }
        self.mission = topics.create_publisher(self.speaker, topics.MISSION_STATE)
        ros.spin_until(lambda: self._is_ready(), DEADLINE_S)

    def _is_ready(self) -> bool:
        # One event is handled a turn: states sent each turn would hold up all else for ever.
        if time.monotonic() - self._spoken_s > SPEAK_S:
            self._spoken_s = time.monotonic()
            for name, state in self.states.items():
                state.publish(VehicleState(vehicle=name, state=VehicleState.FLYING))
        fleet = self.node.orders._fleet.values() if self.has_fleet else ()
        clients = [*fleet, *self.node.orders._calls.values()]
        # go_to is not served by these vehicles.
        ready = sum(client.service_is_ready() for client in clients)
        return len(self.live.picture.vehicles) == 2 and ready == len(clients) - 2

    def order(self, verb: Action, *names: str, user='anna', **more) -> dict[str, Result]:
        """Send an order and return the results by vehicle."""
        order = Order(
            request_id='a' * 32, session='s', user=user, verb=verb,
            revisions=dict.fromkeys(names, 1), **more,
        )  # fmt: skip
        found: list[tuple[Result, ...]] = []
        self.node.send_order(order, names, found.append)
        self.ros.spin_until(lambda: bool(found), DEADLINE_S)
        return {result.vehicle: result for result in found[0]}


@pytest.fixture
def console(ros, tmp_path, request) -> Iterator[Console]:
    """Return the console of two vehicles; without the node of the fleet for `False`."""
    console = Console(ros, tmp_path, has_fleet=getattr(request, 'param', True))
    yield console
    # All of them: the next test may be in the same domain.
    for node in (console.node, console.speaker, *console.others):
        ros.executor.remove_node(node)
        node.destroy_node()
    console.desk.close()


def told(console: Console, name: str) -> list[str]:
    """Return what a vehicle was told."""
    return console.vehicles[name].told


def test_an_order_to_all_reaches_each_and_tells_who_refuses(console):
    """One result a vehicle, whatever the others answer."""
    console.vehicles['rav2'].refusal = 'rav2: taken by its pilot'
    results = console.order(Action.HOLD, *NAMES)
    assert results['rav1'].outcome is Outcome.DONE
    assert results['rav2'] == Result(
        vehicle='rav2', outcome=Outcome.REFUSED, text='rav2: taken by its pilot'
    )
    assert [told(console, name) for name in NAMES] == [['hold'], ['hold']]


def test_a_vehicle_that_says_nothing_has_refused_nothing(console):
    """It may have obeyed: the page says that nobody knows."""
    console.vehicles['rav2'].fall_silent()
    results = console.order(Action.HOLD, *NAMES)
    assert [results[name].outcome for name in NAMES] == [Outcome.DONE, Outcome.SILENT]
    assert 'no answer within' in results['rav2'].text


@pytest.mark.parametrize('console', [False], indirect=True)
def test_without_the_node_of_the_fleet_the_vehicles_are_asked(console):
    """The hand on the fleet needs neither the orchestrator nor its verbs."""
    assert not console.node.orders._fleet[Action.RETURN].service_is_ready()
    assert console.order(Action.RETURN, 'rav1')['rav1'].outcome is Outcome.DONE
    assert told(console, 'rav1') == ['return_home']
    assert told(console, 'rav2') == []


def test_a_vehicle_is_taken_over_resumed_and_given_back(console):
    """Under a lease in the name of the operator, whom the page then shows."""
    assert console.order(Action.TAKE, 'rav1')['rav1'].outcome is Outcome.DONE
    vehicle = console.live.picture.vehicles['rav1']
    console.ros.spin_until(lambda: vehicle.holder.holder == 'anna@console', DEADLINE_S)
    assert console.order(Action.RESUME, 'rav1')['rav1'].outcome is Outcome.DONE
    assert told(console, 'rav1') == ['resume']
    assert console.order(Action.RELEASE, 'rav1')['rav1'].outcome is Outcome.DONE
    console.ros.spin_until(lambda: vehicle.holder.holder == '', DEADLINE_S)
    assert console.order(Action.RELEASE, 'rav1')['rav1'].outcome is Outcome.REFUSED


def test_nobody_gives_back_the_vehicle_of_another(console):
    """Its lease is renewed on, and its holder still gives it back."""
    assert console.order(Action.TAKE, 'rav1')['rav1'].outcome is Outcome.DONE
    result = console.order(Action.RELEASE, 'rav1', user='bert')['rav1']
    assert (result.outcome, result.text) == (Outcome.REFUSED, 'rav1: bert does not lead it')
    assert console.node.orders._held['rav1'].user == 'anna'
    assert console.order(Action.RELEASE, 'rav1')['rav1'].outcome is Outcome.DONE


def test_a_vehicle_that_cannot_be_reached_is_told(console):
    """Also of a verb that it does not serve."""
    target = Target(latitude_deg=53.0, longitude_deg=-9.0, height_m=50.0)
    result = console.order(Action.GO_TO, 'rav1', target=target)['rav1']
    assert (result.outcome, result.text) == (Outcome.REFUSED, 'rav1: cannot be reached')


def test_another_mission_is_another_picture(console):
    """The vehicles of the one before are forgotten until they are heard again."""
    seen = console.live.picture
    for name in ('first', 'second'):
        console.mission.publish(MissionState(mission_id=name, phase=MissionState.FLYING))
        console.ros.spin_until(
            lambda name=name: getattr(console.live.picture.mission, 'mission_id', '') == name,
            DEADLINE_S,
        )
    assert console.live.picture is not seen
    assert not console.live.picture.vehicles


def test_what_lies_in_the_frame_is_drawn_when_the_frame_is_known(console):
    """Zones and plume may be heard before the frame of the mission; an empty plume is none."""
    point = {'x': 30.0, 'y': 20.0}
    line = Marker(
        ns='AEGL-2 160 ppm outer', type=Marker.LINE_STRIP, action=Marker.ADD,
        color=ColorRGBA(r=1.0, g=0.5, b=0.0, a=1.0), points=[Point(), Point(**point)],
    )  # fmt: skip
    zones = topics.create_publisher(console.speaker, topics.THREAT_ZONES)
    # What makes no sense ends nothing: a line of no level, a map of no rows.
    senseless = Marker(ns='none', type=Marker.LINE_STRIP, points=[Point()])
    cordons = topics.create_publisher(console.speaker, topics.CORDONS)
    cordons.publish(MarkerArray(markers=[senseless]))
    doses = topics.create_publisher(console.speaker, topics.DOSE_MAP)
    doses.publish(OccupancyGrid(data=[1, 2, 3]))
    console.ros.spin_until(lambda: len(console.node._placed) == 2, DEADLINE_S)
    zones.publish(MarkerArray(markers=[Marker(action=Marker.DELETEALL), line]))
    plumes = topics.create_publisher(console.speaker, topics.PLUME)
    grid = OccupancyGrid(data=[0, 50])
    grid.info.width, grid.info.height, grid.info.resolution = 2, 1, 10.0
    plumes.publish(grid)
    frames = topics.create_publisher(console.speaker, topics.TF_STATIC)
    place = TransformStamped(child_frame_id='map')
    place.header.frame_id = 'earth'
    x, y, z = ecef_m(53.0, -9.0, 0.0)[0]
    place.transform.translation = Vector3(x=x, y=y, z=z)
    frames.publish(TFMessage(transforms=[place]))
    value = console.live.picture.sections.value
    console.ros.spin_until(lambda: bool(value('zones') and value('plume')), DEADLINE_S)
    (zone,) = value('zones')
    assert (zone['level'], zone['is_mean'], zone['colour']) == ('AEGL-2 160 ppm', False, '#ff8000')
    frame = LocalFrame(GeoPosition(53.0, -9.0, 0.0))
    assert frame.to_enu(*zone['ring'][1], 0.0)[0][:2] == pytest.approx((30.0, 20.0), abs=0.05)
    assert console.live.images['plume']
    plumes.publish(OccupancyGrid())
    console.ros.spin_until(lambda: value('plume') is None, DEADLINE_S)


def test_a_new_plan_is_asked_of_the_mission(console):
    """What it answers holds for each vehicle; without a mission that is said."""
    results = console.order(Action.REPLAN, *NAMES)
    assert {one.outcome for one in results.values()} == {Outcome.REFUSED}
    assert 'cannot be reached' in results['rav1'].text
    asked = []

    def on_replan(_request, response):
        asked.append('replan')
        response.success, response.message = False, 'cannot plan anew: nothing flies'
        return response

    console.speaker.create_service(Trigger, calls.REPLAN.name, on_replan)
    client = console.node.orders._mission[Action.REPLAN]
    console.ros.spin_until(client.service_is_ready, DEADLINE_S)
    results = console.order(Action.REPLAN, *NAMES)
    assert asked == ['replan'], 'once for all vehicles'
    assert {one.text for one in results.values()} == {'cannot plan anew: nothing flies'}


def test_a_camera_is_heard_only_while_somebody_looks(console):
    """The subscription begins with the first and ends with the last one."""
    video, spin = console.live.video, console.ros.spin_until
    camera = topics.create_publisher(console.speaker, topics.CAMERA_IMAGE_COMPRESSED, 'rav1')
    assert camera.get_subscription_count() == 0
    video.join('rav1')
    spin(lambda: camera.get_subscription_count() == 1, DEADLINE_S)
    camera.publish(CompressedImage(format='jpeg', data=jpeg_of(7)))
    spin(lambda: video.newest('rav1') is not None, DEADLINE_S)
    assert video.newest('rav1').jpeg == jpeg_of(7)
    video.leave('rav1')
    spin(lambda: camera.get_subscription_count() == 0, DEADLINE_S)


def test_the_live_view_of_the_scene_is_one_of_the_cameras(console):
    """Heard under a name of its own."""
    video, spin = console.live.video, console.ros.spin_until
    view = topics.create_publisher(console.speaker, topics.SCENE_VIEW)
    video.join('scene')
    spin(lambda: view.get_subscription_count() == 1, DEADLINE_S)
    view.publish(CompressedImage(format='jpeg', data=jpeg_of(9)))
    spin(lambda: video.newest('scene') is not None, DEADLINE_S)
    assert video.newest('scene').jpeg == jpeg_of(9)


class Rover:
    """A router and a ground vehicle that answer as they are told."""

    def __init__(self, console: Console) -> None:
        self.goals: list = []
        self.driven: list = []
        self.planning_error = self.refusal = ''
        self.node = console.speaker
        self._servers = [
            ActionServer(self.node, PlanGroundRoute, 'plan_ground_route', self._plan),
            ActionServer(self.node, DriveRoute, 'rav1/drive_route', self._drive),
        ]
        live = console.live.picture.vehicles
        console.ros.spin_until(lambda: live['rav1'].report.is_ground, DEADLINE_S)
        drives = console.node.orders.drives
        clients = [drives._router, *drives._vehicles.values()]
        console.ros.spin_until(lambda: all(c.server_is_ready() for c in clients), DEADLINE_S)

    def close(self) -> None:
        """Destroy the servers."""
        for server in self._servers:
            server.destroy()

    def _plan(self, handle):
        self.goals.append(handle.request)
        handle.succeed()
        if self.planning_error:
            error = PlanGroundRoute.Result.BEYOND_BUDGET
            return PlanGroundRoute.Result(error_code=error, error_msg=self.planning_error)
        route = GroundRoute(route_id='r1', vehicle='rav1', duration_s=184.0, dose_upper_usv=61.0)
        return PlanGroundRoute.Result(route=route)

    def _drive(self, handle):
        self.driven.append(handle.request)
        if self.refusal:
            handle.abort()
            rejected = DriveRoute.Result.REJECTED
            return DriveRoute.Result(outcome=rejected, error_msg=self.refusal)
        handle.publish_feedback(DriveRoute.Feedback())
        handle.succeed()
        return DriveRoute.Result()


def test_a_ground_vehicle_is_sent_by_the_route_that_was_offered(console):
    """From where it stands to the place and home, under the lease of who asks."""
    spin = console.ros.spin_until
    state = VehicleState(vehicle='rav1', state=VehicleState.LANDED)

    def speak() -> bool:
        console.states['rav1'].publish(state)
        return False

    timer = console.speaker.create_timer(SPEAK_S, speak)
    rover = Rover(console)
    console.live.picture.on_fix('rav1', (53.28, -9.0633, 60.0), 1.0, 1.0)
    errand = Errand(latitude_deg=53.2805, longitude_deg=-9.0633, dose_budget_usv=100.0)
    order = Order(
        request_id='a' * 32, session='s', user='anna', verb=Action.SEND,
        revisions={'rav1': 1}, target=errand,
    )  # fmt: skip
    offers: list = []
    console.node.plan_drive(order, lambda drive, why: offers.append((drive, why)))
    spin(lambda: bool(offers), DEADLINE_S)
    assert offers[0][0]['dose_upper_usv'] == 61.0
    goal = rover.goals[0]
    assert (goal.start.latitude, goal.dose_budget_usv) == (53.28, 100.0)
    assert [one.position.latitude for one in goal.evidence] == [53.2805]
    assert console.order(Action.TAKE, 'rav1')['rav1'].outcome is Outcome.DONE
    rover.refusal = 'rav1: the route begins 12 m from here'
    results = console.order(Action.SEND, 'rav1', target=errand)
    assert results['rav1'].text == rover.refusal
    assert rover.driven[0].lease == console.node.orders._held['rav1'].lease
    # What was offered once is driven once.
    assert 'cannot be reached' in console.order(Action.SEND, 'rav1', target=errand)['rav1'].text
    rover.refusal = ''
    console.node.plan_drive(order, lambda drive, why: offers.append((drive, why)))
    spin(lambda: len(offers) == 2, DEADLINE_S)
    assert console.order(Action.SEND, 'rav1', target=errand)['rav1'].outcome is Outcome.DONE
    rover.planning_error = 'a budget of 130 uSv would do'
    console.node.plan_drive(order, lambda drive, why: offers.append((drive, why)))
    spin(lambda: len(offers) == 3, DEADLINE_S)
    assert offers[2] == (None, 'router: a budget of 130 uSv would do')
    console.node.plan_drive(
        replace(order, revisions={'rav2': 1}), lambda drive, why: offers.append((drive, why))
    )
    spin(lambda: len(offers) == 4, DEADLINE_S)
    assert offers[3] == (None, 'rav2 does not drive')
    timer.cancel()
    rover.close()


def test_whom_an_agent_hears_is_shown_with_the_age_of_its_word(console):
    """Nothing is known of its age before the mission's clock is seen to run."""
    agents = topics.create_publisher(console.speaker, topics.AGENTS)
    state = AgentState(vehicle='rav1', heard=['rav1', 'rav2'])
    picture = console.live.picture

    def speak() -> bool:
        agents.publish(state)
        picture.refresh()
        return bool(picture.sections.value('contacts'))

    console.ros.spin_until(speak, DEADLINE_S)
    assert picture.sections.value('contacts') == {'rav1': {'hears': ['rav2'], 'heard_s': None}}
