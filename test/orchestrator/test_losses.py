# SPDX-License-Identifier: Apache-2.0
"""Vehicles lost in flight: the others hold, the rest is planned, they fly on."""

from dataclasses import replace

import pytest

from rocsafe_orchestrator.mission.mission import Mission
from rocsafe_orchestrator.mission.options import Deadlines
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.presence import Sighting
from rocsafe_orchestrator.mission_state.request import Order, OrderKind
from rocsafe_orchestrator.mission_state.situation import Crew, Situation

NAMES = ('rav1', 'rav2', 'rav3')
PROCESSES = frozenset({'planner', 'world', 'mosaic', *NAMES})
CREW = Crew(vehicle_processes={name: name for name in NAMES}, processes=PROCESSES)


def order(kind: OrderKind, vehicle: str = '') -> Order:
    """Return an order."""
    return Order(kind=kind, vehicle=vehicle)


# What those who held are told where there is no new plan.
GO_ON = [
    order(kind, name) for name in ('rav1', 'rav3') for kind in (OrderKind.FLY, OrderKind.RESUME)
]


def still(*names: str, images: int = 0) -> Situation:
    """Return a situation in which these vehicles stand."""
    return Situation(ready=PROCESSES, still=frozenset(names), images_stored=images)


class Airborne:
    """A mission with three vehicles in the air, and a clock of its own."""

    def __init__(self, *, replans: bool = True) -> None:
        self.mission = Mission(CREW, Deadlines(), replans=replans)
        self.now_s = 100.0
        self.advance()
        self.mission.planned(NAMES)
        self.accept(*self.advance())
        self.accept(*self.advance())
        assert self.mission.phase is Phase.FLYING

    def advance(self, situation: Situation | None = None, after_s: float = 0.1) -> list[Order]:
        """Let time pass and return the orders of that moment."""
        self.now_s += after_s
        return self.mission.advance(self.now_s, situation or still())

    def accept(self, *orders: Order) -> None:
        """Let routes be accepted, and everything else be done."""
        for each in orders:
            if each.kind is OrderKind.FLY:
                self.mission.accepted(each)
            else:
                self.mission.answered(each)

    def gathered(self) -> 'Airborne':
        """Lose the second one and let the others stand, up to the question for a plan."""
        self.mission.flown('rav2', 2, 'aborted its flight')
        self.accept(*self.advance())
        self.accept(*self.advance(still(*NAMES)))
        assert self.advance(still(*NAMES)) == [order(OrderKind.PLAN)]
        return self


def test_others_hold_and_the_rest_is_planned_in_paused_time() -> None:
    """A hold for each in the air; then, when they stand, a pause; then the plan."""
    flying = Airborne()
    flying.mission.flown('rav2', 2, 'aborted its flight')
    holds = flying.advance()
    assert holds == [order(OrderKind.HOLD, 'rav1'), order(OrderKind.HOLD, 'rav3')]
    flying.accept(*holds)
    assert flying.advance(still('rav1')) == []
    assert flying.advance(still('rav1', 'rav3')) == [order(OrderKind.PAUSE_CLOCK)]
    flying.accept(order(OrderKind.PAUSE_CLOCK))
    assert flying.advance(still('rav1', 'rav3')) == [order(OrderKind.PLAN)]
    assert flying.mission.remarks[-1] == 'rav2: aborted its flight; the others take over'
    assert flying.mission.fleet.lost == {'rav2': 'aborted its flight'}


def test_new_routes_are_flown_and_time_runs_on() -> None:
    """Who has a route of the new plan flies it; the mission is complete with all photographs."""
    flying = Airborne().gathered()
    flying.mission.planned(['rav1', 'rav3'], visited=5)
    routes = flying.advance()
    assert routes == [order(OrderKind.FLY, 'rav1'), order(OrderKind.FLY, 'rav3')]
    flying.accept(*routes)
    assert flying.advance() == [order(OrderKind.RUN_CLOCK)]
    flying.mission.flown('rav1', 3)
    flying.mission.flown('rav3', 1)
    flying.advance()
    assert flying.mission.phase is Phase.COLLECTING
    flying.advance(still(images=8))
    assert flying.mission.phase is Phase.COLLECTING
    flying.advance(still(images=9))
    assert flying.mission.phase is Phase.MAPPING
    assert flying.mission.outcome is Phase.COMPLETE


def test_without_the_switch_a_loss_fails_the_mission() -> None:
    """The others fly their own routes to the end."""
    flying = Airborne(replans=False)
    flying.mission.flown('rav2', 2, 'aborted its flight')
    assert flying.advance() == []
    assert flying.mission.phase is Phase.FLYING
    assert flying.mission.text == 'rav2: aborted its flight'


def test_vehicle_whose_process_is_gone_is_not_waited_for() -> None:
    """The world is told, and told again when it is started again."""
    flying = Airborne()
    flying.mission.gave_up('rav2', 'was ended by SIGKILL after 5 restarts')
    orders = flying.advance()
    gone = order(OrderKind.DISMISS, 'rav2')
    assert gone in orders
    assert order(OrderKind.HOLD, 'rav1') in orders
    flying.accept(*orders)
    assert gone not in flying.advance()
    flying.mission.restarted('world', flying.now_s)
    assert gone in flying.advance()


def test_rest_that_cannot_be_planned_leaves_the_others_to_their_routes() -> None:
    """The reason is a fault; who held goes on with the route that it had."""
    flying = Airborne().gathered()
    flying.mission.refused(order(OrderKind.PLAN), 'planner: rav1 needs 900 s')
    assert flying.advance() == GO_ON
    assert flying.mission.text == 'no plan for the rest: planner: rav1 needs 900 s'
    assert flying.mission.outcome is Phase.FAILED


def test_loss_after_the_last_photograph_is_no_fault() -> None:
    """The others go on with their routes, home."""
    flying = Airborne().gathered()
    flying.mission.nothing_left()
    assert flying.advance() == GO_ON
    assert flying.mission.outcome is Phase.COMPLETE


def test_who_refuses_to_go_on_after_a_hold_returns() -> None:
    """Nobody else would end its hold."""
    flying = Airborne().gathered()
    flying.mission.nothing_left()
    flying.accept(*(each for each in flying.advance() if each.vehicle == 'rav1'))
    flying.mission.refused(order(OrderKind.RESUME, 'rav3'), 'resume: rav3: mission not read')
    assert order(OrderKind.RETURN, 'rav3') in flying.advance()
    assert flying.mission.text == 'resume: rav3: mission not read'


def test_who_does_not_answer_to_go_on_returns_and_the_mission_waits() -> None:
    """It is in the air: the mission must not end there."""
    flying = Airborne().gathered()
    flying.mission.nothing_left()
    flying.accept(*(e for e in flying.advance() if e != order(OrderKind.RESUME, 'rav3')))
    aloft = Situation(ready=PROCESSES, aloft=frozenset({'rav3'}))
    told: list[Order] = []
    for second in range(int(Deadlines().accept_s) + 5):
        new = flying.advance(replace(aloft, simulated_s=float(second)), after_s=1.0)
        flying.accept(*(each for each in new if each.kind is not OrderKind.RESUME))
        told += new
    assert order(OrderKind.RETURN, 'rav3') in told
    assert flying.mission.phase is Phase.FLYING
    assert flying.mission.text.startswith('rav3: did not accept to go on after the hold')


def test_time_that_passed_before_all_stood_is_explained() -> None:
    """Who did not stop is named; the others go on with the routes that they had."""
    flying = Airborne()
    flying.mission.flown('rav2', 2, 'aborted its flight')
    flying.accept(*flying.advance())
    told: list[Order] = []
    for second in range(300):
        stands = replace(still('rav1'), simulated_s=float(second))
        told += flying.advance(stands, after_s=1.0)
        if flying.mission.text:
            break
    assert flying.mission.text.endswith('s: rav3 did not stop')
    told += flying.advance()
    assert [each for each in told if each.vehicle] == GO_ON


def test_refused_hold_is_no_fault() -> None:
    """Who is on the ground already cannot hold, and need not."""
    flying = Airborne()
    flying.mission.flown('rav2', 2, 'aborted its flight')
    for hold in flying.advance():
        flying.mission.refused(hold, 'cannot hold: landed')
    assert flying.advance(still(*NAMES)) == [order(OrderKind.PAUSE_CLOCK)]
    assert flying.mission.text == ''


def test_who_does_not_stand_in_time_flies_on() -> None:
    """Gathering has a deadline."""
    flying = Airborne()
    flying.mission.flown('rav2', 2, 'aborted its flight')
    flying.accept(*flying.advance())
    late = Situation(ready=PROCESSES, still=frozenset({'rav1'}), simulated_s=191.0)
    orders = flying.advance(late, after_s=191.0) + flying.advance()
    assert order(OrderKind.FLY, 'rav3') in orders
    assert 'the rest was not planned within 189 s' in flying.mission.text


@pytest.mark.parametrize('last', ['rav1', 'rav3'])
def test_second_loss_leaves_one(last: str) -> None:
    """Another one is lost while the rest is planned: the last one takes over all of it."""
    flying = Airborne().gathered()
    flying.mission.planned(['rav1', 'rav3'], visited=5)
    flying.accept(*flying.advance())
    flying.accept(*flying.advance())
    lost = ({'rav1', 'rav3'} - {last}).pop()
    flying.mission.flown(lost, 0, 'crashed')
    assert flying.advance() == [order(OrderKind.HOLD, last)]


def test_nobody_is_left() -> None:
    """The last loss fails the mission, which still makes its map."""
    flying = Airborne()
    for name in NAMES:
        flying.mission.flown(name, 1, 'crashed')
        flying.mission.gave_up(name, 'was ended')
    flying.advance(still(*NAMES))
    assert flying.mission.outcome is Phase.FAILED


def seen(*names: str, **sightings: Sighting) -> Situation:
    """Return a situation in which these stand, and vehicles are seen so."""
    return Situation(
        ready=PROCESSES,
        still=frozenset(names),
        sightings={name: Sighting() for name in NAMES} | sightings,
    )


def test_silent_vehicle_gets_no_orders_and_is_then_replaced() -> None:
    """Time does not wait for it, and the others hold."""
    flying = Airborne()
    assert flying.advance(seen(rav2=Sighting(silent_s=6.0))) == []
    assert set(flying.mission.fleet.others) == {'rav1', 'rav3'}
    assert flying.advance(seen(rav2=Sighting(silent_s=16.0))) == [
        order(OrderKind.DISMISS, 'rav2'),
        order(OrderKind.HOLD, 'rav1'),
        order(OrderKind.HOLD, 'rav3'),
    ]


def test_loss_while_the_others_are_silent_for_a_moment_is_made_good_after_it() -> None:
    """Nobody could take over then: the survey would wait for the lost one for ever."""
    flying = Airborne()
    late, gone = Sighting(silent_s=6.0), Sighting(silent_s=16.0)
    assert flying.advance(seen(rav1=late, rav2=gone, rav3=late)) == []
    assert flying.advance(seen(rav2=gone)) == [
        order(OrderKind.DISMISS, 'rav2'),
        order(OrderKind.HOLD, 'rav1'),
        order(OrderKind.HOLD, 'rav3'),
    ]


def test_loss_of_one_that_is_heard_again_is_none() -> None:
    """All were silent, for instance because this process stood still."""
    flying = Airborne()
    late, gone = Sighting(silent_s=6.0), Sighting(silent_s=16.0)
    assert flying.advance(seen(rav1=late, rav2=gone, rav3=late)) == []
    assert flying.advance(seen()) == []
    assert set(flying.mission.fleet.others) == set(NAMES)


def test_announced_loss_is_acted_on_before_the_flight_has_ended() -> None:
    """The vehicle is still on its way down; it is waited for, and not dismissed."""
    flying = Airborne()
    down = Sighting(ending='the battery failed')
    orders = flying.advance(seen(rav2=down))
    assert orders == [order(OrderKind.HOLD, 'rav1'), order(OrderKind.HOLD, 'rav3')]


def test_vehicle_that_comes_back_is_merged_into_the_next_plan() -> None:
    """It holds, hands over its photographs, and flies only what the new plan gives it."""
    flying = Airborne()
    gone = seen(rav2=Sighting(silent_s=20.0))
    flying.accept(*flying.advance(gone))
    still_there = seen('rav1', 'rav3', rav2=Sighting(silent_s=21.0))
    flying.accept(*flying.advance(still_there))
    assert flying.advance(still_there) == [order(OrderKind.PLAN)]
    flying.mission.planned(['rav1', 'rav3'], visited=3)
    flying.accept(*flying.advance(gone))
    flying.accept(*flying.advance(gone))
    holds = flying.advance(seen())
    assert set(holds) == {order(OrderKind.HOLD, name) for name in NAMES}
    flying.accept(*holds)
    assert set(flying.mission.fleet.others) == set(NAMES)
    full = Situation(
        ready=PROCESSES, still=frozenset(NAMES), unsettled=frozenset({'rav2'}),
        sightings={name: Sighting() for name in NAMES},
    )  # fmt: skip
    assert flying.advance(full) == []
    flying.accept(*flying.advance(seen(*NAMES)))
    assert flying.advance(seen(*NAMES)) == [order(OrderKind.PLAN)]
    flying.mission.planned(['rav1', 'rav2'], visited=5)
    routes = flying.advance(seen(*NAMES))
    assert routes == [order(OrderKind.FLY, 'rav1'), order(OrderKind.FLY, 'rav2')]


@pytest.mark.parametrize('holder', ['pilot', 'failsafe'])
def test_vehicle_that_comes_back_in_other_hands_gets_no_order_until_it_is_ours(
    holder: str,
) -> None:
    """Silent for 16 s and replaced, heard again with its pilot or a failsafe; then given back.

    It gets no order at all before that, then a hold, and no route before what it did is merged.
    """
    flying = Airborne()
    gone = seen(rav2=Sighting(silent_s=16.0))
    flying.accept(*flying.advance(gone))
    still_there = seen('rav1', 'rav3', rav2=Sighting(silent_s=17.0))
    flying.accept(*flying.advance(still_there))
    assert flying.advance(still_there) == [order(OrderKind.PLAN)]
    flying.mission.planned(['rav1', 'rav3'], visited=3)
    flying.accept(*flying.advance(gone))
    flying.accept(*flying.advance(gone))
    taken = seen(rav2=Sighting(taken_by=holder))
    orders = [each for _ in range(50) for each in flying.advance(taken)]
    assert [each for each in orders if each.vehicle == 'rav2'] == []
    holds = flying.advance(seen())
    assert set(holds) == {order(OrderKind.HOLD, name) for name in NAMES}
    flying.accept(*holds)
    flying.accept(*flying.advance(seen(*NAMES)))
    assert flying.advance(seen(*NAMES)) == [order(OrderKind.PLAN)]
    flying.mission.planned(['rav2'], visited=5)
    assert flying.advance(seen(*NAMES)) == [order(OrderKind.FLY, 'rav2')]


def test_vehicle_for_which_nothing_is_left_returns_home() -> None:
    """It came back after all was photographed: it does not fly its old route."""
    flying = Airborne()
    gone = seen(rav2=Sighting(silent_s=20.0))
    flying.accept(*flying.advance(gone))
    still_there = seen('rav1', 'rav3', rav2=Sighting(silent_s=21.0))
    flying.accept(*flying.advance(still_there))
    flying.advance(still_there)
    flying.mission.planned(['rav1', 'rav3'], visited=3)
    flying.accept(*flying.advance(gone))
    flying.advance(seen())
    flying.mission.nothing_left()
    orders = flying.advance(seen())
    assert order(OrderKind.RETURN, 'rav2') in orders
    assert order(OrderKind.FLY, 'rav2') not in orders


def test_vehicle_that_its_pilot_has_is_left_alone_when_others_are_replaced() -> None:
    """It gets neither a hold nor a route."""
    flying = Airborne()
    taken = seen(rav1=Sighting(taken_by='pilot'), rav2=Sighting(ending='crashed'))
    assert flying.advance(taken) == [order(OrderKind.HOLD, 'rav3')]
    # The new plan keeps away from it; the crashed one is out of the air.
    assert flying.mission.fleet.unheard == ['rav1']


def test_mission_waits_for_the_landing_of_a_replaced_vehicle() -> None:
    """Its bridge must not end while it is in the air."""
    flying = Airborne()
    for name in NAMES:
        flying.mission.flown(name, 1)
    aloft = Situation(ready=PROCESSES, aloft=frozenset({'rav2'}))
    flying.advance(aloft)
    assert flying.mission.phase is Phase.FLYING
    flying.advance()
    assert flying.mission.phase is Phase.COLLECTING


def test_vehicle_turns_back_and_others_take_over() -> None:
    """It gets one order, home by the way of least dose, and no more work."""
    flying = Airborne()
    for _ in range(2):
        flying.mission.takeover.turn_back('rav2', 'turns back at 2e+05 uSv/h')
    assert set(flying.advance(seen())) == {
        order(OrderKind.HOLD, 'rav1'),
        order(OrderKind.HOLD, 'rav3'),
        order(OrderKind.RETREAT, 'rav2'),
    }
    flying.advance(seen(*NAMES))
    assert set(flying.mission.fleet.others) == {'rav1', 'rav3'}


def test_vehicle_that_turns_back_before_it_has_taken_off_gets_no_route() -> None:
    """The command to return withdraws its start; a route home would make it take off."""
    flying = Airborne()
    flying.mission.takeover.turn_back('rav2', 'turns back at 2e+05 uSv/h', is_waiting=True)
    asked = flying.advance(seen())
    assert order(OrderKind.RETURN, 'rav2') in asked
    assert order(OrderKind.RETREAT, 'rav2') not in asked
    flying.advance(seen(*NAMES))
    assert set(flying.mission.fleet.others) == {'rav1', 'rav3'}


def test_vehicle_that_cannot_fly_that_way_returns_home_by_its_own() -> None:
    """The order to return is always there."""
    flying = Airborne()
    flying.mission.takeover.turn_back('rav2', 'turns back at 2e+05 uSv/h')
    flying.advance(seen())
    flying.mission.refused(order(OrderKind.RETREAT, 'rav2'), 'rav2: cannot fly a route: landing')
    assert order(OrderKind.RETURN, 'rav2') in flying.advance(seen())


def test_an_operator_has_the_rest_planned_anew() -> None:
    """All hold, the rest is planned, and all fly on: also where no loss is replaced."""
    flying = Airborne(replans=False)
    assert flying.mission.takeover.replan() == ''
    holds = flying.advance()
    assert holds == [order(OrderKind.HOLD, name) for name in NAMES]
    flying.accept(*holds)
    flying.accept(*flying.advance(still(*NAMES)))
    assert flying.advance(still(*NAMES)) == [order(OrderKind.PLAN)]
    assert 'cannot plan anew' in flying.mission.takeover.replan(), 'not twice at a time'
    flying.mission.planned(NAMES, visited=4)
    assert flying.advance() == [order(OrderKind.FLY, name) for name in NAMES]
    assert flying.mission.fleet.lost == {}


def test_what_an_operator_leads_himself_is_left_out_of_the_new_plan() -> None:
    """It would refuse its route, and the mission would fail."""
    flying = Airborne(replans=False)
    assert flying.mission.takeover.replan(['rav2']) == ''
    assert flying.advance() == [order(OrderKind.HOLD, 'rav1'), order(OrderKind.HOLD, 'rav3')]
    assert flying.mission.fleet.others == ['rav1', 'rav3']


def test_nothing_is_planned_anew_where_no_plan_is_flown() -> None:
    """Before the start, after a cancellation, with agents, and for nobody."""
    early = Mission(CREW, Deadlines())
    assert 'do not fly' in early.takeover.replan()
    cancelled = Airborne()
    cancelled.mission.cancel('by the operator')
    assert 'do not fly' in cancelled.mission.takeover.replan()
    alone = Airborne()
    assert 'no vehicle takes orders' in alone.mission.takeover.replan(NAMES)
