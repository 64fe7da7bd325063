# SPDX-License-Identifier: Apache-2.0
"""What real autopilots in their own simulators share: a tap on the link and a second station.

Each speaks to a bridge on one UDP port through a tap that notes what it is told; faults are made
by parameters that are set from the second station.
"""

import contextlib
import select
import socket
import threading
import time

from rocsafe_mavlink.wire.dialect import Message, decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan

SECOND_STATION = (254, 190)
ARMED = 0x80
# As `told` of the fake.
ORDERS = ('COMMAND_LONG', 'COMMAND_INT', 'MISSION_COUNT', 'MISSION_CLEAR_ALL')


class Tap:
    """Carries what a copter and a bridge say to each other, and notes what it was told.

    Parameters
    ----------
    bridge_port : where the bridge listens.
    port : to which the copter speaks; 0: any that is free.

    Attributes
    ----------
    port : to which the copter speaks.
    told : orders to it, as 'message command'.
    is_armed : by its last heartbeat.
    """

    def __init__(self, bridge_port, port=0):
        self.told = []
        self.is_armed = False
        self._copter, self._bridge = (
            socket.socket(socket.AF_INET, socket.SOCK_DGRAM) for _ in range(2)
        )
        self._copter.bind(('127.0.0.1', port))
        self.port = self._copter.getsockname()[1]
        self._bridge.connect(('127.0.0.1', bridge_port))
        # A refusal makes a socket look ready, and is gone with the next thing that is sent.
        self._bridge.setblocking(False)
        self._peer = None
        self._is_busy = False
        self._is_over = threading.Event()
        self._thread = threading.Thread(target=self._carry, daemon=True)
        self._thread.start()

    def hear_all(self):
        """Wait until all that the bridge has sent is noted, and sent on."""
        end = time.monotonic() + 10.0
        while select.select([self._bridge], [], [], 0.0)[0] or self._is_busy:
            assert time.monotonic() < end, 'it carries nothing'
            time.sleep(0.01)

    def close(self):
        """Carry no more."""
        self._is_over.set()
        self._thread.join(timeout=5.0)
        self._copter.close()
        self._bridge.close()

    def _carry(self):
        while not self._is_over.is_set():
            ready, _, _ = select.select([self._copter, self._bridge], [], [], 0.1)
            self._is_busy = True
            for side in ready:
                # Nobody may listen at the moment, as on a radio.
                with contextlib.suppress(OSError):
                    self._pass_on(side)
            self._is_busy = False

    def _pass_on(self, side):
        data, address = side.recvfrom(4096)
        for frame in scan(data, is_whole=True).frames:
            said = decode(frame.message_id, frame.payload, frame.system, frame.component)
            self._note(said, is_order=side is self._bridge)
        if side is self._copter:
            self._peer = address
            self._bridge.send(data)
        elif self._peer is not None:
            self._copter.sendto(data, self._peer)

    def _note(self, message, *, is_order):
        if is_order and message.name in ORDERS:
            self.told.append(f'{message.name} {message.fields.get("command", 0)}')
        elif message.name == 'HEARTBEAT' and not is_order:
            self.is_armed = bool(message['base_mode'] & ARMED)


class Copter:
    """One real autopilot; `start` is its kind's.

    Parameters
    ----------
    system : its system.
    tap : on its link with the bridge.
    control : where its second link is, if that is known before it speaks.
    """

    def __init__(self, system, tap, control=None):
        self.system = system
        self.tap = tap
        self.process = None
        self._control = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self._control.bind(('127.0.0.1', 0))
        self._control.settimeout(0.2)
        self._peer = control

    def set(self, name, value):
        """Set a parameter, and wait until the copter says so."""
        number, kind = self.encoded(name, value)
        wanted = Message(
            'PARAM_SET',
            {
                'target_system': self.system,
                'target_component': 1,
                'param_id': name,
                'param_value': number,
                'param_type': kind,
            },
        )

        def is_taken(said):
            is_it = said.name == 'PARAM_VALUE' and said['param_id'] == name
            return is_it and abs(said['param_value'] - number) <= 1e-3 * abs(number)

        self._ask(wanted, is_taken)

    def command(self, number, *parameters):
        """Order something from the second station, and wait until it is accepted."""
        fields = {'target_system': self.system, 'target_component': 1, 'command': number}
        fields |= {f'param{n}': value for n, value in enumerate(parameters, 1)}

        def is_accepted(said):
            is_it = said.name == 'COMMAND_ACK' and said['command'] == number
            return is_it and said['result'] == 0

        self._ask(Message('COMMAND_LONG', fields), is_accepted)

    def item_count(self, kind):
        """Return how many items of a kind lie on it."""
        fields = {'target_system': self.system, 'target_component': 1, 'mission_type': kind}

        def is_answer(said):
            return said.name == 'MISSION_COUNT' and said.fields.get('mission_type', 0) == kind

        return self._ask(Message('MISSION_REQUEST_LIST', fields), is_answer)['count']

    def stop(self):
        """End the process, as a crash would."""
        if self.process is not None:
            self.process.kill()
            self.process.wait()

    def close(self):
        """End the process and the station."""
        self.stop()
        self._control.close()
        self.tap.close()

    def _ask(self, question, is_answer, deadline_s=30.0):
        """Ask from the second station until it answers; return the answer."""
        data = pack_frame(*encode(question), *SECOND_STATION, 0, sign=False)
        end = time.monotonic() + deadline_s
        while time.monotonic() < end:
            if self._peer is not None:
                self._control.sendto(data, self._peer)
            for said in self._hear():
                if is_answer(said):
                    return said
        raise AssertionError(f'{question} was not answered')

    def _hear(self):
        """Return what comes within a fifth of a second, and a little more."""
        for _ in range(50):
            try:
                data, self._peer = self._control.recvfrom(4096)
            except TimeoutError:
                return
            for frame in scan(data, is_whole=True).frames:
                yield decode(frame.message_id, frame.payload, frame.system, frame.component)


class RealAirspace:
    """Real autopilots on one link; what it offers is what `Airspace` does.

    Attributes
    ----------
    link : where the bridge has to listen.
    copters : by their system.
    """

    is_real = True

    def __init__(self, link, copters):
        self.link = link
        self.copters = copters

    def step(self):
        """Do nothing: they fly by themselves."""

    def hear_all(self):
        """Let all arrive that was sent."""
        for copter in self.copters.values():
            copter.tap.hear_all()

    def calm(self, _rate=None):
        """Return a context that changes nothing: their time runs as it was begun."""
        return contextlib.nullcontext()

    def told(self):
        """Return the orders that came, as 'message command'."""
        return [order for copter in self.copters.values() for order in copter.tap.told]

    def item_count(self, kind, system=1):
        """Return how many items of a kind lie on a copter."""
        return self.copters[system].item_count(kind)

    def is_armed(self, system=1):
        """Whether its motors run."""
        return self.copters[system].tap.is_armed

    def restart(self, system=1):
        """Switch the autopilot off and on."""
        self.copters[system].start()

    def fall_silent(self, system=1):
        """End the autopilot."""
        self.copters[system].stop()

    def close(self):
        """End all."""
        for copter in self.copters.values():
            copter.close()
