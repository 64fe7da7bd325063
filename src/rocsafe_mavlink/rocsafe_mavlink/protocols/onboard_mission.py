# SPDX-License-Identifier: Apache-2.0
"""State of the mission stored on a vehicle: verified, torn or unknown."""

from dataclasses import dataclass, replace
from enum import Enum

from rocsafe_mavlink.protocols.mission_item import MissionItem


class MissionCondition(Enum):
    """How well a mission on a vehicle is known."""

    UNKNOWN = 'unknown'
    TORN = 'torn'
    VERIFIED = 'verified'


@dataclass(frozen=True, slots=True, kw_only=True)
class OnboardMission:
    """The mission on a vehicle; its owner changes it by the methods below only.

    Attributes
    ----------
    condition
        UNKNOWN
        Another station, a restart or a lost link may have changed it. TORN: an upload of
        ours began and was not verified. VERIFIED: what we sent was read back as it was
        sent.
    items
        The mission as it was last read from the vehicle since it was found in the air; None: not
        read.
    """

    condition: MissionCondition = MissionCondition.UNKNOWN
    items: tuple[MissionItem, ...] | None = None

    def upload_begun(self) -> 'OnboardMission':
        """Return the state once the first item may have been overwritten."""
        return replace(self, condition=MissionCondition.TORN)

    def verified(self, items: tuple[MissionItem, ...]) -> 'OnboardMission':
        """Return the state once `items` were read back and are those of our plan."""
        return OnboardMission(condition=MissionCondition.VERIFIED, items=items)

    def read(self, items: tuple[MissionItem, ...]) -> 'OnboardMission':
        """Return the state once the mission was read; it is verified by a comparison only."""
        return OnboardMission(items=items)

    def unread(self) -> 'OnboardMission':
        """Return the state in which the mission is to be read again."""
        return replace(self, items=None)

    def forgotten(self) -> 'OnboardMission':
        """Return the state of a vehicle whose mission may have changed."""
        return OnboardMission()
