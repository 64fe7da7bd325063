# SPDX-License-Identifier: Apache-2.0
"""Outcomes of a flight, and the failsafe that an autopilot's text announces."""

import re
from enum import Enum


class FlightOutcome(Enum):
    """Named ends of a flight."""

    COMPLETED = 'completed'
    ABORTED_BY_OPERATOR = 'aborted by operator'
    FAILSAFE_BATTERY = 'failsafe: battery'
    FAILSAFE_LINK = 'failsafe: link'
    FAILSAFE_FENCE = 'failsafe: fence'
    FAILSAFE_GPS = 'failsafe: position'
    FAILSAFE_OTHER = 'failsafe'
    REJECTED = 'rejected'
    RESTARTED = 'autopilot started again'
    LOST = 'lost'


_WORDS = (
    ('battery failsafe', FlightOutcome.FAILSAFE_BATTERY),
    # All that an ArduPilot Rover says of it, and its status stays as it was.
    (r'battery \d+ is (low|critical)', FlightOutcome.FAILSAFE_BATTERY),
    # It switches a Rover to a mode that obeys.
    (r'\bcrash: ', FlightOutcome.FAILSAFE_OTHER),
    ('gcs failsafe', FlightOutcome.FAILSAFE_LINK),
    ('ekf failsafe', FlightOutcome.FAILSAFE_GPS),
    ('fence breached', FlightOutcome.FAILSAFE_FENCE),
    # PX4, see `px4_events`.
    ('failsafe: gcs connection loss', FlightOutcome.FAILSAFE_LINK),
    ('failsafe: low battery', FlightOutcome.FAILSAFE_BATTERY),
    ('failsafe: critical battery', FlightOutcome.FAILSAFE_BATTERY),
    ('failsafe: emergency battery', FlightOutcome.FAILSAFE_BATTERY),
    ('failsafe: remaining flight time', FlightOutcome.FAILSAFE_BATTERY),
    ('geofence violation: ', FlightOutcome.FAILSAFE_FENCE),
    # Remote control, terrain, and failsafes that are not known here.
    ('failsafe', FlightOutcome.FAILSAFE_OTHER),
)
# These texts announce no failsafe: checks before arming, warnings, failsafes that have ended.
_BEFORE_ARMING = ('prearm:', 'arm:')
_HARMLESS = ('cleared', 'failsafe warning', 'deactivated')


def failsafe_of(text: str) -> FlightOutcome | None:
    """Return the failsafe that a text of an autopilot announces; None if it announces none."""
    said = text.lower()
    if said.startswith(_BEFORE_ARMING) or any(words in said for words in _HARMLESS):
        return None
    return next((outcome for words, outcome in _WORDS if re.search(words, said)), None)
