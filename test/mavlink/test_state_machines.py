# SPDX-License-Identifier: Apache-2.0
"""Seeded runs of the bridge's state machines against a hostile vehicle, in virtual time.

No process, no socket: a drone, its session and its commands on one side, `hostile_vehicle` on the
other. A watch beside them, which shares no code with them, judges every message that is sent.
"""

import contextlib
import math
import os
import random
from itertools import count

import pytest
from test.fakes.fake_autopilot import HOME
from test.mavlink.hostile_vehicle import (
    FAILSAFE,
    KIND,
    OURS,
    PILOT,
    Channel,
    HostileVehicle,
    is_finite,
    modes_of,
    spite_of,
)
from test.mavlink.misfortunes import MISFORTUNES
from test.mavlink.test_flight import plan

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.autopilots.ardupilot import COPTER
from rocsafe_mavlink.autopilots.autopilot import Verb
from rocsafe_mavlink.autopilots.px4 import MULTICOPTER
from rocsafe_mavlink.drone.drone import Drone, DroneSpec
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.errors import CommandRefusedError, WaitError
from rocsafe_mavlink.flight.flight_journal import Assignment, FlightJournal
from rocsafe_mavlink.knowledge.reducer import NO_AUTOPILOT
from rocsafe_mavlink.plan.fence import Fence
from rocsafe_mavlink.plan.flight_limits import FlightLimits
from rocsafe_mavlink.plan.flight_plan import mission_of
from rocsafe_mavlink.wire.authority import COMMANDS

RUNS = int(os.environ.get('ROCSAFE_STATE_RUNS', '100'))
SHARDS = 10
STEP_S, FLIGHT_S, CALM_S = 0.25, 100.0, 45.0
# No operation may take longer: a start with 13 items, with every answer at the last moment.
DEADLINE_S = 420.0
# A mode that the bridge asked for so recently may be its own doing.
ASKED_S, LATE_S = 30.0, 5.0
READING = frozenset(
    {
        *('HEARTBEAT', 'MISSION_REQUEST_LIST', 'MISSION_REQUEST_INT', 'MISSION_ACK'),
        'PARAM_REQUEST_READ',
    }
)
PLANS = {size: plan(size) for size in (2, 4, 6)}
HERE = GeoPosition(*HOME)
# Return, speed, heading, photograph, trigger: their height means nothing.
WITHOUT_HEIGHT = (20, 178, 115, 203, 206)
FAILSAFE_WORDS = ('failsafe', 'breached')


class Watch:
    """Judges what is sent, by what the bridge has received."""

    def __init__(self, run):
        self.run = run
        self.owner, self.mode, self.is_armed = OURS, -1, False
        self.is_heard = self.has_failed = self.is_critical = self.is_expected = False
        self.asked_s = {}
        self.tainted = None
        self.total = 0

    def hear(self, message):
        """Note a message that reaches the bridge."""
        run = self.run
        said = message['text'].lower() if message.name == 'STATUSTEXT' else ''
        self.has_failed |= self.is_armed and any(word in said for word in FAILSAFE_WORDS)
        if message.name == 'MISSION_CURRENT':
            self.total = message.fields.get('total', 0)
        is_beat = message.name == 'HEARTBEAT' and id(message) in run.vehicle.owners
        if not is_beat or message['autopilot'] == NO_AUTOPILOT:
            return
        _, owner = run.vehicle.owners[id(message)]
        mode, is_armed = message['custom_mode'], bool(message['base_mode'] & 0x80)
        is_new = mode != self.mode and owner != OURS and is_armed and self.is_armed
        if mode != self.mode:
            self.is_expected = self._was_asked(mode, LATE_S)
        self.is_heard, self.owner, self.mode, self.is_armed = True, owner, mode, is_armed
        self.is_critical = message['system_status'] >= 5
        # One odd status in flight is no failsafe: nothing has switched it.
        if message['system_status'] >= 5 and is_armed and owner == FAILSAFE:
            self.has_failed = True
        if not is_armed:
            self.has_failed, self.tainted = False, None
        session = run.drone.session
        if is_new and not self._was_asked(mode):
            self.tainted = (session.sequence_count, session.flight)

    def judge(self, message):
        """Fail if a message must not be sent now."""
        if message.name in READING or message.fields.get('command') == 511:
            return
        what = f'{message.name} {dict(message.fields)}'
        assert is_finite(message) or message['command'] == 192, f'{what}: not finite'
        if message.name.startswith('COMMAND'):
            assert message['command'] in COMMANDS, what
        assert self.is_heard, f'{what}: to a vehicle never heard'
        self._judge_owner(message, what)
        self._judge_mission(message, what)
        for mode in self._leads_to(message):
            self.asked_s[mode] = self.run.now_s

    def _judge_owner(self, message, what):
        run, modes = self.run, self.run.vehicle.modes
        if not self.is_armed:
            return
        commanded = (modes['mission'], modes['hold'], modes['guided'])
        is_theirs = self.owner in (PILOT, FAILSAFE) and self.mode not in commanded
        is_urgent = self._is_urgent(message)
        # An order to return or land may show after a failsafe that was over before.
        is_late = is_urgent and not self.is_critical and self.is_expected
        may_be_ours = is_late or (self._was_asked(self.mode) and not self.has_failed)
        name = run.vehicle.kind.mode_name(self.mode)
        assert not is_theirs or may_be_ours, f'{what}: {self.owner} has it, in {name}'
        assert not self.has_failed or is_urgent, f'{what}: a failsafe was announced, in {name}'
        is_old = self.tainted is not None and self.tainted[0] == run.drone.session.sequence_count
        is_flight = run.drone.session.flight is not None and run.drone.session.flight.is_beginning
        assert not is_old or is_flight, f'{what}: begun before {self.owner} took it, in {name}'

    def _judge_mission(self, message, what):
        """Nothing is started or resumed but a mission of a plan."""
        modes = self.run.vehicle.modes
        number = message.fields.get('command')
        starts = modes['mission'] in self._leads_to(message) or number in (224, 300)
        run = self.run
        if not starts:
            return
        counts = {len(items) - run.first for items in run.plans}
        assert self.total in {0, *counts}, f'{what}: {self.total} items were told'
        if not run.was_just_changed:
            stored = run.vehicle.stored[0]
            assert run.is_planned(stored), f'{what}: not verified, {len(stored)} items'

    def _was_asked(self, mode, ago_s=ASKED_S):
        return self.run.now_s - self.asked_s.get(mode, -1e9) < ago_s

    def _leads_to(self, message):
        modes, kind = self.run.vehicle.modes, self.run.vehicle.kind
        number = message.fields.get('command')
        if number == 176:
            main, sub = int(message['param2']), int(message.fields.get('param3', 0.0))
            return (sub << 24 | main << 16 if kind.is_mode_packed else main,)
        if number == 300 or (number == 193 and message['param1'] == 1.0):
            return (modes['mission'],)
        return (modes['guided'], modes['hold']) if number == 192 else ()

    def _is_urgent(self, message):
        modes = self.run.vehicle.modes
        safe = {modes['hold'], modes['return'], modes['land']}
        number = message.fields.get('command')
        is_pause = number == 193 and message['param1'] == 0.0
        return is_pause or (number == 176 and set(self._leads_to(message)) <= safe)


class Run:
    """One run, from its seed alone."""

    def __init__(self, seed):
        rng = self.rng = random.Random(seed)
        kind = rng.choice((COPTER, MULTICOPTER))
        self.vehicle = HostileVehicle(kind, modes_of(kind, Verb), rng, spite_of(rng))
        session = VehicleSession.of((1, 1), (255, 190))
        frame = LocalFrame(GeoPosition(*HOME, 535.0))
        limits = FlightLimits(
            max_wind_mps=rng.choice((0.0, 12.0)), returns_in_wind=rng.random() < 0.3
        )
        spec = DroneSpec(name='rav1', target=(1, 1), frame=frame, limits=limits)
        self.drone = Drone(spec, session, FlightJournal())
        bad = rng.choice((0.0, 0.0, 0.1, 0.4))
        late_s = rng.choice((0.0, 0.0, 0.4, 2.5))
        self.down, self.up = (Channel(rng, bad, bad / 2.0, late_s) for _ in range(2))
        self.now_s = 0.0
        self.ordered_s, self.cut_until_s, self.resume_s = 0.0, -1.0, math.inf
        self.watch = Watch(self)
        self.begun = {}
        self.plans = [mission_of(flown, kind).items for flown in PLANS.values()]
        self.first = kind.first_own_item
        self.ids = count()
        self.busy, self.wild = rng.choice((0.02, 0.1)), rng.choice((0.01, 0.03, 0.08))
        self.is_calm_on_ground = rng.random() < 0.7

    @property
    def was_just_changed(self):
        """Whether the mission was changed after the order came that is carried out."""
        flight = self.drone.session.flight
        is_starting = flight is not None and flight.is_beginning
        changed_s = self.vehicle.changed_s
        return changed_s >= 0.0 and (is_starting or changed_s >= self.ordered_s)

    def is_planned(self, stored):
        """Whether the items of one of the plans lie on the vehicle."""
        return any(_same(stored, items, self.first) for items in self.plans)

    def fly(self):
        """Fly; orders and misfortunes come at random, after the first start or in the air.

        Before that the link is good, and where they come in the air the vehicle does as told.
        """
        calm, is_calm = (self.down._loss, self.up._loss), True
        self.down._loss = self.up._loss = 0.0
        spite = self.vehicle.spite
        self.vehicle.spite = KIND if self.is_calm_on_ground else spite
        while self.now_s < FLIGHT_S:
            session = self.drone.session
            if is_calm and self._is_calm_over():
                self.down._loss, self.up._loss, is_calm = *calm, False
                self.vehicle.spite = spite
            if self.now_s > 8.0 and not session.is_flying and self.rng.random() < 0.1:
                self.order(self._start)
            if not is_calm:
                self.meddle()
            self.step()
        while self.pending():
            self.step()

    def _is_calm_over(self):
        limit_s = CALM_S if self.is_calm_on_ground else 8.0
        return self.vehicle.is_flying or self.now_s > limit_s

    def step(self):
        """Let time pass."""
        self.now_s += STEP_S
        now_s, session = self.now_s, self.drone.session
        if now_s > self.cut_until_s:
            self.down.is_cut = self.up.is_cut = False
        for message in self.vehicle.step(now_s):
            self.down.put(now_s, message)
        for message in self.down.due(now_s):
            self.watch.hear(message)
            self.drone.take(message, now_s)
            self.send()
        self.drone.step(now_s)
        session.tick(now_s)
        if self.rng.random() < 0.1:
            self.drone.status(now_s)
        self.send()
        for message in self.up.due(now_s):
            self.vehicle.receive(message, now_s)
        for number in self.pending():
            late_s = now_s - self.begun[number]
            assert late_s < DEADLINE_S, f'{number} has taken {late_s:.0f} s'

    def pending(self):
        """Return the operations that have not ended."""
        session = self.drone.session
        if session.sequence is not None and not session.sequence.is_over:
            self.begun.setdefault(session.sequence_count, self.now_s)
        ended = [
            number
            for number in self.begun
            if number != 'start' and (number != session.sequence_count or session.sequence.is_over)
        ]
        is_starting = session.flight is not None and session.flight.is_beginning
        ended += [] if is_starting else ['start']
        for number in ended:
            self.begun.pop(number, None)
        if is_starting:
            self.begun.setdefault('start', self.now_s)
        return list(self.begun)

    def send(self):
        """Send what the session wants sent."""
        for message in self.drone.session.outgoing():
            if message.name == 'MISSION_COUNT' and not message['mission_type']:
                self.vehicle.changed_s = -1.0
            self.watch.judge(message)
            self.up.put(self.now_s, message)

    def order(self, give):
        """Give an order; it may be refused in words."""
        with contextlib.suppress(CommandRefusedError, WaitError, ValueError):
            give()
            self.ordered_s = self.now_s
        self.send()

    def _start(self):
        size = self.rng.choice(list(PLANS))
        ids = tuple(range(size))
        self.drone.fly(
            Assignment(plan_id=f'p{next(self.ids)}', plan=PLANS[size], viewpoint_ids=ids),
            self.now_s,
        )

    def meddle(self):
        """Give an order, or let something happen; mostly neither."""
        rng, commands, now_s = self.rng, self.drone.commands, self.now_s
        if now_s > self.resume_s:
            self.resume_s = math.inf
            self.order(lambda: commands.resume(now_s))
        if rng.random() < self.busy:
            self.order(
                rng.choice(
                    (
                        self._start,
                        lambda: commands.hold(now_s),
                        lambda: commands.hold(now_s),
                        lambda: commands.resume(now_s),
                        lambda: commands.resume(now_s),
                        lambda: commands.resume(now_s),
                        lambda: commands.return_home(now_s),
                        lambda: commands.land(now_s),
                        lambda: commands.change_speed(4.0, now_s),
                        lambda: commands.go_to(HERE, 30.0, now_s),
                        lambda: commands.replace_route(PLANS[rng.choice(list(PLANS))], now_s),
                        lambda: commands.replace_route(PLANS[rng.choice(list(PLANS))], now_s),
                        lambda: commands.push_fence(Fence(), now_s),
                        lambda: commands.push_rally([HERE], 30.0, now_s),
                    )
                )
            )
        if rng.random() < self.wild:
            rng.choice(MISFORTUNES)(self)


def _same(stored, items, first):
    if len(stored) != len(items):
        return False
    pairs = zip(stored[first:], items[first:], strict=True)
    return all(
        (kept[1], *kept[6:8]) == (item.command, item.x_e7, item.y_e7)
        and (item.command in WITHOUT_HEIGHT or abs(kept[8] - item.z_m) < 0.1)
        for kept, item in pairs
    )


@pytest.mark.slow
def test_most_runs_meet_somebody_else_in_the_air():
    """A model that no flight begins with would break no rule."""
    runs = [Run(seed) for seed in range(30)]
    seen = [set() for _ in runs]
    for run, owners in zip(runs, seen, strict=True):
        hear = run.watch.hear

        def note(message, run=run, owners=owners, hear=hear):
            hear(message)
            if run.watch.is_armed and run.vehicle.is_flying:
                owners.add(run.watch.owner)

        run.watch.hear = note
        run.fly()
    assert sum(OURS in owners for owners in seen) >= 15
    assert sum(bool(owners & {PILOT, FAILSAFE}) for owners in seen) >= 10


@pytest.mark.slow
@pytest.mark.parametrize('shard', range(SHARDS))
def test_no_run_breaks_a_rule(shard):
    """No command against pilot or failsafe, nothing unverified flown, each operation ends."""
    for seed in range(shard, RUNS, SHARDS):
        try:
            Run(seed).fly()
        except Exception as error:
            raise AssertionError(f'seed {seed}: {error!r}') from error
