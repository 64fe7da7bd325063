# SPDX-License-Identifier: Apache-2.0
"""A fake copter and what a station knows of it, in simulated time."""

from test.fakes.fake_autopilot import IDS, FakeCopter

from rocsafe_mavlink.knowledge.events import EventKind
from rocsafe_mavlink.knowledge.reducer import reduce
from rocsafe_mavlink.knowledge.telemetry import VehicleTelemetry
from rocsafe_mavlink.protocols import command_call as commands
from rocsafe_mavlink.protocols.command_call import CommandCall, HeardText
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.mission_transfer import transfer
from rocsafe_mavlink.wire.dialect import Message

TARGET, US = (1, 1), (255, 190)
TICK_S = 0.1
STATION = Message('HEARTBEAT', {'type': 6, 'autopilot': 8})
HOME = (47.397742, 8.545594)


def survey(count=3, *, takeoff=True):
    """Return home, take-off, waypoints 50 m apart to the north, and return."""
    waypoints = [
        MissionItem(command=16, x_e7=473977420 + 4500 * (number + 1), y_e7=85455940, z_m=30.0)
        for number in range(count)
    ]
    start = [MissionItem(command=22, z_m=30.0)] if takeoff else []
    return [MissionItem(command=16, frame=0), *start, *waypoints, MissionItem(command=20)]


class Sky:
    """Steps copter and station together."""

    def __init__(self, **options):
        self.copter = FakeCopter(**options)
        self.vehicle = VehicleTelemetry(system=1, component=1)
        self.now_s = 0.0
        self.is_station_alive = True
        self.events = []
        self.heard = []
        self.machines = []

    def step(self):
        """Let a tenth of a second pass."""
        self.now_s = round(self.now_s + TICK_S, 3)
        if self.is_station_alive and round(self.now_s * 10) % 10 == 0:
            self.copter.receive(STATION)
        for message in self.copter.step(self.now_s):
            self.vehicle, events = reduce(self.vehicle, message, self.now_s)
            self.events += events
            self.heard += [
                HeardText(self.now_s, event.text)
                for event in events
                if event.kind is EventKind.TEXT
            ]
            yield message

    def run(self, until, limit_s=400.0):
        """Step until `until()` holds; fail after `limit_s`."""
        end_s = self.now_s + limit_s
        while not until():
            assert self.now_s < end_s, f'not within {limit_s} s'
            for _ in self.step():
                pass

    def wait(self, seconds):
        """Let time pass."""
        end_s = self.now_s + seconds
        self.run(lambda: self.now_s >= end_s - 1e-6, seconds + 1.0)

    def call(self, command):
        """Send a command and return the finished call."""
        call, sent = CommandCall(command=command, us=US).begin(self.now_s, self.heard)
        self.give(sent)
        while not call.is_over:
            for message in self.step():
                call = call.on_message(message, self.now_s)
            call, sent = call.on_tick(self.now_s)
            self.give(sent)
        return call

    def upload(self, items):
        """Transfer a mission and return the finished transfer."""
        moved, sent = transfer(items, TARGET, first_compared=1).begin(self.now_s)
        self.give(sent)
        while not moved.is_over:
            for message in self.step():
                moved, sent = moved.on_message(message, self.now_s)
                self.give(sent)
            moved, sent = moved.on_tick(self.now_s)
            self.give(sent)
        return moved

    def give(self, messages):
        """Hand messages to the copter."""
        for message in messages:
            self.copter.receive(message)

    def ask_for_rates(self):
        """Ask for every message that it knows, five times a second."""
        for number in IDS:
            self.give([commands.set_interval(TARGET, number, 5.0)])

    @property
    def texts(self):
        """All that the copter said."""
        return [word.text for word in self.heard]
