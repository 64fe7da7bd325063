# SPDX-License-Identifier: Apache-2.0
"""The drive of a ground vehicle in a mission: what each step waits for, and how it ends."""

from collections.abc import Iterable
from dataclasses import replace
from pathlib import Path

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_geo.evidence.place_marks import PlaceMark
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.action import DriveRoute
from rocsafe_interfaces.msg import EvidencePoint, GeoPoint
from rocsafe_orchestrator.mission.driving import MOST_PLANS, DriveEnd
from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Crew, Situation
from rocsafe_orchestrator.parameters.drive_goal import DriveSoFar, drive_goal
from rocsafe_scenario.scenario_file import read_scenario

SCENARIO = Path(__file__).parents[2] / 'config' / 'scenarios' / 'evidence.yaml'
CREW = Crew(vehicle_processes={'rav1': 'rav1'}, processes=frozenset({'rav1'}), driver='rgv1')
ASSESS, PLAN = Order(kind=OrderKind.ASSESS), Order(kind=OrderKind.PLAN_DRIVE)
DRIVE = Order(kind=OrderKind.DRIVE, vehicle='rgv1')
RETURN = Order(kind=OrderKind.RETURN, vehicle='rgv1')
CLOCK = Order(kind=OrderKind.RUN_CLOCK)
AT_HOME = Situation(ready=CREW.processes, is_driver_home=True)
UNSETTLED = Situation(ready=CREW.processes, is_driver_home=True, is_driver_unsettled=True)
UNDER_WAY = Situation(ready=CREW.processes)


class Rehearsal:
    """A mission whose survey has ended and whose map is written, with a clock of its own."""

    def __init__(self, faults: Iterable[str] = ()) -> None:
        self.mission = Mission(CREW, Deadlines())
        self.now_s = 100.0
        for fault in faults:
            self.mission.fault(fault)
        self.mission.enter(Phase.MAPPING)
        self.advance()
        self.mission.answered(Order(kind=OrderKind.SAVE_MOSAIC))
        self.advance()

    def advance(self, after_s: float = 0.1, situation: Situation = AT_HOME) -> list[Order]:
        """Let time pass and return the orders of that moment."""
        self.now_s += after_s
        return self.mission.advance(self.now_s, situation)

    def to_drive(self) -> 'Rehearsal':
        """Assess, plan, and have the route accepted."""
        self.advance()
        self.mission.answered(ASSESS)
        self.advance()
        self.mission.drive_planned()
        self.advance()
        self.mission.accepted(DRIVE)
        return self


def test_drive_follows_the_map_and_time_runs_only_while_it_lasts() -> None:
    """Assess, plan, drive, and then the products."""
    play = Rehearsal()
    assert play.mission.phase is Phase.DRIVING
    assert play.advance() == []  # the assessment was asked for
    play.mission.answered(ASSESS)
    assert play.advance() == [PLAN]
    play.mission.drive_planned()
    assert play.advance() == [DRIVE]
    play.mission.accepted(DRIVE)
    assert CLOCK in play.advance(situation=UNDER_WAY)
    play.mission.driven('')
    play.advance(situation=UNSETTLED)
    assert play.mission.phase is Phase.DRIVING
    play.advance()
    assert play.mission.phase is Phase.REPORTING
    assert play.mission.outcome is Phase.COMPLETE


def test_nothing_drives_after_a_survey_that_failed() -> None:
    """It would be planned on half a map."""
    play = Rehearsal(faults=['only 3 of 9 photographs are stored'])
    assert play.mission.phase is Phase.REPORTING
    assert 'no drive: the survey is not complete' in play.mission.remarks


def test_interrupted_drive_is_planned_anew_and_not_for_ever() -> None:
    """Then the vehicle comes home on its own tracks, and the mission has failed."""
    play = Rehearsal()
    for number in range(1, MOST_PLANS + 1):
        play.to_drive()
        play.mission.driven('blocked: a wall', DriveEnd.OUT_WITH_EVIDENCE_LEFT)
        assert play.mission.phase is Phase.DRIVING, number
    assert RETURN in play.advance(situation=UNDER_WAY)
    play.mission.answered(RETURN)
    play.advance(situation=UNDER_WAY)
    assert play.mission.phase is Phase.DRIVING
    play.advance(situation=AT_HOME)
    assert play.mission.phase is Phase.REPORTING
    assert play.mission.outcome is Phase.FAILED


def test_refusals_end_it_with_their_reason() -> None:
    """At home at once; out on the road after the way home."""
    play = Rehearsal()
    play.mission.answered(ASSESS)
    play.advance()
    play.mission.refused(PLAN, 'router: the dose budget is too small')
    play.advance()
    assert play.mission.phase is Phase.REPORTING
    assert play.mission.faults == ['router: the dose budget is too small']
    play = Rehearsal().to_drive()
    play.mission.driven('blocked: a wall', DriveEnd.OUT_WITH_EVIDENCE_LEFT)
    play.mission.answered(ASSESS)
    play.advance()
    play.mission.refused(PLAN, 'router: no way')
    assert RETURN in play.advance(situation=UNDER_WAY)


def test_vehicle_that_has_all_and_is_blocked_comes_home_on_its_own_tracks() -> None:
    """That is no fault: nothing is missing."""
    play = Rehearsal().to_drive()
    play.mission.driven('blocked: a person', DriveEnd.OUT_WITH_ALL)
    assert RETURN in play.advance(situation=UNDER_WAY)
    play.mission.answered(RETURN)
    play.advance(situation=AT_HOME)
    assert play.mission.phase is Phase.REPORTING
    assert play.mission.outcome is Phase.COMPLETE


def test_turn_back_is_a_fault_and_is_told() -> None:
    """The evidence was not taken."""
    play = Rehearsal().to_drive()
    play.mission.driven('turned back for its dose: 9 of 10 uSv are used')
    play.advance()
    assert play.mission.phase is Phase.REPORTING
    assert play.mission.faults == ['rgv1: turned back for its dose: 9 of 10 uSv are used']


@pytest.mark.parametrize('process', ['router', 'rgv1', 'localizer'])
def test_process_that_gives_up_ends_the_drive(process: str) -> None:
    """The products are still made."""
    play = Rehearsal().to_drive()
    play.mission.gave_up(process, 'has crashed 3 times')
    assert play.mission.phase is Phase.REPORTING
    assert process in play.mission.text


def test_router_that_is_started_again_is_asked_again() -> None:
    """Its request was lost with it."""
    play = Rehearsal()
    play.mission.answered(ASSESS)
    assert play.advance() == [PLAN]
    play.mission.accepted(PLAN)
    assert play.advance(60.0) == []
    play.mission.restarted('router', play.now_s)
    assert PLAN in play.advance()


def test_drive_that_never_begins_is_given_up() -> None:
    """After the time that a plan may take."""
    play = Rehearsal()
    play.advance()
    play.advance(Deadlines().plan_s + 1.0)
    play.advance()
    assert play.mission.phase is Phase.REPORTING
    assert 'no drive begun' in play.mission.text


def test_cancel_and_end_of_room_go_to_the_products() -> None:
    """Time stands still then, and the vehicle with it."""
    for end in (lambda m: m.cancel('by SIGINT'), lambda m: m.break_off('the disk is full')):
        play = Rehearsal().to_drive()
        end(play.mission)
        assert play.mission.phase is Phase.REPORTING
        assert not play.mission.phase.is_over


def test_goal_asks_for_what_is_left_within_what_is_left() -> None:
    """Named evidence, found sources and releases; from where it stands, back to its home."""
    scenario = read_scenario(SCENARIO)
    sources = [(GeoPosition(53.2798, -9.0633, 66.0), 9e4), (GeoPosition(53.28, -9.063, 66.0), 3e4)]
    releases = [(GeoPosition(53.2799, -9.0635, 66.0), 700.0)]
    first = drive_goal(scenario, sources, releases, DriveSoFar())
    assert first is not None
    assert [one.id for one in first.evidence] == [
        'wagon', 'ballast', 'source-1', 'source-2', 'release-1',
    ]  # fmt: skip
    assert first.evidence[-1].found_in == 'release 1: 700 g/s'
    assert first.end == []
    assert first.dose_budget_usv == scenario.ground_vehicle.dose_budget_usv
    here = GeoPoint(latitude=53.2797, longitude=-9.0635, altitude=66.0)
    result = DriveRoute.Result(
        evidence_taken=['wagon', 'source-1'], dose_usv=20.0, duration_s=600.0,
        position=here, blocked=[here],
    )  # fmt: skip
    again = drive_goal(scenario, sources, releases, DriveSoFar().after(result))
    assert again is not None
    assert [one.id for one in again.evidence] == ['ballast', 'source-2', 'release-1']
    assert again.dose_budget_usv == first.dose_budget_usv - 20.0
    assert again.endurance_s == first.endurance_s - 600.0
    assert again.start == here
    assert list(again.blocked) == [here]
    assert again.end[0].latitude == pytest.approx(scenario.ground_vehicle.home[0])
    spent = DriveRoute.Result(dose_usv=100.0, duration_s=1e5)
    empty = drive_goal(scenario, sources, releases, DriveSoFar().after(spent))
    # 0 would be the default.
    assert 0.0 < empty.dose_budget_usv < 0.01
    assert 0.0 < empty.endurance_s < 10.0
    rest = DriveRoute.Result(evidence_taken=['ballast', 'source-2', 'release-1'])
    assert drive_goal(scenario, sources, releases, DriveSoFar().after(result).after(rest)) is None


def test_found_evidence_keeps_its_name_when_the_assessment_changes() -> None:
    """One that was taken is not driven to again, whatever its number; what is new is."""
    scenario = read_scenario(SCENARIO)
    old = GeoPosition(53.2798, -9.0633, 66.0)
    moved, ghost = offset(old, 0.5, 1.0, 0.0), offset(old, -3.0, 2.0, 0.0)
    new = offset(old, 30.0, 0.0, 0.0)
    first = drive_goal(scenario, [(old, 3e4)], [], DriveSoFar())
    assert first is not None
    so_far = DriveSoFar().asked(first.evidence)
    again = drive_goal(scenario, [(new, 9e4), (ghost, 4e4), (moved, 2e4)], [], so_far)
    assert again is not None
    assert [one.id for one in again.evidence if one.found_in] == ['source-2', 'source-1']
    taken = so_far.after(DriveRoute.Result(evidence_taken=['source-1', 'wagon']))
    rest = drive_goal(scenario, [(ghost, 4e4), (moved, 2e4)], [], taken)
    assert rest is not None
    assert [one.id for one in rest.evidence] == ['ballast']


def test_marks_of_operators_are_driven_to_where_the_scenario_says_so() -> None:
    """With what they wrote; otherwise a mark is a note."""
    scenario = read_scenario(SCENARIO)
    mark = PlaceMark(position=GeoPosition(53.2798, -9.0633, 66.0), text='a bag', by='ann')
    without = drive_goal(scenario, [], [], DriveSoFar(), [mark])
    assert without is not None
    assert [one.id for one in without.evidence] == ['wagon', 'ballast']
    block = scenario.ground_vehicle.model_copy(update={'to_marks': True, 'dwell_s': 7.0})
    wanted = scenario.model_copy(update={'ground_vehicle': block})
    goal = drive_goal(wanted, [], [], DriveSoFar(), [mark])
    assert goal is not None
    (one,) = goal.evidence[2:]
    assert (one.id, one.kind, one.dwell_s) == ('operator-1', 'mark', 7.0)
    assert one.found_in == 'ann: a bag'


def test_things_of_labels_are_asked_for_once_and_then_by_name() -> None:
    """What was taken of them is left out; without a file of labels nothing is asked for."""
    scenario = read_scenario(SCENARIO)
    plain = drive_goal(scenario, [], [], DriveSoFar())
    assert plain is not None
    assert not plain.to_objects
    changes = {'labels_file': 'labels.tif', 'dwell_s': 7.0, 'evidence': ()}
    block = scenario.ground_vehicle.model_copy(update=changes)
    wanted = scenario.model_copy(update={'ground_vehicle': block})
    first = drive_goal(wanted, [], [], DriveSoFar())
    assert first is not None
    assert (first.to_objects, first.object_dwell_s) == (True, 7.0)
    drums = tuple(EvidencePoint(id=f'drum-{number}', kind='object') for number in (1, 2))
    so_far = replace(DriveSoFar(), objects=drums)
    taken = so_far.after(DriveRoute.Result(evidence_taken=['drum-1']))
    rest = drive_goal(wanted, [], [], taken)
    assert rest is not None
    assert not rest.to_objects
    assert [one.id for one in rest.evidence] == ['drum-2']
    assert drive_goal(wanted, [], [], replace(so_far, evidence=('drum-1', 'drum-2'))) is None
    unwanted = block.model_copy(update={'to_objects': False})
    assert (
        drive_goal(scenario.model_copy(update={'ground_vehicle': unwanted}), [], [], DriveSoFar())
        is None
    )
