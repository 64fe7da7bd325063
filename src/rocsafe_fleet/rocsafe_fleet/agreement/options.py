# SPDX-License-Identifier: Apache-2.0
"""Options of the agreement."""

from dataclasses import dataclass, field

from rocsafe_fleet.membership.membership import MembershipOptions
from rocsafe_geo.limits import require_not_negative, require_positive

MOST_AGENTS = 20
MOST_POINTS = 2400
"""A proposal is sent in one packet: 17 bytes a vehicle and up to 2 bits a viewpoint."""


@dataclass(frozen=True, slots=True, kw_only=True)
class AgreementOptions:
    """Constants of the agreement; times are in seconds.

    Attributes
    ----------
    membership
        Detection of losses.
    settle_s
        A coordinator proposes so long after it saw a reason: several changes make one proposal.
    patience_s
        It waits so long for the present places of vehicles that are heard again.
    fresh_beats
        A place counts as old if its vehicle has sent more packets since.
    repeat_s, repeats
        Between repetitions of a proposal that members have not claimed, and how many there are.
    least_gap_s
        Between two packets of an agent.
    """

    membership: MembershipOptions = field(default_factory=MembershipOptions)
    settle_s: float = 0.05
    patience_s: float = 3.0
    fresh_beats: int = 8
    repeat_s: float = 0.5
    repeats: int = 20
    least_gap_s: float = 0.1

    def __post_init__(self) -> None:
        require_not_negative('settle_s', self.settle_s, 's')
        require_positive('repeat_s', self.repeat_s, 's')
        require_not_negative('least_gap_s', self.least_gap_s, 's')
