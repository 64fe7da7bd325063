# SPDX-License-Identifier: Apache-2.0
"""Reasons for which a PX4 left its mission, from its events; its texts do not name the failsafe.

An event is a number made from its name, with arguments that only PX4's own source describes
(events.h, failsafe/framework.cpp and geofenceCheck.cpp of August 2025). The few that matter are
turned into texts, so that people and flights see them like any other text.
"""

from collections.abc import Mapping

from rocsafe_mavlink.wire.dialect import Message

_FNV_OFFSET, _FNV_PRIME = 0x811C9DC5, 0x01000193
_AUTOPILOT = 1 << 24
# failsafe_cause_t of events/enums.json.
_CAUSES: Mapping[int, str] = {
    1: 'manual control loss',
    2: 'GCS connection loss',
    3: 'low battery level',
    4: 'critical battery level',
    5: 'emergency battery level',
    6: 'remaining flight time low',
}


def event_number(name: str) -> int:
    """Return the number of an autopilot's event: 24 bits of the FNV-1a hash of its name."""
    value = _FNV_OFFSET
    for letter in name.encode():
        value = (value ^ letter) * _FNV_PRIME & 0xFFFFFFFF
    return value & 0xFFFFFF | _AUTOPILOT


# Index of the cause among the arguments: after mode and action, and the delay if there is one.
_FAILSAFES = {
    event_number('commander_failsafe_enter'): 5,
    event_number('commander_failsafe_enter_hold'): 7,
}
_UNTOLD = 'Failsafe: cause not told'
_FENCE = 'Geofence violation:'
_TEXTS = {
    event_number('commander_failsafe_enter_generic'): _UNTOLD,
    event_number('commander_failsafe_enter_generic_hold'): _UNTOLD,
    event_number('check_gf_violation_max_hor_dist'): f'{_FENCE} beyond maximum distance to home',
    event_number('check_gf_violation_max_alt'): f'{_FENCE} beyond maximum altitude above home',
    event_number('check_gf_violation_custom_gf'): f'{_FENCE} approaching or outside geofence',
}


def text_of_event(event: Message) -> Message:
    """Return the STATUSTEXT with the meaning of an EVENT; the event itself if it is not known."""
    number = int(event['id'])
    if number in _TEXTS:
        return _text(event, _TEXTS[number])
    if number not in _FAILSAFES:
        return event
    cause = _CAUSES.get(event['arguments'][_FAILSAFES[number]])
    return _text(event, f'Failsafe: {cause}' if cause else _UNTOLD)


def _text(event: Message, text: str) -> Message:
    severity = min(int(event['log_levels']) & 0xF, 7)
    return Message(
        'STATUSTEXT', {'severity': severity, 'text': text}, event.system, event.component
    )
