# SPDX-License-Identifier: Apache-2.0
"""How a flight ended, and what the autopilot's own words say about why."""

from enum import Enum


class Outcome(Enum):
    """Named ends of a flight."""

    COMPLETED = 'completed'
    ABORTED_BY_OPERATOR = 'aborted by operator'
    FAILSAFE_BATTERY = 'failsafe: battery'
    FAILSAFE_LINK = 'failsafe: link'
    FAILSAFE_FENCE = 'failsafe: fence'
    FAILSAFE_GPS = 'failsafe: position'
    REJECTED = 'rejected'
    RESTARTED = 'autopilot started again'
    LOST = 'lost'


_WORDS = (
    ('battery failsafe', Outcome.FAILSAFE_BATTERY),
    ('gcs failsafe', Outcome.FAILSAFE_LINK),
    ('ekf failsafe', Outcome.FAILSAFE_GPS),
    ('fence breached', Outcome.FAILSAFE_FENCE),
    # PX4, see `px4_events`.
    ('failsafe: gcs connection loss', Outcome.FAILSAFE_LINK),
    ('failsafe: low battery', Outcome.FAILSAFE_BATTERY),
    ('failsafe: critical battery', Outcome.FAILSAFE_BATTERY),
    ('failsafe: emergency battery', Outcome.FAILSAFE_BATTERY),
    ('failsafe: remaining flight time', Outcome.FAILSAFE_BATTERY),
    ('geofence violation: ', Outcome.FAILSAFE_FENCE),
)


def failsafe_of(text: str) -> Outcome | None:
    """Return the failsafe that a text of an autopilot announces, None if it announces none."""
    said = text.lower()
    if 'cleared' in said:
        return None
    return next((outcome for words, outcome in _WORDS if words in said), None)
