# SPDX-License-Identifier: Apache-2.0
"""The orchestrator's ROS side, against servers that answer as they are told."""

import math
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.action import ActionServer, GoalResponse
from rclpy.node import Node
from rclpy.parameter import Parameter
from std_srvs.srv import SetBool, Trigger

from rocsafe_interfaces.action import FlyRoute, PlanSurvey
from rocsafe_interfaces.msg import (
    GeoPoint,
    MissionState,
    RadiationReading,
    Region,
    Route,
    ShotReceipt,
    StepDone,
    SurveyPlan,
    VehicleState,
    Viewpoint,
)
from rocsafe_interfaces.srv import FleetCommand, Lease, Resume, SuggestViewpoints
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission.status import FlightState, Monitor, RunStatus, VehicleStatus
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Situation
from rocsafe_orchestrator.orchestrator_node import OrchestratorNode
from rocsafe_orchestrator.process_table.table import crew_of, process_table
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.conversions import stamp_of_ns
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lease.server_node import LeaseServer
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario_file import read_scenario

DEADLINE_S = 60.0
# Nobody asks again while an answer is under way, however busy the machine is.
REPEAT_S = 10.0
ROUND = {'radiation.search.viewpoints_a_round': 3, 'radiation.search.extra_rounds': 1}
MISSION = new_identity('run')


class Servers(Node):
    """Planner, two vehicles, world and map maker that answer as they are told."""

    def __init__(self, **node_options: Any) -> None:
        rules = ['--ros-args', *MISSION.remapping_arguments]
        super().__init__('servers', cli_args=rules, **node_options)
        self.plan_error = ''
        self.outcomes = {'rav1': FlyRoute.Result.COMPLETED, 'rav2': FlyRoute.Result.COMPLETED}
        self.accepts = True
        self.breaks = ''
        self.saves = True
        self.asked: list[str] = []
        self.goals: list[PlanSurvey.Goal] = []
        self._actions = [ActionServer(self, PlanSurvey, 'plan_survey', self._plan)]
        for name in self.outcomes:
            self._actions.append(
                ActionServer(
                    self,
                    FlyRoute,
                    f'{name}/fly_route',
                    lambda handle, name=name: self._fly(name, handle),
                    goal_callback=self._judge,
                )
            )
        self.vehicle_nodes = {
            name: VehicleScopeNode('vehicle', namespace=f'/{name}', **node_options)
            for name in self.outcomes
        }
        self.leases = {name: LeaseServer(node, None) for name, node in self.vehicle_nodes.items()}
        self.create_service(FleetCommand, 'fleet/hold', lambda _request, answer: answer)
        self.create_service(SetBool, 'world/run', self._run)
        self.create_service(Trigger, 'mosaic/save', self._save)
        self.places: list[GeoPoint] = []
        self.evaluations_left = 0
        self.is_asked_too_early = False
        self.create_service(SuggestViewpoints, 'hazard/suggest_viewpoints', self._suggest)

    def destroy_node(self) -> None:
        """Destroy the node and its action servers."""
        for server in self._actions:
            server.destroy()
        for node in self.vehicle_nodes.values():
            node.destroy_node()
        super().destroy_node()

    def _plan(self, handle: Any) -> PlanSurvey.Result:
        self.goals.append(handle.request)
        if self.breaks == 'plan':
            raise RuntimeError('no memory')
        handle.succeed()
        if self.plan_error:
            return PlanSurvey.Result(
                error_code=PlanSurvey.Result.BEYOND_ENDURANCE, error_msg=self.plan_error
            )
        viewpoints = [Viewpoint(id=0), Viewpoint(id=1)]
        routes = [Route(vehicle='rav1', viewpoints=viewpoints), Route(vehicle='rav2')]
        plan_id = 'q' if handle.request.viewpoints else 'p'
        return PlanSurvey.Result(plan=SurveyPlan(plan_id=plan_id, routes=routes))

    def _judge(self, _request: Any) -> GoalResponse:
        return GoalResponse.ACCEPT if self.accepts else GoalResponse.REJECT

    def _fly(self, name: str, handle: Any) -> FlyRoute.Result:
        self.leases[name].require(handle.request.lease)
        self.asked.append(f'{name} {handle.request.plan_id}')
        if self.breaks == name:
            raise RuntimeError('no memory')
        handle.succeed()
        outcome = self.outcomes[name]
        return FlyRoute.Result(outcome=outcome, shots_taken=2, viewpoints_visited=2)

    def _run(self, request: Any, answer: Any) -> Any:
        self.asked.append(f'run {request.data}')
        answer.success = True
        return answer

    def _suggest(self, request: Any, answer: Any) -> Any:
        self.asked.append(f'{request.count} viewpoints')
        if self.evaluations_left:
            self.evaluations_left -= 1
            self.is_asked_too_early = True
            answer.status = answer.NOT_YET
            return answer
        answer.viewpoints, answer.reason = self.places, 'wide'
        return answer

    def _save(self, _request: Any, answer: Any) -> Any:
        answer.success, answer.message = self.saves, '' if self.saves else 'disk full'
        return answer


class Stage:
    """An orchestrator's node with its mission, among servers."""

    def __init__(self, ros: Any, scenario_path: Path, extra_rounds: int = 0) -> None:
        self.ros = ros
        self.scenario = read_scenario(scenario_path)
        self.table = process_table(self.scenario, RunDirectory(Path('run')))
        self.monitor = Monitor(self.scenario.vehicle_names)
        self.node = OrchestratorNode(self.scenario, self.monitor, MISSION, context=ros.context)
        self.mission = Mission(
            crew_of(self.scenario, self.table),
            Deadlines(repeat_s=REPEAT_S),
            extra_rounds=extra_rounds,
        )
        self._skipped_s = 0.0
        self.node.requests.begin(self.mission)
        self.servers = Servers(context=ros.context)
        vehicles = self.servers.vehicle_nodes.values()
        for node in (self.node, self.node.requester, self.servers, *vehicles):
            ros.executor.add_node(node)
        self.everybody = frozenset(spec.name for spec in self.table)
        self.until(lambda: all(map(self.is_server_ready, self.endpoints())))

    def endpoints(self) -> Iterator[Any]:
        """Return what has to be served."""
        return (e for spec in self.table for e in spec.readiness if e.kind != 'topic')

    def is_server_ready(self, endpoint: Any) -> bool:
        """Return whether the orchestrator reaches a server."""
        return self.node.requests.is_ready(endpoint)

    def until(self, condition: Callable[[], bool]) -> None:
        """Spin until a condition holds."""
        self.ros.spin_until(condition, DEADLINE_S)

    def advance_to(self, phase: Phase) -> None:
        """Carry out the mission's orders until it is in `phase`."""
        situation = Situation(ready=self.everybody, images_stored=2)

        def is_there() -> bool:
            if self.servers.is_asked_too_early:
                self.servers.is_asked_too_early = False
                self._skipped_s += REPEAT_S
            for order in self.mission.advance(time.monotonic() + self._skipped_s, situation):
                self.node.requests.send(order)
            return self.mission.phase is phase

        self.until(is_there)


@pytest.fixture
def stage(ros: Any, small: Callable[..., Path]) -> Iterator[Stage]:
    """Give a stage, and clear it afterwards."""
    made = Stage(ros, small())
    yield made
    made.servers.destroy_node()
    made.node.destroy_node()


@pytest.mark.parametrize(
    ('name', 'value', 'words'),
    [('plan_timeout_s', 5.0, 'is now fixed'), ('stall_timeout_s', 0.0, 'must be within 0.1 to')],
)
def test_wrong_parameter_is_refused_in_a_line(
    ros: Any, small: Callable[..., Path], name: str, value: float, words: str
) -> None:
    """A value out of its limits, or a parameter that there is no more, is named."""
    scenario = read_scenario(small())
    with pytest.raises(ScenarioError, match=f'orchestrator: parameter {name}.*{words}') as caught:
        OrchestratorNode(
            scenario, Monitor(scenario.vehicle_names), MISSION, context=ros.context,
            parameter_overrides=[Parameter(name, value=value)],
        )  # fmt: skip
    assert '\n' not in str(caught.value)


def test_orders_are_carried_out_up_to_the_report(stage: Stage) -> None:
    """Plan, flight of the routed vehicle, clock and map are asked for over ROS."""
    stage.advance_to(Phase.REPORTING)
    assert stage.mission.text == ''
    assert stage.servers.asked == ['rav1 p', 'run True']
    assert stage.monitor.images_expected == 2


def test_a_further_round_goes_to_the_places_wanted(ros: Any, small: Callable[..., Path]) -> None:
    """Asked again while readings are evaluated; the goal names the places and what is left."""
    stage = Stage(ros, small(ROUND), extra_rounds=1)
    try:
        stage.servers.places = [GeoPoint(latitude=53.28, longitude=-9.06, altitude=32.0)]
        stage.servers.evaluations_left = 1
        stage.advance_to(Phase.COLLECTING)
        assert stage.mission.text == ''
        assert stage.servers.asked == [
            'rav1 p', 'run True', '3 viewpoints', '3 viewpoints', 'rav1 q', 'run True'
        ]  # fmt: skip
        first, further = stage.servers.goals
        assert not first.viewpoints
        assert [place.latitude for place in further.viewpoints] == [53.28]
        assert stage.monitor.images_expected == 4
    finally:
        stage.servers.destroy_node()
        stage.node.destroy_node()


def test_planner_is_told_the_scenario(stage: Stage) -> None:
    """Region, fleet, camera and seed arrive in the units of the message."""
    stage.advance_to(Phase.FLYING)
    goal = stage.servers.goals[0]
    assert len(goal.region.boundary.points) == 4
    assert [vehicle.name for vehicle in goal.vehicles] == ['rav1', 'rav2']
    assert goal.vehicles[0].endurance_s == pytest.approx(1350.0)
    assert goal.camera.horizontal_fov_rad == pytest.approx(math.radians(60.0))
    coverage = goal.coverage
    assert (coverage.height_agl_m, coverage.spacing_rule) == (32.0, 'iou')
    assert coverage.overlap_fraction == 0.2


def test_refused_plan_is_told(stage: Stage) -> None:
    """The planner's reason becomes the mission's."""
    stage.servers.plan_error = 'route of rav2 is too long'
    stage.advance_to(Phase.REPORTING)
    assert stage.mission.text == 'planner: route of rav2 is too long'


def test_vehicle_that_somebody_else_leads_is_not_flown(stage: Stage) -> None:
    """A mission takes no lease over: the fault says who has the vehicle."""
    client = stage.servers.create_client(Lease, 'rav1/lease')
    stage.until(client.service_is_ready)
    client.call_async(Lease.Request(holder='anna', take_over=True))
    # The mission may have taken it before.
    stage.until(lambda: 'anna' in stage.servers.leases['rav1'].who)
    stage.advance_to(Phase.REPORTING)
    assert stage.servers.asked == []
    assert stage.mission.text.startswith('rav1: rav1 is led by anna for ')


def test_vehicle_that_was_taken_over_in_flight_is_left_alone(stage: Stage) -> None:
    """Neither held nor called home, whatever becomes of the mission: its operator decides."""
    for verb in ('hold', 'return_home'):
        name = f'rav1/{verb}'
        stage.servers.create_service(
            Trigger, name, lambda _request, answer: stage.servers.asked.append('a verb') or answer
        )
    stage.advance_to(Phase.COLLECTING)
    client = stage.servers.create_client(Lease, 'rav1/lease')
    stage.until(client.service_is_ready)
    client.call_async(Lease.Request(holder='anna', take_over=True))
    stage.until(lambda: stage.node.requests.led_by_others == {'rav1'})
    stage.servers.asked = []
    for kind in (OrderKind.HOLD, OrderKind.RETURN):
        stage.node.requests.send(Order(kind=kind, vehicle='rav1'))
    stage.node.requests.send(Order(kind=OrderKind.HOLD, vehicle='rav2'))
    end_s = time.monotonic() + 0.5
    stage.until(lambda: time.monotonic() > end_s)
    assert stage.servers.asked == []
    sighting = stage.monitor.sighting('rav1', 0.0, 0.0, is_led_by_others=True)
    assert sighting.taken_by == 'operator'


@pytest.mark.parametrize(
    ('real', 'state', 'told'),
    [
        ({'rav1'}, FlightState.HOLDING, True),
        ({'rav1'}, FlightState.FLYING, False),
        ({'rav1'}, FlightState.LANDED, False),
        (set(), FlightState.HOLDING, True),
        (set(), FlightState.WAITING, True),
        (set(), FlightState.RETURNING, False),
    ],
)
def test_vehicle_that_was_held_is_told_to_go_on(
    stage: Stage, real: set[str], state: FlightState, told: bool
) -> None:
    """Its route is joined, which moves nothing: it would hold until its battery is empty."""
    leases: list[str] = []

    def resume(request: Any, answer: Any) -> Any:
        leases.append(request.lease)
        answer.success = True
        return answer

    stage.servers.create_service(Resume, 'rav1/resume', resume)
    stage.advance_to(Phase.COLLECTING)
    stage.node.requests._real = real
    stage.monitor.on_vehicle(VehicleStatus(name='rav1', state=state))
    stage.node.requests.send(Order(kind=OrderKind.RESUME, vehicle='rav1'))
    end_s = time.monotonic() + 0.5
    stage.until(lambda: bool(leases) or time.monotonic() > end_s)
    for lease in leases:
        stage.servers.leases['rav1'].require(lease)
    assert len(leases) == told


def test_flight_with_a_fault_is_told(stage: Stage) -> None:
    """A vehicle that came back early makes the mission fail, after the map."""
    stage.servers.outcomes['rav1'] = FlyRoute.Result.BATTERY_LOW
    stage.advance_to(Phase.REPORTING)
    assert stage.mission.outcome is Phase.FAILED
    assert stage.mission.text.startswith('rav1: returned early to keep its reserve of battery')


@pytest.mark.parametrize(
    ('who', 'phase', 'words'),
    [
        ('plan', Phase.REPORTING, 'planner: broke off'),
        ('rav1', Phase.COLLECTING, 'rav1: broke off'),
    ],
)
def test_server_that_breaks_off_has_not_succeeded(
    stage: Stage, who: str, phase: Phase, words: str
) -> None:
    """Its empty result reads like a plan without routes, or like a flight as planned."""
    stage.servers.breaks = who
    stage.advance_to(phase)
    assert stage.mission.text.startswith(f'{words} with an error')


def test_refused_route_is_told(stage: Stage) -> None:
    """A vehicle that does not take its route is named."""
    stage.servers.accepts = False
    stage.advance_to(Phase.COLLECTING)
    assert stage.mission.text == 'rav1: request was not accepted'


def test_map_that_cannot_be_written_is_told(stage: Stage) -> None:
    """The map maker's reason becomes the mission's."""
    stage.servers.saves = False
    stage.advance_to(Phase.REPORTING)
    assert stage.mission.text == 'mosaic/save: disk full'


def test_an_operator_who_wants_a_new_plan_is_answered(stage: Stage) -> None:
    """Nothing flies yet: why not is said."""
    client = stage.servers.create_client(Trigger, calls.REPLAN.name)
    stage.until(client.service_is_ready)
    answer = client.call_async(Trigger.Request())
    stage.until(answer.done)
    assert not answer.result().success
    assert 'cannot plan anew' in answer.result().message


def test_what_nodes_say_is_gathered(stage: Stage) -> None:
    """States, readings and receipts reach the monitor."""
    state = topics.create_publisher(stage.servers, topics.STATE, 'rav1')
    reading = topics.create_publisher(stage.servers, topics.RADIATION, 'rav1')
    receipts = topics.create_publisher(stage.servers, topics.RECEIPTS)

    def is_gathered() -> bool:
        message = VehicleState(vehicle='rav1', state=VehicleState.FLYING, viewpoints_visited=3)
        state.publish(message)
        place = GeoPoint(latitude=53.28, longitude=-9.06, altitude=98.0)
        reading.publish(RadiationReading(dose_rate_usvh=5.0, position=place))
        nowhere = GeoPoint(latitude=math.nan, longitude=math.nan, altitude=math.nan)
        reading.publish(RadiationReading(dose_rate_usvh=9.0, position=nowhere))
        receipts.publish(ShotReceipt(shot_id='rav1-00000', status=ShotReceipt.STORED))
        receipts.publish(ShotReceipt(shot_id='rav1-00001', status=ShotReceipt.REJECTED))
        monitor = stage.monitor
        rav1 = monitor.vehicles[0]
        return (
            rav1.state is FlightState.FLYING
            and rav1.viewpoints_visited == 3
            and monitor.peak is not None
            and monitor.peak.dose_rate_usvh == 5.0
            and monitor.images_stored == 1
            and list(monitor.rejections) == ['rav1-00001']
        )

    stage.until(is_gathered)


def test_late_subscriber_gets_region_and_state(stage: Stage) -> None:
    """Region and mission state are latched."""
    stage.node.publish_region()
    stage.node.publish(RunStatus(phase=Phase.PLANNING, wall_time_s=3.0))
    regions: list[Region] = []
    states: list[MissionState] = []
    topics.create_subscription(stage.servers, topics.REGION, regions.append)
    topics.create_subscription(stage.servers, topics.MISSION_STATE, states.append)
    stage.until(lambda: bool(regions and states))
    assert regions[0].name == 'small'
    assert (states[0].phase, states[0].mission_id) == (MissionState.PLANNING, 'run')
    assert math.isnan(states[0].highest_dose_rate_usvh)


def test_who_holds_up_time_is_found(stage: Stage) -> None:
    """Those who have not done the newest step are waited for; if all have, it is the world."""
    steps = topics.create_publisher(stage.servers, topics.STEP_DONE)
    names = ('rav1', 'rav2')
    assert stage.node.waiting_for(names) == ()
    stage.node.watch_steps(True)

    next_s = 0.0

    def say(*reports: StepDone) -> None:
        nonlocal next_s
        if time.monotonic() >= next_s:
            next_s = time.monotonic() + 0.1
            for report in reports:
                steps.publish(report)

    def is_waiting_for(*expected: str, **done_ns: int) -> bool:
        say(*(StepDone(step=stamp_of_ns(t), participant=n) for n, t in done_ns.items()))
        return stage.node.waiting_for(names) == expected

    stage.until(lambda: is_waiting_for('rav2', rav1=200, rav2=100))
    stage.until(lambda: is_waiting_for('world', rav1=200, rav2=200))

    def has_left() -> bool:
        say(StepDone(participant='rav1', has_left=True))
        return stage.node.steps.is_left_out('rav1', 0.0)

    stage.until(has_left)
    stage.node.watch_steps(False)
    assert stage.node.waiting_for(names) == ()


def test_route_without_a_plan_is_not_flown(stage: Stage) -> None:
    """A route cannot be flown before there is a plan: the order is passed over."""
    stage.node.requests.send(Order(kind=OrderKind.FLY, vehicle='rav1'))
    assert stage.servers.asked == []


VEHICLE = """
import sys
import rclpy
from rclpy.action import ActionServer
from rclpy.node import Node
from rclpy.parameter import Parameter
from rocsafe_interfaces.action import FlyRoute

def fly(goal):
    goal.succeed()
    return FlyRoute.Result()

rclpy.init()
node = Node('vehicle')
ActionServer(node, FlyRoute, sys.argv[1], fly)
rclpy.spin(node)
"""
OPERATOR = """
import sys, time
from pathlib import Path
from rocsafe_interfaces.action import FlyRoute
from rocsafe_orchestrator.mission.status import Monitor
from rocsafe_orchestrator.orchestrator_node import OrchestratorNode, Spinner, ros_session
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_scenario.scenario_file import read_scenario

REPEAT_S = 3.0

def result_of(accepted):
    return accepted.result().get_result_async()

mission = new_identity('run')
with ros_session(mission):
    scenario = read_scenario(Path(sys.argv[1]))
    node = OrchestratorNode(scenario, Monitor(scenario.vehicle_names), mission)
    spinner, name = Spinner(node), scenario.vehicle_names[0]
    end = time.monotonic() + 60.0
    while node.count_publishers(f'/{name}/fly_route/_action/status') < 2:
        assert time.monotonic() < end, 'the vehicles are not found'
        spinner.spin_for(0.05)
    client = node.requests._vehicles[name]
    for _ in range(20):
        results, asked = [], 0.0
        while not any(result.done() for result in results):
            assert time.monotonic() < end, 'no answer'
            if time.monotonic() > asked + REPEAT_S:
                # The first may go to vehicles that are only half found.
                asked, sent = time.monotonic(), client.send_goal_async(FlyRoute.Goal())
                sent.add_done_callback(lambda done: results.append(result_of(done)))
            spinner.spin_for(0.05)
    spinner.close()
"""


def test_second_server_of_a_flight_ends_nothing(
    ros_domain_id: int, small: Callable[..., Path]
) -> None:
    """Two vehicles of one name: the first answer counts, the orchestrator lives."""
    path = small()
    action = f'{read_scenario(path).vehicle_names[0]}/fly_route'
    environment = {
        **os.environ,
        'PYTHONPATH': os.pathsep.join(filter(None, sys.path)),
        'ROS_DOMAIN_ID': str(ros_domain_id),
    }
    command = [sys.executable, '-c', VEHICLE, action]
    vehicles = [subprocess.Popen(command, env=environment) for _ in range(2)]
    try:
        done = subprocess.run(
            [sys.executable, '-c', OPERATOR, str(path)],
            env=environment, capture_output=True, text=True, timeout=120, check=False,
        )  # fmt: skip
    finally:
        for vehicle in vehicles:
            vehicle.kill()
            vehicle.wait()
    assert done.returncode == 0, done.stderr
    assert 'more than one action server' in done.stderr
