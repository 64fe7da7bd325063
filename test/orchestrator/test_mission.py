# SPDX-License-Identifier: Apache-2.0
"""The phases of a mission: what each waits for, what is asked again, how failures end."""

from collections.abc import Iterable

import pytest

from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Crew, Situation

PROCESSES = frozenset(
    {'planner', 'world', 'mosaic', 'collector', 'recorder', 'radiation_field', 'rav1', 'rav2'}
)
CREW = Crew(vehicle_processes={'rav1': 'rav1', 'rav2': 'rav2'}, processes=PROCESSES)
PLAN = Order(kind=OrderKind.PLAN)
CLOCK = Order(kind=OrderKind.RUN_CLOCK)
MOSAIC = Order(kind=OrderKind.SAVE_MOSAIC)
ADVISE = Order(kind=OrderKind.ADVISE)
PRODUCTS = Order(kind=OrderKind.WRITE_PRODUCTS)
FLY_1, FLY_2 = (Order(kind=OrderKind.FLY, vehicle=name) for name in ('rav1', 'rav2'))
ALL_READY = Situation(ready=PROCESSES)


class Rehearsal:
    """A mission with a clock of its own."""

    def __init__(self, deadlines: Deadlines | None = None, extra_rounds: int = 0) -> None:
        self.mission = Mission(CREW, deadlines or Deadlines(), extra_rounds=extra_rounds)
        self.now_s = 100.0

    def is_in(self, phase: Phase) -> bool:
        """Return whether the mission is in `phase`."""
        return self.mission.phase is phase

    def advance(self, after_s: float = 0.0, situation: Situation = ALL_READY) -> list[Order]:
        """Let time pass and return the orders of that moment."""
        self.now_s += after_s
        return self.mission.advance(self.now_s, situation)

    def to_planning(self) -> 'Rehearsal':
        """Bring the processes up."""
        self.advance()
        return self

    def to_flying(self, routed: Iterable[str] = ('rav1', 'rav2')) -> 'Rehearsal':
        """Plan."""
        self.to_planning().mission.planned(routed)
        self.advance()
        return self

    def to_airborne(self) -> 'Rehearsal':
        """Have both routes accepted and time running."""
        self.to_flying()
        for order in (FLY_1, FLY_2):
            self.mission.accepted(order)
        self.advance(0.1)
        self.mission.answered(CLOCK)
        self.advance(0.1)
        return self

    def to_collecting(self) -> 'Rehearsal':
        """Land both with three photographs each."""
        self.to_airborne()
        for vehicle in ('rav1', 'rav2'):
            self.mission.flown(vehicle, 3)
        self.advance(0.1)
        return self

    def to_mapping(self) -> 'Rehearsal':
        """Store all photographs."""
        self.to_collecting()
        self.advance(0.1, stored(6))
        return self

    def to_reporting(self) -> 'Rehearsal':
        """Write the mosaic."""
        self.to_mapping().advance()
        self.mission.answered(MOSAIC)
        self.advance()
        return self


def stored(images: int, rejected: int = 0) -> Situation:
    """Return a situation with photographs in the store."""
    return Situation(ready=PROCESSES, images_stored=images, images_rejected=rejected)


def at_time(simulated_s: float, waiting_for: tuple[str, ...] = ()) -> Situation:
    """Return a situation at a simulated time."""
    return Situation(ready=PROCESSES, simulated_s=simulated_s, waiting_for=waiting_for)


def test_mission_passes_through_all_phases() -> None:
    """When all goes well the mission is complete, and each order was given once."""
    rehearsal = Rehearsal().to_reporting()
    assert rehearsal.is_in(Phase.REPORTING)
    assert rehearsal.advance() == [PRODUCTS]
    rehearsal.mission.answered(PRODUCTS)
    assert rehearsal.advance() == []
    assert rehearsal.is_in(Phase.COMPLETE)
    assert rehearsal.mission.text == ''


def test_planning_waits_for_every_process() -> None:
    """Nothing is asked before the last process is ready."""
    rehearsal = Rehearsal()
    assert rehearsal.advance(situation=Situation(ready=PROCESSES - {'rav2'})) == []
    assert rehearsal.is_in(Phase.STARTING)
    assert rehearsal.advance(1.0) == [PLAN]
    assert rehearsal.is_in(Phase.PLANNING)


def test_processes_that_never_get_ready_are_named() -> None:
    """At the deadline the mission fails and names whom it waited for."""
    rehearsal = Rehearsal()
    situation = Situation(ready=PROCESSES - {'rav2', 'mosaic'})
    rehearsal.advance(situation=situation)
    rehearsal.advance(180.1, situation)
    assert rehearsal.mission.text == 'mosaic, rav2: not ready within 180 s'
    assert rehearsal.is_in(Phase.REPORTING)


def test_time_starts_when_all_routes_are_accepted() -> None:
    """Vehicles take off together: the clock stands still until the last has its route."""
    rehearsal = Rehearsal()
    rehearsal.to_planning().mission.planned(['rav1', 'rav2'])
    assert rehearsal.advance() == [FLY_1, FLY_2]
    rehearsal.mission.accepted(FLY_1)
    assert CLOCK not in rehearsal.advance(0.1)
    rehearsal.mission.accepted(FLY_2)
    assert rehearsal.advance(0.1) == [CLOCK]


def test_unanswered_request_is_repeated_ever_more_rarely() -> None:
    """A request that got lost is sent again after 2, 4, 8 s."""
    rehearsal = Rehearsal()
    rehearsal.advance()
    rehearsal.advance()
    repeats = [second for second in range(1, 20) if rehearsal.advance(1.0, ALL_READY) == [PLAN]]
    assert repeats == [2, 6, 14]


def test_accepted_request_is_not_repeated() -> None:
    """A server that works on a request is left in peace."""
    rehearsal = Rehearsal().to_planning()
    rehearsal.mission.accepted(PLAN)
    assert [rehearsal.advance(1.0) for _ in range(20)] == [[]] * 20


@pytest.mark.parametrize(
    ('process', 'order'), [('rav1', FLY_1), ('rav2', FLY_2)], ids=['rav1', 'rav2']
)
def test_restarted_vehicle_gets_its_route_again(process: str, order: Order) -> None:
    """The route is sent again, and time is started again once it is accepted."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.restarted(process, rehearsal.now_s)
    assert order in rehearsal.advance(0.1)
    rehearsal.mission.accepted(order)
    assert rehearsal.is_in(Phase.FLYING)


def test_restarted_planner_is_asked_again() -> None:
    """A planner that died over its work gets the request again."""
    rehearsal = Rehearsal().to_planning()
    rehearsal.mission.accepted(PLAN)
    rehearsal.mission.restarted('planner', rehearsal.now_s)
    assert rehearsal.advance(0.1) == [PLAN]


def test_restarted_world_is_started_again() -> None:
    """A new world stands still until it is told to run."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.restarted('world', rehearsal.now_s)
    assert rehearsal.advance(0.1) == [CLOCK]


def test_restarted_mosaic_is_asked_again() -> None:
    """A map maker that died over its work gets the request again."""
    rehearsal = Rehearsal().to_mapping()
    assert rehearsal.advance() == [MOSAIC]
    rehearsal.mission.restarted('mosaic', rehearsal.now_s)
    assert rehearsal.advance(0.1) == [MOSAIC]


def test_landed_vehicle_is_not_asked_again() -> None:
    """The route of a vehicle that has landed is flown, whatever becomes of its process."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.flown('rav1', 3)
    rehearsal.mission.restarted('rav1', rehearsal.now_s)
    assert FLY_1 not in rehearsal.advance(0.1)


def test_standstill_names_the_node_waited_for() -> None:
    """Simulated time that does not move for 30 s fails the mission and says who is to blame."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.advance(1.0, at_time(50.0))
    rehearsal.advance(29.0, at_time(50.0, ('rav2',)))
    assert rehearsal.mission.stalled_s == pytest.approx(29.0)
    assert rehearsal.is_in(Phase.FLYING)
    rehearsal.advance(2.0, at_time(50.0, ('rav2',)))
    assert rehearsal.mission.text == 'simulated time stands still for 31 s: waits for rav2'
    assert rehearsal.mission.outcome is Phase.FAILED


def test_restart_gives_a_standstill_new_patience() -> None:
    """While a process is restarted simulated time may stand still."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.advance(1.0, at_time(50.0))
    rehearsal.mission.restarted('radiation_field', rehearsal.now_s + 29.0)
    rehearsal.advance(50.0, at_time(50.0))
    assert rehearsal.is_in(Phase.FLYING)


def test_route_that_nobody_accepts_fails() -> None:
    """A vehicle that does not answer is named at the deadline."""
    rehearsal = Rehearsal().to_flying()
    rehearsal.mission.accepted(FLY_1)
    rehearsal.advance()
    rehearsal.advance(31.0)
    assert rehearsal.mission.text == 'rav2: did not accept to fly the route within 30 s'


def test_plan_without_routes_needs_no_flight() -> None:
    """Vehicles without viewpoints stay on the ground."""
    rehearsal = Rehearsal()
    rehearsal.to_planning().mission.planned(['rav2'])
    assert rehearsal.advance() == [FLY_2]


def test_failed_flight_fails_the_mission_but_keeps_its_images() -> None:
    """The others fly on, the map is made, and the mission is not complete."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.flown('rav1', 1, 'returned early to keep its reserve')
    assert rehearsal.is_in(Phase.FLYING)
    rehearsal.mission.flown('rav2', 3)
    rehearsal.advance(0.1)
    rehearsal.advance(0.1, stored(4))
    assert rehearsal.is_in(Phase.MAPPING)
    assert rehearsal.mission.outcome is Phase.FAILED
    assert rehearsal.mission.text == 'rav1: returned early to keep its reserve'


def test_collecting_waits_for_every_photograph() -> None:
    """The map is made when the last photograph is safe."""
    rehearsal = Rehearsal().to_collecting()
    rehearsal.advance(1.0, stored(5))
    assert rehearsal.is_in(Phase.COLLECTING)
    rehearsal.advance(1.0, stored(6))
    assert rehearsal.is_in(Phase.MAPPING)
    assert rehearsal.mission.outcome is Phase.COMPLETE


@pytest.mark.parametrize('situation', [stored(5), stored(5, rejected=1)], ids=['lost', 'rejected'])
def test_missing_photograph_is_counted(situation: Situation) -> None:
    """A photograph that does not come, or is refused, fails the mission after the map."""
    rehearsal = Rehearsal().to_collecting()
    rehearsal.advance(1.0, situation)
    rehearsal.advance(31.0, situation)
    assert rehearsal.is_in(Phase.MAPPING)
    assert rehearsal.mission.text == 'only 5 of 6 photographs are stored'


def test_refused_plan_ends_the_mission_with_its_reason() -> None:
    """Without a plan nothing flies."""
    rehearsal = Rehearsal().to_planning()
    rehearsal.mission.refused(PLAN, 'planner: route of rav2 needs 2000 s, has 1500 s')
    rehearsal.advance()
    assert rehearsal.is_in(Phase.REPORTING)
    assert rehearsal.mission.text == 'planner: route of rav2 needs 2000 s, has 1500 s'


@pytest.mark.parametrize(
    ('process', 'phase'), [('rav2', Phase.MAPPING), ('mosaic', Phase.REPORTING)]
)
def test_process_that_is_given_up_fails_the_mission(process: str, phase: Phase) -> None:
    """What was photographed is still mapped, unless it is the map maker that failed."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.gave_up(process, 'was ended by SIGSEGV')
    assert rehearsal.is_in(phase)
    assert rehearsal.mission.text == f'{process} was ended by SIGSEGV'
    assert rehearsal.mission.outcome is Phase.FAILED


def test_products_that_cannot_be_written_fail_the_mission() -> None:
    """A mission without its report is not complete."""
    rehearsal = Rehearsal().to_reporting()
    rehearsal.advance()
    rehearsal.mission.gave_up('report', 'ended with exit code 1: disk full')
    rehearsal.advance()
    assert rehearsal.is_in(Phase.FAILED)
    assert rehearsal.mission.text == 'the products: ended with exit code 1: disk full'


def test_cancelled_mission_makes_its_products_quickly_or_not_at_all() -> None:
    """After Ctrl-C the products have a minute."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.cancel('interrupted by Ctrl-C')
    rehearsal.mission.cancel('interrupted by Ctrl-C')
    assert rehearsal.advance(0.1) == [PRODUCTS]
    rehearsal.advance(60.1)
    assert rehearsal.is_in(Phase.CANCELLED)
    assert rehearsal.mission.text.startswith('interrupted by Ctrl-C; the products were not')


def test_cancelled_flight_with_photographs_makes_its_map() -> None:
    """Time stops, and the map has a minute before the products."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.advance(0.1, stored(2))
    rehearsal.mission.cancel('interrupted by Ctrl-C')
    assert rehearsal.advance(0.1) == [Order(kind=OrderKind.PAUSE_CLOCK), MOSAIC]
    rehearsal.mission.answered(MOSAIC)
    rehearsal.advance(0.1)
    assert rehearsal.advance(0.1) == [PRODUCTS]


def test_map_of_a_cancelled_mission_is_still_made() -> None:
    """Ctrl-C while mapping shortens the wait for the map and does not end it."""
    rehearsal = Rehearsal().to_mapping()
    assert rehearsal.advance(0.1) == [MOSAIC]
    rehearsal.mission.accepted(MOSAIC)
    rehearsal.mission.cancel('interrupted by Ctrl-C')
    rehearsal.advance()
    rehearsal.advance(59.9)
    assert rehearsal.is_in(Phase.MAPPING)
    rehearsal.advance(0.2)
    assert rehearsal.is_in(Phase.REPORTING)


def test_flight_without_room_on_the_disk_is_broken_off() -> None:
    """Map and products are made in the reserve, and the mission fails by that name."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.break_off('the disk of runs is full')
    assert rehearsal.is_in(Phase.MAPPING)
    assert (rehearsal.mission.outcome, rehearsal.mission.text) == (
        Phase.FAILED,
        'the disk of runs is full',
    )
    rehearsal.mission.break_off('the disk of runs is full')
    assert rehearsal.mission.text == 'the disk of runs is full'


def test_cancelled_mission_stays_cancelled_when_its_products_are_done() -> None:
    """Products do not make a cancelled mission complete."""
    rehearsal = Rehearsal().to_airborne()
    rehearsal.mission.cancel('interrupted by SIGTERM')
    rehearsal.advance()
    rehearsal.mission.answered(PRODUCTS)
    rehearsal.advance()
    assert rehearsal.is_in(Phase.CANCELLED)


def test_answers_nobody_waits_for_change_nothing() -> None:
    """A late or repeated answer is passed over."""
    rehearsal = Rehearsal().to_planning()
    rehearsal.mission.flown('rav1', 3, 'crashed')
    rehearsal.mission.answered(MOSAIC)
    rehearsal.mission.planned(['rav1'])
    rehearsal.mission.planned(['rav1', 'rav2'])
    rehearsal.mission.refused(PLAN, 'too late')
    assert rehearsal.advance() == [FLY_1]
    assert rehearsal.mission.text == ''


@pytest.mark.parametrize('value', [0.0, -1.0, float('nan'), 1e9])
def test_deadlines_have_limits(value: float) -> None:
    """A deadline of no time, or of no end, is refused."""
    with pytest.raises(ValueError, match='stall_timeout_s'):
        Deadlines(stall_timeout_s=value)


def landed(extra_rounds: int = 1) -> Rehearsal:
    """Return a mission whose survey is flown, with rounds left."""
    rehearsal = Rehearsal(extra_rounds=extra_rounds).to_airborne()
    for vehicle in ('rav1', 'rav2'):
        rehearsal.mission.flown(vehicle, 3)
    return rehearsal


def test_a_further_round_is_planned_and_flown_where_it_tells_most() -> None:
    """Asked, planned, flown by one vehicle, with time started again; then all goes on as ever."""
    rehearsal = landed()
    assert ADVISE in [*rehearsal.advance(0.1), *rehearsal.advance()]
    assert rehearsal.is_in(Phase.PLANNING)
    rehearsal.mission.rounds.advised(4, 'the ellipse is wide')
    assert rehearsal.advance(0.1) == [PLAN]
    rehearsal.mission.planned(['rav2'])
    assert [*rehearsal.advance(0.1), *rehearsal.advance(0.1)] == [FLY_2]
    rehearsal.mission.accepted(FLY_2)
    assert [*rehearsal.advance(0.1), *rehearsal.advance(0.1)] == [CLOCK]
    rehearsal.mission.answered(CLOCK)
    rehearsal.mission.flown('rav2', 4)
    rehearsal.advance(0.1)
    assert rehearsal.is_in(Phase.COLLECTING)
    rehearsal.advance(0.1, stored(9))
    assert rehearsal.is_in(Phase.COLLECTING)
    rehearsal.advance(0.1, stored(10))
    assert rehearsal.is_in(Phase.MAPPING)
    assert rehearsal.mission.text == ''


def test_a_mission_of_vehicles_without_cameras_is_complete() -> None:
    """Real vehicles may carry a detector alone; there is no map, and that is said."""
    rehearsal = Rehearsal().to_airborne()
    for vehicle in ('rav1', 'rav2'):
        rehearsal.mission.flown(vehicle, 0)
    rehearsal.advance(0.1)
    rehearsal.advance(0.1)
    assert rehearsal.is_in(Phase.REPORTING)
    assert rehearsal.mission.outcome is Phase.COMPLETE
    assert rehearsal.mission.remarks == ['no vehicle took photographs: there is no map']


def test_no_round_is_flown_when_it_is_enough() -> None:
    """Its reason is kept."""
    rehearsal = landed(extra_rounds=3)
    rehearsal.advance(0.1)
    rehearsal.mission.rounds.advised(0, '1 source, placed within 2 m')
    rehearsal.advance(0.1)
    assert rehearsal.is_in(Phase.COLLECTING)
    assert rehearsal.mission.remarks == ['no further round: 1 source, placed within 2 m']
    assert rehearsal.mission.outcome is Phase.COMPLETE


def test_a_further_round_that_cannot_be_planned_is_no_failure() -> None:
    """The survey is done: batteries too empty for more do not spoil it."""
    rehearsal = landed()
    rehearsal.advance(0.1)
    rehearsal.mission.rounds.advised(4, 'the ellipse is wide')
    rehearsal.advance(0.1)
    rehearsal.mission.refused(PLAN, 'planner: a route does not fit')
    rehearsal.advance(0.1)
    assert rehearsal.is_in(Phase.COLLECTING)
    assert rehearsal.mission.outcome is Phase.COMPLETE
    assert 'planner: a route does not fit' in rehearsal.mission.remarks[-1]


def test_a_localizer_that_never_answers_does_not_hold_the_mission_up() -> None:
    """What was flown is handed over."""
    rehearsal = Rehearsal(Deadlines(plan_s=5.0, plan_vehicle_s=0.1), extra_rounds=1).to_airborne()
    for vehicle in ('rav1', 'rav2'):
        rehearsal.mission.flown(vehicle, 3)
    rehearsal.advance(0.1)
    rehearsal.advance(6.0)
    rehearsal.advance(6.0)
    assert rehearsal.is_in(Phase.COLLECTING)
    assert rehearsal.mission.outcome is Phase.COMPLETE


def test_a_failed_survey_is_not_followed_by_a_round() -> None:
    """A vehicle that came back early may have had a reason."""
    rehearsal = Rehearsal(extra_rounds=1).to_airborne()
    rehearsal.mission.flown('rav1', 3)
    rehearsal.mission.flown('rav2', 1, 'returned early')
    rehearsal.advance(0.1)
    assert rehearsal.is_in(Phase.COLLECTING)
