# SPDX-License-Identifier: Apache-2.0
"""Missions over a radio that loses, delays, repeats, reorders and falls silent.

Whole stations and copters with bytes between them, in simulated time. Whatever the radio does: a
mission is whole on the vehicle or not flown, progress never goes back, and the result is true.
"""

import heapq

import numpy as np
import pytest
from test.mavlink.test_station import Air, may_fly
from test.mavlink.wire import DRONE

from rocsafe_mavlink.flight.flight import FlightStage
from rocsafe_mavlink.flight.flight_outcome import FlightOutcome
from rocsafe_mavlink.protocols.mission_transfer import compare
from rocsafe_mavlink.wire.dialect import decode
from rocsafe_mavlink.wire.framing import scan

READY_S = 46.0


class Radio:
    """What happens to a datagram.

    Parameters
    ----------
    loss : share that is lost.
    delay_s : longest delay; each datagram has its own, so that they overtake each other.
    twice : share that arrives twice.
    silence_s, every_s : so long nothing passes, so often.
    """

    def __init__(self, loss=0.0, delay_s=0.02, twice=0.0, silence_s=0.0, every_s=60.0, seed=1):
        self.source = np.random.default_rng(seed)
        self.loss, self.delay_s, self.twice = loss, delay_s, twice
        self.silence_s, self.every_s = silence_s, every_s

    def arrivals_s(self, now_s):
        """Return when a datagram that is sent now arrives: never, once or twice."""
        is_silent = now_s > READY_S and (now_s - READY_S) % self.every_s < self.silence_s
        if is_silent or self.source.random() < self.loss:
            return []
        count = 2 if self.source.random() < self.twice else 1
        return [now_s + self.source.uniform(0.02, self.delay_s) for _ in range(count)]


class RadioAir(Air):
    """An air whose bytes go by radio."""

    def __init__(self, radio, count=1):
        super().__init__(count)
        self.radio = radio
        self.under_way = []
        self.number = 0
        self.visits = [0]

    def say(self, data, address=DRONE):  # noqa: ARG002 - there is one
        """Send bytes to the station."""
        self._send('station', data)

    def carry(self):
        """Send what the station sends."""
        outgoing, self.wires.sent = self.wires.sent, []
        for _address, data in outgoing:
            self._send('copters', data)

    def step(self):
        """Let a tenth of a second pass."""
        super().step()
        while self.under_way and self.under_way[0][0] <= self.now_s:
            _, _, receiver, data = heapq.heappop(self.under_way)
            if receiver == 'station':
                super().say(data)
            else:
                self._arrive(data)
        flight = self.flight()
        if flight is not None:
            self.visits.append(flight.visited)

    def _send(self, receiver, data):
        for at_s in self.radio.arrivals_s(self.now_s):
            self.number += 1
            heapq.heappush(self.under_way, (at_s, self.number, receiver, data))

    def _arrive(self, data):
        (frame,) = scan(data, is_whole=True).frames
        message = decode(frame.message_id, frame.payload, frame.system, frame.component)
        for system, copter in self.copters.items():
            if message.fields.get('target_system', 0) in (0, system):
                copter.receive(message, (frame.system, frame.component))


RADIOS = {
    'clean': {},
    'loss 5 %': {'loss': 0.05},
    'loss 20 %': {'loss': 0.2, 'delay_s': 0.3},
    'loss 40 %': {'loss': 0.4},
    'delay 800 ms': {'delay_s': 0.8},
    'twice': {'twice': 0.5, 'delay_s': 0.4},
    'silences': {'silence_s': 10.0, 'every_s': 40.0},
    'all': {'loss': 0.2, 'delay_s': 0.8, 'twice': 0.2, 'silence_s': 10.0, 'every_s': 60.0},
}


@pytest.mark.parametrize('name', RADIOS)
def test_flight_over_a_bad_radio(name):
    """It is flown whole and said so, or refused with nothing armed; progress never goes back."""
    air = RadioAir(Radio(**RADIOS[name]))
    air.until(lambda: air.now_s > READY_S and may_fly(air), 900.0)
    armed_with = []

    def is_over():
        if air.copters[1].is_armed and not armed_with:
            armed_with.append(list(air.copters[1].missions.stored[0]))
        return air.flight().is_over

    air.until(is_over, 1500.0)
    assert air.visits == sorted(air.visits)
    for stored in armed_with:
        assert compare(air.flight().mission.items, stored, 1) == ''
    if air.flight().outcome is FlightOutcome.COMPLETED:
        assert air.flight().visited == 3
    else:
        assert air.flight().outcome is FlightOutcome.REJECTED
        assert 'loss 40' in name or 'all' in name or 'silences' in name
    air.until(lambda: not air.copters[1].is_armed, 300.0)


def test_lossless_radios_complete():
    """Delay, order and repetition alone cost time, never the flight."""
    for options in ({'delay_s': 0.8}, {'twice': 1.0, 'delay_s': 0.6}):
        air = RadioAir(Radio(seed=5, **options))
        air.until(lambda: air.now_s > READY_S and may_fly(air), 900.0)  # noqa: B023
        air.until(lambda: air.flight().is_over, 900.0)  # noqa: B023
        assert air.flight().outcome is FlightOutcome.COMPLETED


def test_silence_in_flight_changes_nothing():
    """Ten seconds without a word: it flies on, and nothing is sent for its having come back."""
    air = RadioAir(Radio())
    air.until(lambda: air.now_s > READY_S and may_fly(air))
    air.until(lambda: air.flight().stage is FlightStage.FLYING and air.flight().visited >= 1)
    before = [number for number in air.copters[1].commands if number != 511]
    air.radio.loss = 1.0
    air.wait(11.0)
    air.radio.loss = 0.0
    air.until(lambda: air.flight().is_over)
    assert air.flight().outcome is FlightOutcome.COMPLETED
    assert [number for number in air.copters[1].commands if number != 511] == before


def test_landing_that_nobody_heard_is_told_by_the_mission():
    """Silent from the first waypoint to the ground: its mission says that it is complete."""
    air = RadioAir(Radio())
    air.until(lambda: air.now_s > READY_S and may_fly(air))
    air.until(lambda: air.flight().visited >= 1)
    air.radio.loss = 1.0
    air.until(lambda: not air.copters[1].is_armed)
    air.radio.loss = 0.0
    air.until(lambda: air.flight().is_over, 60.0)
    assert (air.flight().outcome, air.flight().visited) == (FlightOutcome.COMPLETED, 3)


@pytest.mark.parametrize('fault', ['fence', 'receiver'])
def test_failsafe_whose_words_were_lost_is_seen(fault):
    """The fence's status, or the estimate's flags, say what the text would have said."""
    air = RadioAir(Radio())
    air.until(lambda: air.now_s > READY_S and may_fly(air))
    air.until(lambda: air.flight().visited >= 1)
    air.copters[1]._text = lambda *_words: None
    if fault == 'fence':
        air.copters[1].breach_fence()
    else:
        air.copters[1].has_gps = False
    air.until(lambda: air.flight().is_over)
    wanted = FlightOutcome.FAILSAFE_FENCE if fault == 'fence' else FlightOutcome.FAILSAFE_GPS
    assert air.flight().outcome is wanted
