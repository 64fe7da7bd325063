# SPDX-License-Identifier: Apache-2.0
"""An operator's order, step by step: ``(state, message or tick) -> (state, messages to send)``.

A step is a command that must be accepted and then show in what the vehicle says of itself, or a
list of items that must be read back as it was sent. The first step that fails, and what is to be
done otherwise, ends the errand, with the autopilot's own words; nothing is undone, since the
autopilot goes on by itself.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace

from rocsafe_mavlink.knowledge.vehicle import Vehicle
from rocsafe_mavlink.protocols.command_call import CallStage, CommandCall
from rocsafe_mavlink.protocols.mission_transfer import Transfer, TransferStage
from rocsafe_mavlink.wire.dialect import Message

# A mode that was accepted shows in a heartbeat within this time, two of them lost.
SHOWS_WITHIN_S = 3.5
Shown = Callable[[Vehicle], bool]


def at_once(_vehicle: Vehicle) -> bool:
    """Return that an accepted command needs no further sign."""
    return True


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandStep:
    """A command, and whether the vehicle shows that it obeys.

    Attributes
    ----------
    call: the command.
    is_shown: whether the vehicle does what it was told.
    accepted_s: steady time of its answer; negative before.
    otherwise: what is done in its place if it fails; None: nothing.
    """

    call: CommandCall
    is_shown: Shown = at_once
    accepted_s: float = -1.0
    otherwise: 'CommandStep | None' = None

    def begin(self, now_s: float) -> tuple['CommandStep', list[Message]]:
        """Send it."""
        call, sent = self.call.begin(now_s)
        return replace(self, call=call), sent

    def on_message(self, message: Message, now_s: float) -> tuple['CommandStep', list[Message]]:
        """Take a message of the vehicle."""
        return replace(self, call=self.call.on_message(message, now_s)), []

    def on_tick(self, now_s: float) -> tuple['CommandStep', list[Message]]:
        """Let time pass."""
        call, sent = self.call.on_tick(now_s)
        is_news = call.stage is CallStage.ACCEPTED and self.accepted_s < 0.0
        return replace(self, call=call, accepted_s=now_s if is_news else self.accepted_s), sent

    def error(self, vehicle: Vehicle, now_s: float) -> str:
        """Return why it failed; empty if it has not."""
        if self.call.is_over and self.call.stage is not CallStage.ACCEPTED:
            is_only_unanswered = self.call.stage is CallStage.UNANSWERED
            return '' if is_only_unanswered and self._shows(vehicle) else self.call.error
        is_late = self.accepted_s >= 0.0 and now_s - self.accepted_s > SHOWS_WITHIN_S
        return 'accepted, but the vehicle does not show it' if is_late else ''

    def is_done(self, vehicle: Vehicle) -> bool:
        """Whether it was accepted and shows, or shows although its answer was lost."""
        return self.call.is_over and self._shows(vehicle)

    def _shows(self, vehicle: Vehicle) -> bool:
        is_accepted = self.call.stage is CallStage.ACCEPTED
        return (is_accepted or self.is_shown is not at_once) and self.is_shown(vehicle)


@dataclass(frozen=True, slots=True, kw_only=True)
class TransferStep:
    """A list of items that is sent and read back."""

    moving: Transfer

    @property
    def otherwise(self) -> None:
        """Nothing is done in its place."""

    def begin(self, now_s: float) -> tuple['TransferStep', list[Message]]:
        """Offer it."""
        return self._moved(self.moving.begin(now_s))

    def on_message(self, message: Message, now_s: float) -> tuple['TransferStep', list[Message]]:
        """Take a message of the vehicle."""
        return self._moved(self.moving.on_message(message, now_s))

    def on_tick(self, now_s: float) -> tuple['TransferStep', list[Message]]:
        """Let time pass."""
        return self._moved(self.moving.on_tick(now_s))

    def error(self, _vehicle: Vehicle, _now_s: float) -> str:
        """Return why it failed; empty if it has not."""
        is_failed = self.moving.stage is TransferStage.FAILED
        return f'not taken: {self.moving.error}' if is_failed else ''

    def is_done(self, _vehicle: Vehicle) -> bool:
        """Whether it lies on the vehicle as it was sent."""
        return self.moving.stage is TransferStage.VERIFIED

    def _moved(
        self, answer: tuple[Transfer, list[Message]]
    ) -> tuple['TransferStep', list[Message]]:
        return replace(self, moving=answer[0]), answer[1]


Step = CommandStep | TransferStep
Answer = tuple['Errand', list[Message]]


@dataclass(frozen=True, slots=True, kw_only=True)
class Errand:
    """Steps of one order, done one after the other.

    Attributes
    ----------
    name: of the order, for people.
    target: (system, component) of the vehicle.
    steps: those not yet done; the first is under way.
    is_begun: whether the first was sent.
    error: why it failed; empty if it has not.
    """

    name: str
    target: tuple[int, int]
    steps: tuple[Step, ...]
    is_begun: bool = False
    error: str = ''

    @property
    def is_over(self) -> bool:
        """Whether it is done or has failed."""
        return not self.steps or bool(self.error)

    def on_message(self, message: Message, now_s: float) -> Answer:
        """Take a message; those of other vehicles change nothing."""
        is_ours = (message.system, message.component) == self.target
        if not is_ours or self.is_over or not self.is_begun:
            return self, []
        step, sent = self.steps[0].on_message(message, now_s)
        return replace(self, steps=(step, *self.steps[1:])), sent

    def on_tick(self, vehicle: Vehicle, now_s: float) -> Answer:
        """Go on as far as `vehicle`, as it is known now, allows."""
        if self.is_over:
            return self, []
        if not self.is_begun:
            return self._stepped(self.steps[0].begin(now_s))
        going, sent = self._stepped(self.steps[0].on_tick(now_s))
        error = going.steps[0].error(vehicle, now_s)
        if error and going.steps[0].otherwise is not None:
            steps = (going.steps[0].otherwise, *going.steps[1:])
            return replace(going, steps=steps, is_begun=False), sent
        if error:
            return replace(going, error=f'{self.name}: {error}'), sent
        if going.steps[0].is_done(vehicle):
            return replace(going, steps=going.steps[1:], is_begun=False), sent
        return going, sent

    def _stepped(self, answer: tuple[Step, list[Message]]) -> Answer:
        return replace(self, steps=(answer[0], *self.steps[1:]), is_begun=True), answer[1]
