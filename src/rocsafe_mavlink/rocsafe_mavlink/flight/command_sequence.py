# SPDX-License-Identifier: Apache-2.0
"""The commands of one request, step by step: ``(state, message or tick) -> (state, messages)``.

Every command that changes what a vehicle does, and every upload of a mission, a fence or rally
points, is begun and repeated by `CommandSequence.on_tick`, which is given what is known of the
vehicle at that moment. So a sequence is withdrawn as soon as the pilot, another station or a
failsafe takes the vehicle over: no further step begins, and no command is repeated. Before each
command a heartbeat must have come since the last one was sent; only the first command of a
sequence that makes a flight safer is sent at once. A step may name further conditions under which
it must not begin or be repeated.

A step is a command that must be accepted and then show in the telemetry, or a list of items that
must be read back as it was sent. The first step that fails, and its alternative if it has one,
ends the sequence with the autopilot's own words. Nothing is undone: the autopilot goes on by
itself.
"""

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace

from rocsafe_mavlink.autopilots.autopilot import Autopilot
from rocsafe_mavlink.flight.command_step import CommandStep, Step, TransferStep
from rocsafe_mavlink.flight.custody import is_commanded
from rocsafe_mavlink.flight.flight_outcome import failsafe_of
from rocsafe_mavlink.knowledge.telemetry import MODE_SHOWS_S, Contact, VehicleTelemetry
from rocsafe_mavlink.protocols.mission_item import MissionItem
from rocsafe_mavlink.wire.dialect import Message

Answer = tuple['CommandSequence', list[Message]]


@dataclass(frozen=True, slots=True, kw_only=True)
class CommandSequence:
    """Steps of one request, done one after the other.

    Attributes
    ----------
    name
        Name of the request, for people.
    target
        (system, component) of the vehicle.
    autopilot
        Its kind.
    steps
        Steps that are not done yet; the first is under way, or is the one that failed.
    is_begun
        Whether the first of `steps` was sent.
    error
        Why the sequence failed; empty if it has not.
    verified_mission
        Mission that was uploaded by this sequence and read back as it was sent; None: none yet.
    is_always_taken
        Whether the sequence makes a flight safer (hold, return home, land): it begins at once,
        and a critical status alone, in a mode that obeys, does not withdraw it.
    is_withdrawn
        Whether it ended because somebody else took the vehicle over, or it was not heard.
    mode
        Custom mode in which the last step left the vehicle, or the first step found it.
    led_to
        Custom mode to which a step of the sequence led; -1: none did.
    was_armed
        Whether its motors ran then.
    late_modes
        Custom modes to which a command before this sequence may lead yet, during the first step.
    late_until_s
        Steady time until which they may show.
    look_after_s
        The next command waits for a heartbeat after this steady time.
    obstructed_s
        Steady time since when an obstacle keeps the step from beginning; infinite: none does.
    """

    name: str
    target: tuple[int, int]
    autopilot: Autopilot
    steps: tuple[Step, ...]
    is_begun: bool = False
    error: str = ''
    verified_mission: tuple[MissionItem, ...] | None = None
    is_always_taken: bool = False
    is_withdrawn: bool = False
    mode: int = -1
    led_to: int = -1
    was_armed: bool = False
    late_modes: frozenset[int] = frozenset()
    late_until_s: float = -math.inf
    look_after_s: float = -math.inf
    obstructed_s: float = math.inf

    @property
    def is_over(self) -> bool:
        """Whether all steps are done or one has failed."""
        return not self.steps or bool(self.error)

    def on_message(self, message: Message, now_s: float) -> Answer:
        """Take a message; those of other vehicles change nothing."""
        is_ours = (message.system, message.component) == self.target
        if not is_ours or self.is_over:
            return self, []
        is_text = message.name == 'STATUSTEXT'
        if is_text and failsafe_of(str(message['text'])):
            return self.withdrawn(str(message['text'])), []
        if not self.is_begun:
            return self, []
        step, sent = self.steps[0].on_message(message, now_s)
        if step is self.steps[0]:
            return self, sent
        return replace(self, steps=(step, *self.steps[1:])), sent

    def on_tick(self, vehicle: VehicleTelemetry, now_s: float) -> Answer:
        """Go on as far as `vehicle`, as it is known now, allows."""
        going, sent = self.looked_at(vehicle, now_s), list[Message]()
        while going._may_go_on(vehicle, now_s):
            step, more, is_new = going.steps[0], list[Message](), not going.is_begun
            is_sending = is_new or step.sends_command(now_s)
            refusal = step.refusal(vehicle, now_s) if is_sending else ''
            if refusal and not step.is_done(vehicle):
                going = going._failed(step, refusal)
                continue
            obstacle = step.obstacle(vehicle, now_s) if is_sending else ''
            going = going._obstructed(obstacle, step.patience_s, now_s)
            if obstacle:
                return going, sent
            step, more = step.begin(now_s) if is_new else step.on_tick(vehicle, now_s)
            sent += more
            look_after_s = now_s if is_sending else going.look_after_s
            steps = (step, *going.steps[1:])
            going = replace(going, steps=steps, is_begun=True, look_after_s=look_after_s)
            advanced = going._advanced(vehicle, now_s)
            if is_new or (len(advanced.steps) == len(going.steps) and advanced.is_begun):
                return (going if is_new else advanced), sent
            going = advanced
        return going, sent

    def _obstructed(self, obstacle: str, patience_s: float, now_s: float) -> 'CommandSequence':
        since_s = min(self.obstructed_s, now_s) if obstacle else math.inf
        is_lasting = now_s - since_s > patience_s
        return replace(self, obstructed_s=since_s, error=obstacle if is_lasting else '')

    @property
    def expected_modes(self) -> frozenset[int]:
        """Custom modes to which the step under way may lead, or a command before it."""
        return frozenset() if self.is_over else self.steps[0].modes | self.late_modes

    @property
    def coming_modes(self) -> frozenset[int]:
        """Custom modes to which a command that was sent may lead yet."""
        return self.expected_modes if self.is_begun else self.late_modes

    def after(self, others: Iterable['CommandSequence'], now_s: float) -> 'CommandSequence':
        """Return the sequence that takes the place of others: their modes may show late."""
        modes = frozenset[int]().union(*(other.coming_modes for other in others))
        return replace(self, late_modes=modes, late_until_s=now_s + MODE_SHOWS_S)

    def withdrawn(self, reason: str) -> 'CommandSequence':
        """Return the sequence ended without another command, unless it is over."""
        if self.is_over:
            return self
        return replace(self, error=f'withdrawn: {reason}', is_withdrawn=True)

    def _may_go_on(self, vehicle: VehicleTelemetry, now_s: float) -> bool:
        """Whether the vehicle was heard recently enough for what is to be done next."""
        if self.is_over or vehicle.contact(now_s) is not Contact.FRESH:
            return False
        step = self.steps[0]
        is_command = not self.is_begun and isinstance(step, CommandStep)
        if is_command or step.sends_command(now_s):
            return vehicle.heartbeat_s > self.look_after_s
        return True

    def looked_at(self, vehicle: VehicleTelemetry, now_s: float) -> 'CommandSequence':
        """Return the sequence after a check of the vehicle, withdrawn after a takeover.

        Called when the sequence is given, at each heartbeat and at each tick: not even a request
        of the autopilot is answered between a heartbeat that shows a takeover and the next tick.
        """
        if self.is_over:
            return self
        looked = self
        if self.mode < 0:
            after_s = self.look_after_s if self.is_always_taken else now_s
            mode, is_armed = vehicle.custom_mode, vehicle.is_armed
            looked = replace(self, mode=mode, was_armed=is_armed, look_after_s=after_s)
        reason = looked._taken_over(vehicle, now_s)
        if reason:
            return looked.withdrawn(reason)
        # A mode of ours that shows is the present one: who leaves it again takes the vehicle over.
        own = looked.steps[0].modes if looked.is_begun else frozenset[int]()
        is_own = vehicle.custom_mode in looked.late_modes | own
        return replace(looked, mode=vehicle.custom_mode) if is_own else looked

    def _taken_over(self, vehicle: VehicleTelemetry, now_s: float) -> str:
        """Return why the vehicle is not ours any more; empty if it is."""
        if vehicle.contact(now_s) is Contact.LOST:
            return 'the vehicle is not heard'
        step = self.steps[0]
        is_switching = self.is_begun and step.switches_motors
        if self.was_armed and not vehicle.is_armed and not is_switching:
            return 'the motors were stopped'
        # On the ground modes change by themselves: a PX4 leaves a mode that it cannot fly in.
        if not vehicle.is_armed:
            return ''
        if not self.was_armed and not is_switching:
            return 'somebody else started the motors'
        mode = self.autopilot.mode_name(vehicle.custom_mode)
        own = step.modes if self.is_begun else frozenset[int]()
        late = self.late_modes if now_s < self.late_until_s else frozenset[int]()
        if vehicle.custom_mode not in {self.mode, *own, *late}:
            return f'the vehicle was switched to {mode}'
        # In any other mode it returns or lands, by an earlier order or by itself.
        is_obeying = vehicle.custom_mode in own or is_commanded(vehicle, self.autopilot)
        if vehicle.is_in_failsafe and not (self.is_always_taken and is_obeying):
            return f'a failsafe has the vehicle, in {mode}'
        return ''

    def _failed(self, step: Step, error: str) -> 'CommandSequence':
        """Return the sequence with the alternative of its first step, or ended if it has none."""
        if step.otherwise is None:
            return replace(self, error=error)
        return replace(self, steps=(step.otherwise, *self.steps[1:]), is_begun=False)

    def _advanced(self, vehicle: VehicleTelemetry, now_s: float) -> 'CommandSequence':
        """Return the sequence after a look at its first step: failed, done, or still under way."""
        step, rest = self.steps[0], self.steps[1:]
        error = step.error(vehicle, now_s)
        if error:
            return self._failed(step, error)
        if not step.is_done(vehicle):
            return self
        is_transfer = isinstance(step, TransferStep)
        return replace(
            self,
            steps=rest,
            is_begun=False,
            verified_mission=step.verified_mission or self.verified_mission,
            mode=vehicle.custom_mode,
            led_to=vehicle.custom_mode if vehicle.custom_mode in step.modes else self.led_to,
            was_armed=vehicle.is_armed,
            late_modes=frozenset(),
            # A transfer takes long: what the vehicle did meanwhile may not show yet.
            look_after_s=now_s if is_transfer else self.look_after_s,
        )
