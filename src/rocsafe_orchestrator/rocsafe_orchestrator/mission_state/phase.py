# SPDX-License-Identifier: Apache-2.0
"""The phases of a mission; numbers are those of ``MissionState.msg``."""

from enum import IntEnum


class Phase(IntEnum):
    """What the mission is doing."""

    STARTING = 0
    PLANNING = 1
    FLYING = 2
    COLLECTING = 3
    MAPPING = 4
    REPORTING = 5
    COMPLETE = 6
    FAILED = 7
    CANCELLED = 8
    DRIVING = 9

    @property
    def is_over(self) -> bool:
        """True if no other phase follows."""
        return Phase.COMPLETE <= self <= Phase.CANCELLED
