# SPDX-License-Identifier: Apache-2.0
"""Answers of a vehicle that is only shown: what may be read is told, all else is refused."""

from collections.abc import Iterator

from rocsafe_mavlink.view.sight import Sight
from rocsafe_mavlink.view.telemetry_messages import AUTOPILOT, autopilot_version, heartbeat
from rocsafe_mavlink.wire.authority import REQUEST_MESSAGE
from rocsafe_mavlink.wire.dialect import Message, addressed

AUTOPILOT_VERSION_ID, HEARTBEAT_ID = 148, 0
REQUEST_CAPABILITIES = 520
ACCEPTED, DENIED = 0, 2
MISSION_DENIED, MISSION_INVALID_SEQUENCE = 14, 13
MISSION, SINGLE_PARAMETER, REAL_32 = 0, 'ROCSAFE_VIEW', 9
# Messages that would change a vehicle or its mission.
MISSION_WRITES = frozenset(
    {
        'MISSION_COUNT',
        'MISSION_WRITE_PARTIAL_LIST',
        'MISSION_CLEAR_ALL',
        'MISSION_SET_CURRENT',
        'MISSION_ITEM',
        'MISSION_ITEM_INT',
    }
)
PARAMETERS = frozenset({'PARAM_REQUEST_LIST', 'PARAM_REQUEST_READ', 'PARAM_SET'})


def answers(sight: Sight, asked: Message) -> Iterator[Message]:
    """Yield the answers of a vehicle to a message for it; none to what needs none.

    Nothing that is asked changes anything: commands are denied, but for requests of a message that
    tells who it is; missions can be read and not written; the one parameter keeps its value.
    """
    target = (asked.system, asked.component)
    if asked.name in ('COMMAND_LONG', 'COMMAND_INT'):
        yield from _command(sight, asked, target)
    elif asked.name == 'MISSION_REQUEST_LIST':
        kind = int(asked['mission_type'])
        count = len(sight.items) if kind == MISSION else 0
        yield _of(sight, 'MISSION_COUNT', target, count=count, mission_type=kind)
    elif asked.name in ('MISSION_REQUEST_INT', 'MISSION_REQUEST'):
        yield _item(sight, asked, target)
    elif asked.name in MISSION_WRITES:
        kind = int(asked.fields.get('mission_type', MISSION))
        yield _of(sight, 'MISSION_ACK', target, type=MISSION_DENIED, mission_type=kind)
    elif asked.name in PARAMETERS:
        yield Message(
            'PARAM_VALUE',
            {
                'param_id': SINGLE_PARAMETER,
                'param_value': 1.0,
                'param_type': REAL_32,
                'param_count': 1,
            },
            sight.system,
            AUTOPILOT,
        )


def _command(sight: Sight, asked: Message, target: tuple[int, int]) -> Iterator[Message]:
    number = int(asked['command'])
    # A number that is NaN, which commands may hold, is no message's.
    wanted = asked['param1'] if number == REQUEST_MESSAGE else None
    is_version = number == REQUEST_CAPABILITIES or wanted == AUTOPILOT_VERSION_ID
    is_told = is_version or wanted == HEARTBEAT_ID
    yield _of(sight, 'COMMAND_ACK', target, command=number, result=ACCEPTED if is_told else DENIED)
    if is_told:
        yield autopilot_version(sight) if is_version else heartbeat(sight)


def _item(sight: Sight, asked: Message, target: tuple[int, int]) -> Message:
    number, kind = int(asked['seq']), int(asked['mission_type'])
    if kind != MISSION or number >= len(sight.items):
        error = MISSION_INVALID_SEQUENCE
        return _of(sight, 'MISSION_ACK', target, type=error, mission_type=kind)
    told = sight.items[number].message(number, target, kind)
    return Message(told.name, told.fields, sight.system, AUTOPILOT)


def _of(sight: Sight, name: str, target: tuple[int, int], **fields: object) -> Message:
    message = addressed(name, target, **fields)
    return Message(name, message.fields, sight.system, AUTOPILOT)
