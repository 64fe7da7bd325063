# SPDX-License-Identifier: Apache-2.0
"""Whatever a link does, a mission is called verified only if it lies whole on the vehicle."""

import itertools
import os

import numpy as np
import pytest
from test.fakes.channel import Channel, Fault
from test.fakes.mission_store import MissionStore

from rocsafe_mavlink.drone.readout import Readout
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.mission_transfer import (
    TransferStage,
    compare,
    transfer,
)
from rocsafe_mavlink.protocols.onboard_mission import MissionCondition
from rocsafe_mavlink.protocols.stream_rates import StreamRates
from rocsafe_mavlink.wire.dialect import Message

TARGET, STATION = (1, 1), (255, 190)
TICK_S = 0.25
DEADLINE_S = 400.0
OLD_MISSION = 4


def survey(count, shift=0):
    """Return `count` items: home, take-off, waypoints, and return at the end if there is room."""
    waypoints = [
        MissionItem(command=16, x_e7=473979219 + 1000 * (number + shift), y_e7=85458589, z_m=50.0)
        for number in range(count)
    ]
    items = [MissionItem(command=16, frame=0), MissionItem(command=22, z_m=50.0), *waypoints]
    return [*items[: count - 1], MissionItem(command=20)] if count > 2 else items[:count]


class Rig:
    """A transfer, a fake autopilot with an older mission, and the link between them."""

    def __init__(self, items, fault_of=lambda _number: None, **options):
        self.store = MissionStore(**options)
        self.store.stored[0] = [self.store.home, *survey(OLD_MISSION, shift=77)[1:]]
        self.channel = Channel(fault_of)
        self.transfer = transfer(items, TARGET, first_compared=1)
        self.now_s = 0.0
        self.texts = []

    def run(self):
        """Let the transfer come to its end; return it."""
        self.transfer, sent = self.transfer.begin(self.now_s)
        self.post(self.store, sent)
        next_tick_s = TICK_S
        while not self.transfer.is_over:
            assert self.now_s < DEADLINE_S, 'the transfer never ends'
            arrival_s = self.channel.next_s()
            self.now_s = next_tick_s if arrival_s is None else min(arrival_s, next_tick_s)
            for receiver, message in self.channel.arrived(self.now_s):
                self.deliver(receiver, message)
            if self.now_s >= next_tick_s:
                next_tick_s += TICK_S
                self.transfer, sent = self.transfer.on_tick(self.now_s)
                self.post(self.store, sent)
                self.post(self, self.store.tick(self.now_s))
        return self.transfer

    def post(self, receiver, messages):
        """Put messages on their way."""
        for message in messages:
            self.channel.send(receiver, message, self.now_s)

    def deliver(self, receiver, message):
        """Hand over what has arrived."""
        if receiver is self.store:
            self.post(self, self.store.receive(message, STATION, self.now_s))
            return
        if message.name == 'STATUSTEXT':
            self.texts.append(message['text'])
        self.transfer, sent = self.transfer.on_message(message, self.now_s)
        self.post(self.store, sent)

    def require_truth(self):
        """Verified means whole; failed means empty where it says so."""
        if self.transfer.stage is TransferStage.VERIFIED:
            assert compare(self.transfer.upload.items, self.store.stored[0], 1) == ''
        else:
            assert self.transfer.error
            assert not self.transfer.is_cleared or self.store.stored[0] == []


@pytest.mark.parametrize('count', [0, 1, 2, 6, 500])
@pytest.mark.parametrize('asks_by', ['MISSION_REQUEST', 'MISSION_REQUEST_INT'])
def test_mission_is_sent_and_read_back(count, asks_by):
    """On a good link at the first try, whichever way the autopilot asks."""
    rig = Rig(survey(count), asks_by=asks_by)
    assert rig.run().stage is TransferStage.VERIFIED
    assert rig.transfer.tries == 1
    rig.require_truth()
    assert len(rig.store.stored[0]) == count


def placements(count, largest):
    """Return every way to give up to `largest` of the first `count` messages a fault."""
    for size in range(largest + 1):
        for places in itertools.combinations(range(count), size):
            for faults in itertools.product(Fault, repeat=size):
                yield dict(zip(places, faults, strict=True))


# A transfer of n items takes 4 n + 7 messages when nothing goes wrong.
EXHAUSTIVE = [(1, 2), (2, 2), (3, 1), (4, 1), (5, 1), (6, 1)]
if os.environ.get('ROCSAFE_EXHAUSTIVE'):
    EXHAUSTIVE = [(1, 3), (2, 2), (3, 2), (4, 2), (5, 2), (6, 2)]


@pytest.mark.slow
@pytest.mark.parametrize(('count', 'largest'), EXHAUSTIVE)
def test_every_placement_of_faults(count, largest):
    """Each way to lose, repeat or delay up to so many messages ends well, and by itself."""
    for faults in placements(4 * count + 7, largest):
        rig = Rig(survey(count), faults.get)
        assert rig.run().stage is TransferStage.VERIFIED, faults
        rig.require_truth()


@pytest.mark.slow
@pytest.mark.parametrize('loss', [0.05, 0.2, 0.4, 0.7])
def test_lossy_link_never_verifies_what_is_not_there(loss):
    """At any loss the word is true; up to 40 % the mission gets there."""
    verified = 0
    for seed in range(40):
        source = np.random.default_rng([11, seed])
        kinds = list(Fault)

        def fault_of(_number, source=source, kinds=kinds):
            if source.random() < loss:
                return Fault.LOST
            return kinds[int(source.integers(4))] if source.random() < 0.1 else None

        rig = Rig(survey(12), fault_of)
        verified += rig.run().stage is TransferStage.VERIFIED
        rig.require_truth()
    assert verified == 40 or loss > 0.2
    assert verified >= 38 or loss > 0.4


@pytest.mark.parametrize(
    ('item', 'words'),
    [
        (MissionItem(command=999), 'command not supported at item 3'),
        (MissionItem(command=16, x_e7=910000000), 'latitude invalid at item 3'),
        (MissionItem(command=16, frame=21), 'coordinate frame not supported at item 3'),
    ],
)
def test_refused_item_leaves_nothing_half_written(item, words):
    """The reason is the autopilot's, and what had arrived is cleared."""
    items = survey(6)
    items[3] = item
    rig = Rig(items)
    assert rig.run().stage is TransferStage.FAILED
    assert rig.transfer.error == words
    assert rig.transfer.is_cleared
    assert rig.store.stored[0] == []
    assert rig.transfer.tries == 1


def test_too_many_items_are_refused():
    """The autopilot's limit is told."""
    rig = Rig(survey(651))
    assert rig.run().error == 'no space for so many items'


def test_silent_vehicle_is_given_up():
    """Nobody there: an end, a reason, and no claim that anything was cleared."""
    rig = Rig(survey(6), lambda _number: Fault.LOST)
    assert rig.run().stage is TransferStage.FAILED
    assert 'no answer' in rig.transfer.error
    assert not rig.transfer.is_cleared
    assert rig.now_s < 35.0


def test_interrupted_upload_is_tried_again():
    """Ten seconds of silence in the middle: the autopilot gives up, the second try gets there."""
    rig = Rig(survey(6), lambda _number: Fault.LOST if 0.05 < rig.now_s < 10.05 else None)
    assert rig.run().stage is TransferStage.VERIFIED
    assert rig.transfer.tries > 1
    rig.require_truth()


def test_mission_that_cannot_be_cleared_is_said():
    """In flight the autopilot refuses to clear."""
    items = [*survey(5), MissionItem(command=999)]
    rig = Rig(items)
    rig.store.is_flying = True
    assert 'clearing it: refused' in rig.run().error
    assert not rig.transfer.is_cleared


def test_other_stations_transfer_is_waited_out():
    """While another station uploads we are denied, and try again."""
    rig = Rig(survey(6))
    rig.store.receive(Message('MISSION_COUNT', {'count': 9}), (254, 190), 0.0)
    assert rig.run().error.startswith('denied')


def test_request_that_the_link_doubled_is_answered_once():
    """An autopilot that asks again for each item that came twice would get them without end."""
    begun, _ = transfer(survey(3), TARGET, first_compared=1).begin(0.0)
    first, asking = (
        Message('MISSION_REQUEST_INT', {'seq': number, 'mission_type': 0}, *TARGET)
        for number in range(2)
    )
    going, sent = begun.on_message(first, 0.1)
    assert [item['seq'] for item in sent] == [0]
    again, nothing = going.on_message(first, 0.15)
    assert (again, nothing) == (going, [])
    # It asks again by itself no sooner than after 0.25 s: the item was lost.
    _, repeated = going.on_message(first, 0.35)
    assert [item['seq'] for item in repeated] == [0]
    _, following = going.on_message(asking, 0.11)
    assert [item['seq'] for item in following] == [1]


def test_other_vehicles_words_change_nothing():
    """An acknowledgement of another vehicle on the link is not ours."""
    begun, _ = transfer(survey(3), TARGET, first_compared=1).begin(0.0)
    for system, component in ((2, 1), (1, 100)):
        foreign = Message('MISSION_ACK', {'type': 1, 'mission_type': 0}, system, component)
        assert begun.on_message(foreign, 0.1) == (begun, [])
    fence = Message('MISSION_ACK', {'type': 1, 'mission_type': 1}, 1, 1)
    assert begun.on_message(fence, 0.1) == (begun, [])


def test_altered_mission_is_sent_again_and_then_refused():
    """What comes back different each time is not flown."""
    rig = Rig(survey(6))
    keep = rig.store._keep

    def keep_lower(message, kind):
        fields = {**message.fields, 'z': message['z'] - 1.0}
        keep(Message(message.name, fields), kind)

    rig.store._keep = keep_lower
    assert rig.run().stage is TransferStage.FAILED
    assert rig.transfer.error == 'item 1 read back: z_m is 49, sent was 50'
    assert rig.transfer.tries == 5
    assert rig.store.stored[0] == []


def fence(count):
    """Return the corners of a fence."""
    return [
        MissionItem(
            command=5001,
            frame=3,
            x_e7=473977420 + 900 * number * number,
            y_e7=85455940 + 900 * number,
            parameters=(float(count), 0.0, 0.0, 0.0),
        )
        for number in range(count)
    ]


def test_fence_goes_the_same_way():
    """A fence is read back like a mission, its first corner too, and leaves the mission alone."""
    rig = Rig(())
    rig.transfer = transfer(fence(4), TARGET, first_compared=0, mission_type=1)
    assert rig.run().stage is TransferStage.VERIFIED
    assert compare(fence(4), rig.store.stored[1], 0) == ''
    assert len(rig.store.stored[0]) > 0


def test_fence_of_two_corners_is_refused():
    """The autopilot's check comes after the last corner; nothing of it stays."""
    rig = Rig(())
    rig.transfer = transfer(fence(2), TARGET, first_compared=0, mission_type=1)
    assert rig.run().error.startswith('refused')
    assert 'Fence validation failed' in rig.texts
    assert rig.store.stored[1] == []


def test_reading_that_was_begun_before_an_upload_tells_nothing():
    """Its first part is of the old mission, its second may be of the new one: torn is torn."""
    readout = Readout(target=TARGET, rates=StreamRates(2.0))
    readout._begin(MissionType.MISSION, 0.0)
    readout.on_message(Message('MISSION_COUNT', {'count': 1, 'mission_type': 0}), 0.1)
    readout.overwritten(MissionType.MISSION)
    fields = {'seq': 0, 'frame': 0, 'command': 16, 'x': 0, 'y': 0, 'z': 0.0, 'mission_type': 0,
              'autocontinue': 1, **{f'param{k}': 0.0 for k in range(1, 5)}}  # fmt: skip
    readout.on_message(Message('MISSION_ITEM_INT', fields), 0.2)
    assert readout.mission.condition is MissionCondition.TORN
    assert readout.mission.items is None
