# SPDX-License-Identifier: Apache-2.0
"""Judges what the bridge sends to a hostile vehicle; it shares no code with the bridge."""

from shapely.geometry import LineString, Polygon
from test.mavlink.hostile_vehicle import FAILSAFE, OURS, PILOT, is_finite
from test.mavlink.test_homeward import SQUARE

from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.knowledge.reducer import NO_AUTOPILOT
from rocsafe_mavlink.wire.authority import COMMANDS

# A mode that the bridge asked for so recently may be its own doing.
ASKED_S, LATE_S = 30.0, 5.0
READING = frozenset(
    {
        *('HEARTBEAT', 'MISSION_REQUEST_LIST', 'MISSION_REQUEST_INT', 'MISSION_ACK'),
        'PARAM_REQUEST_READ',
    }
)
FAILSAFE_WORDS = ('failsafe', 'breached', 'battery 1 is low', 'crash: ')


# The square of `around`, a metre smaller, in 1e-7 degrees of latitude and longitude.
INNER = Polygon(
    [(round(one.latitude_deg * 1e7), round(one.longitude_deg * 1e7)) for one in SQUARE]
)
INNER = INNER.buffer(-90.0)


def crosses(here, there):
    """Whether a straight way leads over the square."""
    return LineString([here, there]).intersects(INNER)


class Watch:
    """Judges what is sent, by what the bridge has received."""

    def __init__(self, run):
        self.run = run
        self.owner, self.mode, self.is_armed = OURS, -1, False
        self.is_heard = self.has_failed = self.is_critical = self.is_expected = False
        self.asked_s = {}
        self.tainted = None
        self.total = 0
        self.height_m, self.offered = 0.0, []
        self.place = self.home = None
        self.current, self.is_given_up = 0, False
        self.is_goal_spoilt = self.is_coming_down = False

    def forget(self):
        """Take note that the bridge was started again: it has heard nothing yet."""
        self.is_heard, self.tainted = False, None
        self.place = self.home = None

    def goal_came(self):
        """Take note of a goal: a start follows, unless somebody else uses the vehicle."""
        self.is_goal_spoilt = False

    def hear(self, message):
        """Note a message that reaches the bridge."""
        run = self.run
        said = message['text'].lower() if message.name == 'STATUSTEXT' else ''
        self.has_failed |= self.is_armed and any(word in said for word in FAILSAFE_WORDS)
        if message.name == 'MISSION_CURRENT':
            self.total = message.fields.get('total', 0)
            self.current = message['seq']
        if message.name == 'HOME_POSITION':
            self.home = (message['latitude'], message['longitude'])
        if message.name == 'GLOBAL_POSITION_INT':
            self.height_m = message['relative_alt'] / 1000.0
            self.place = (message['lat'], message['lon'])
        is_beat = message.name == 'HEARTBEAT' and id(message) in run.vehicle.owners
        if not is_beat or message['autopilot'] == NO_AUTOPILOT:
            return
        _, owner = run.vehicle.owners[id(message)]
        mode, is_armed = message['custom_mode'], bool(message['base_mode'] & 0x80)
        is_new = mode != self.mode and owner != OURS and is_armed and self.is_armed
        if mode != self.mode:
            self.is_expected = self._was_asked(mode, LATE_S)
        is_begun = run.drone.session.flight is not None
        is_begun = is_begun and run.drone.session.flight.is_beginning
        if is_armed and not self.is_armed and owner == PILOT and not is_begun:
            self.is_goal_spoilt = True
        self.is_heard, self.owner, self.mode, self.is_armed = True, owner, mode, is_armed
        self.is_critical = message['system_status'] >= 5
        # One odd status in flight is no failsafe: nothing has switched it.
        if message['system_status'] >= 5 and is_armed and owner == FAILSAFE:
            self.has_failed = True
        if not is_armed:
            self.has_failed, self.tainted, self.is_coming_down = False, None, False
            self.is_given_up = False
        session = run.drone.session
        if is_new and not self._was_asked(mode):
            self.tainted = (session.sequence_count, session.flight)

    def judge(self, message):
        """Fail if a message must not be sent now."""
        if message.name in READING or message.fields.get('command') == 511:
            return
        if message.name == 'MISSION_COUNT' and not message['mission_type']:
            self.offered = [None] * message['count']
        if message.name == 'MISSION_ITEM_INT' and not message['mission_type']:
            self.offered[message['seq']] = (message['x'], message['y'], message['z'])
        what = f'{message.name} {dict(message.fields)}'
        assert is_finite(message) or message['command'] == 192, f'{what}: not finite'
        if message.name.startswith('COMMAND'):
            assert message['command'] in COMMANDS, what
        assert self.is_heard, f'{what}: to a vehicle never heard'
        self._judge_owner(message, what)
        self._judge_mission(message, what)
        self._judge_motors(message, what)
        self._judge_order(message, what)
        self._judge_way(message, what)
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

    def _judge_motors(self, message, what):
        """Motors are not stopped far up, nor started for a goal after a pilot has flown."""
        if message.fields.get('command') != 400:
            return
        if message['param1'] == 1.0:
            assert not self.is_goal_spoilt, f'{what}: a pilot has flown since the goal came'
        elif self.is_armed:
            assert self.height_m < 20.0, f'{what}: at {self.height_m:.0f} m'

    def _judge_order(self, message, what):
        """What a person ordered is not undone by what is ordered without him."""
        run, modes = self.run, self.run.vehicle.modes
        leads_to, by_person = self._leads_to(message), run.is_by_person
        if not self.is_armed or not leads_to:
            return
        if modes['land'] in leads_to:
            self.is_coming_down = True
        elif by_person:
            self.is_coming_down = False
        is_down = self.is_coming_down and self.mode == modes['land'] and self.owner == OURS
        assert by_person or not is_down, f'{what}: a person has it land'

    def _judge_way(self, message, what):
        """No straight way crosses an exclusion, and a route begins at its first item."""
        run, modes = self.run, self.run.vehicle.modes
        number, sequence = message.fields.get('command'), run.drone.session.sequence
        is_known = self.is_armed and None not in (self.place, self.home)
        goal = (message['x'], message['y']) if number == 192 else None
        if number == 176 and modes['return'] in self._leads_to(message):
            goal = self.home
        entry = run.journal.entry
        is_open = entry is not None and entry.outcome in (None, FlightOutcome.LOST)
        if run.has_zone and goal is not None and is_known and is_open:
            assert not crosses(self.place, goal), f'{what}: across an exclusion'
        is_resumed = sequence is not None and not sequence.is_over and sequence.name == 'resume'
        if modes['mission'] in self._leads_to(message):
            assert not (is_resumed and self.is_given_up), f'{what}: its route was given up'
            # In the mission already it goes on by itself, whatever is sent.
            is_low = self.height_m < 1.0 and self.mode != modes['mission']
            if run.vehicle.kind.drives:
                flight = run.drone.session.flight
                is_low = is_low and flight is not None and flight.is_beginning
            is_first = run.vehicle.kind.starts_anywhere or self.current <= run.first + 1
            assert is_first or not is_low, f'{what}: it would begin at item {self.current}'

    def _judge_mission(self, message, what):
        """Nothing is started or resumed but a mission of a plan."""
        modes = self.run.vehicle.modes
        number = message.fields.get('command')
        starts = modes['mission'] in self._leads_to(message) or number in (224, 300)
        run = self.run
        if not starts:
            return
        # A way home around an exclusion is of no plan.
        is_homeward = run.drone.session.sequence is not None
        is_homeward = is_homeward and run.drone.session.sequence.name == 'return home'
        counts = {len(items) - run.first for items in run.plans}
        counts |= {len(self.offered) - run.first} if is_homeward else set()
        assert self.total in {0, *counts}, f'{what}: {self.total} items were told'
        if not run.was_just_changed:
            stored = run.vehicle.stored[0]
            is_offered = [kept[6:] for kept in stored[run.first :]] == self.offered[run.first :]
            is_known = run.is_planned(stored) or (is_homeward and is_offered)
            assert is_known, f'{what}: not verified, {len(stored)} items'

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
