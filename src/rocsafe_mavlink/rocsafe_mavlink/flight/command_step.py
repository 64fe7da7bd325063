# SPDX-License-Identifier: Apache-2.0
"""One step of a sequence: a command that must be accepted and show, or a list of items."""

from collections.abc import Callable
from dataclasses import dataclass, replace

from rocsafe_mavlink.knowledge.telemetry import MODE_SHOWS_S, VehicleTelemetry
from rocsafe_mavlink.protocols.command_call import CallStage, CommandCall
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.protocols.mission_results import MissionType
from rocsafe_mavlink.protocols.mission_transfer import Transfer, TransferStage
from rocsafe_mavlink.wire.authority import COMPONENT_ARM_DISARM
from rocsafe_mavlink.wire.dialect import Message

# Time that a step waits for an obstacle to end, such as a gap in the telemetry, seconds.
OBSTACLE_LASTS_S = 10.0
Shown = Callable[[VehicleTelemetry], bool]
Refusal = Callable[[VehicleTelemetry, float], str]


def _never(_vehicle: VehicleTelemetry, _now_s: float) -> str:
    return ''


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandStep:
    """A command, and how the vehicle shows that it obeys.

    Attributes
    ----------
    call
        The command.
    is_shown
        Whether the telemetry shows the effect; None: the acceptance is enough.
    is_shown_unanswered
        Whether the telemetry shows the effect although no answer came; None: as `is_shown`.
    refusal
        Returns why the command must not be sent or repeated at a steady time; empty if it may.
        An alternative is judged by its own.
    obstacle
        Returns why the command must wait; if it lasts, the step fails with these words.
    patience_s
        How long it may last.
    modes
        Custom modes to which the command may lead.
    accepted_s
        Steady time of the answer; negative before.
    otherwise
        Alternative step if this one fails; None: there is none.
    """

    call: CommandCall
    is_shown: Shown | None = None
    is_shown_unanswered: Shown | None = None
    refusal: Refusal = _never
    obstacle: Refusal = _never
    patience_s: float = OBSTACLE_LASTS_S
    modes: frozenset[int] = frozenset()
    accepted_s: float = -1.0
    otherwise: 'CommandStep | None' = None

    @property
    def verified_mission(self) -> None:
        """A command uploads no mission."""

    @property
    def switches_motors(self) -> bool:
        """Whether it is the command to start or stop the motors."""
        return self.call.command['command'] == COMPONENT_ARM_DISARM

    def sends_command(self, now_s: float) -> bool:
        """Whether the command is repeated or given up at `now_s`."""
        return self.call.is_due(now_s)

    def begin(self, now_s: float) -> tuple['CommandStep', list[Message]]:
        """Send the command."""
        call, sent = self.call.begin(now_s)
        return replace(self, call=call), sent

    def on_message(self, message: Message, now_s: float) -> tuple['CommandStep', list[Message]]:
        """Take a message of the vehicle."""
        call = self.call.on_message(message, now_s)
        return self if call is self.call else replace(self, call=call), []

    def on_tick(
        self, vehicle: VehicleTelemetry, now_s: float
    ) -> tuple['CommandStep', list[Message]]:
        """Let time pass; repeat the command if its answer is late and the mode is another."""
        if self.call.is_due(now_s) and self._shows(vehicle) and vehicle.custom_mode in self.modes:
            return replace(self, call=replace(self.call, stage=CallStage.UNANSWERED)), []
        call, sent = self.call.on_tick(now_s)
        is_new = call.stage is CallStage.ACCEPTED and self.accepted_s < 0.0
        return replace(self, call=call, accepted_s=now_s if is_new else self.accepted_s), sent

    def error(self, vehicle: VehicleTelemetry, now_s: float) -> str:
        """Return why the step failed; empty if it has not."""
        if self.is_done(vehicle):
            return ''
        if self.call.is_over and self.call.stage is not CallStage.ACCEPTED:
            return self.call.error
        is_late = self.accepted_s >= 0.0 and now_s - self.accepted_s > MODE_SHOWS_S
        number = self.call.command['command']
        return f'command {number} accepted, but heartbeats do not show it' if is_late else ''

    def is_done(self, vehicle: VehicleTelemetry) -> bool:
        """Whether the command was accepted and shows, or shows although its answer was lost."""
        if self.call.stage is CallStage.ACCEPTED:
            return self.is_shown is None or self.is_shown(vehicle)
        return self.call.stage is CallStage.UNANSWERED and self._shows(vehicle)

    def _shows(self, vehicle: VehicleTelemetry) -> bool:
        is_shown = self.is_shown_unanswered or self.is_shown
        return is_shown is not None and is_shown(vehicle)


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferStep:
    """A list of items that is sent and read back.

    Attributes
    ----------
    moving
        The transfer.
    refusal, obstacle, patience_s
        As in `CommandStep`.
    """

    moving: Transfer
    refusal: Refusal = _never
    obstacle: Refusal = _never
    patience_s: float = OBSTACLE_LASTS_S

    @property
    def verified_mission(self) -> tuple[MissionItem, ...] | None:
        """The mission that was read back as it was sent; None: not yet, or no mission."""
        is_mission = self.moving.mission_type is MissionType.MISSION
        is_verified = self.moving.stage is TransferStage.VERIFIED
        return self.moving.download.items if is_mission and is_verified else None

    @property
    def modes(self) -> frozenset[int]:
        """A transfer leads to no other mode."""
        return frozenset()

    @property
    def otherwise(self) -> None:
        """A transfer has no alternative."""

    @property
    def switches_motors(self) -> bool:
        """A transfer starts and stops no motors."""
        return False

    def sends_command(self, _now_s: float) -> bool:
        """A transfer sends no command."""
        return False

    def begin(self, now_s: float) -> tuple['TransferStep', list[Message]]:
        """Offer the items."""
        return self._moved(self.moving.begin(now_s))

    def on_message(self, message: Message, now_s: float) -> tuple['TransferStep', list[Message]]:
        """Take a message of the vehicle."""
        return self._moved(self.moving.on_message(message, now_s))

    def on_tick(
        self, _vehicle: VehicleTelemetry, now_s: float
    ) -> tuple['TransferStep', list[Message]]:
        """Let time pass."""
        return self._moved(self.moving.on_tick(now_s))

    def error(self, _vehicle: VehicleTelemetry, _now_s: float) -> str:
        """Return why the transfer failed; empty if it has not."""
        if self.moving.stage is not TransferStage.FAILED:
            return ''
        what = 'not that of its plan' if self.moving.reads_only else 'not taken'
        return f'{self.moving.mission_type.word} {what}: {self.moving.error}'

    def is_done(self, _vehicle: VehicleTelemetry) -> bool:
        """Whether the items lie on the vehicle as they were sent."""
        return self.moving.stage is TransferStage.VERIFIED

    def _moved(
        self, answer: tuple[Transfer, list[Message]]
    ) -> tuple['TransferStep', list[Message]]:
        moving, sent = answer
        return self if moving is self.moving else replace(self, moving=moving), sent


Step = CommandStep | TransferStep
