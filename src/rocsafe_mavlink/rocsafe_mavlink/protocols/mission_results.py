# SPDX-License-Identifier: Apache-2.0
"""Meaning of the number of a MISSION_ACK."""

from collections.abc import Mapping
from enum import IntEnum


class MissionType(IntEnum):
    """MAV_MISSION_TYPE."""

    MISSION = 0
    FENCE = 1
    RALLY = 2

    @property
    def word(self) -> str:
        """Word for people."""
        return self.name.lower()


ACCEPTED, REFUSED, INVALID_SEQUENCE, CANCELLED = 0, 1, 13, 15
RESULTS: Mapping[int, str] = {
    1: 'refused (generic error)',
    2: 'coordinate frame not supported',
    3: 'command not supported',
    4: 'no space for so many items',
    5: 'invalid',
    6: 'param1 invalid',
    7: 'param2 invalid',
    8: 'param3 invalid',
    9: 'param4 invalid',
    10: 'latitude invalid',
    11: 'longitude invalid',
    12: 'height invalid',
    13: 'item out of sequence',
    14: 'denied: another station transfers a mission',
    15: 'transfer cancelled',
}
# Another try may succeed after these.
PASSING = frozenset({1, 14, 15})


def result_text(result: int) -> str:
    """Return the words for the number of a MISSION_ACK."""
    return RESULTS.get(result, f'refused (result {result})')
