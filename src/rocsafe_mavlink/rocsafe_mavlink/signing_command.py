# SPDX-License-Identifier: Apache-2.0
"""The executable ``signing``: make a signing key, write it to a vehicle, show time stamps.

Without ROS. The key is never printed. ``send`` writes it in clear, as the protocol demands, hence
only by a serial port (USB) or within this machine.
"""

import argparse
import os
import secrets
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from datetime import datetime, timezone
from pathlib import Path

from rocsafe_mavlink.assembly import timestamps_of
from rocsafe_mavlink.errors import MavlinkError
from rocsafe_mavlink.knowledge.reducer import ARMED_FLAG
from rocsafe_mavlink.link.endpoint import Endpoint, parse_endpoint
from rocsafe_mavlink.link.link import Address
from rocsafe_mavlink.link.transport import Transport, address_of, open_transport
from rocsafe_mavlink.wire.dialect import Message, addressed, decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan
from rocsafe_mavlink.wire.signing import (
    EPOCH_S,
    KEY_SIZE,
    TICKS_PER_S,
    SigningKey,
    read_key,
    ticks_at,
)

EXIT_GOOD, EXIT_FAILED, EXIT_USAGE = 0, 1, 2
# Our own MAVLink numbers, as of the bridge.
US = (255, 190)
LISTEN_S = 10.0
POLL_S = 0.02
# The message is not acknowledged.
TIMES_SENT = 3
BETWEEN_S = 0.2


def main(arguments: Sequence[str] | None = None) -> int:
    """Do one thing with a signing key; return 0 if it was done."""
    given = _parser().parse_args(arguments)
    try:
        given.command(given)
    except (MavlinkError, ValueError, OSError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_FAILED
    return EXIT_GOOD


def new_key(path: Path) -> None:
    """Write a random key to a new file of mode 0600.

    Raises
    ------
    FileExistsError
        If there is such a file: a key that vehicles hold is not overwritten.
    """
    descriptor = os.open(path, os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o600)
    with os.fdopen(descriptor, 'w', encoding='ascii') as file:
        file.write(secrets.token_hex(KEY_SIZE) + '\n')


def described(key_file: Path, now_s: float) -> list[str]:
    """Return a line for each time stamp beside a key: its stream, its time, how far it is ahead.

    Raises
    ------
    MavlinkError, ValueError
        If the key or its time stamps cannot be read.
    """
    read_key(key_file)
    limits = timestamps_of(key_file).limits
    lines = []
    for name, ticks in sorted(limits.items()):
        time_s = EPOCH_S + ticks / TICKS_PER_S
        moment = datetime.fromtimestamp(time_s, timezone.utc).isoformat(timespec='seconds')
        who = 'sent by us' if name == 'sent' else f'link/system/component {name}'
        ahead = f', {time_s - now_s:.0f} s ahead of our clock' if time_s > now_s + 2.0 else ''
        lines.append(f'{who}: {moment}{ahead}')
    return lines or ['no time stamp was used yet']


def reset(key_file: Path, now_s: float) -> list[str]:
    """Take back time stamps that are ahead of our clock to the present; return their names.

    Messages that were recorded with stamps between now and then could be sent again by others.

    Raises
    ------
    MavlinkError, ValueError
        If the key or its time stamps cannot be read.
    """
    read_key(key_file)
    return timestamps_of(key_file).take_back(ticks_at(now_s))


@dataclass(frozen=True, slots=True, kw_only=True)
class Courier:
    """Writes a key to one vehicle.

    Attributes
    ----------
    transport, endpoint
        Way to the vehicle.
    target
        (system, component) of its autopilot.
    """

    transport: Transport
    endpoint: Endpoint
    target: tuple[int, int]

    def send(self, key: SigningKey) -> None:
        """Wait for the vehicle, and send it `key` and the time.

        Raises
        ------
        ValueError
            If it is not heard, or its motors run: an ArduPilot then ignores the key.
        """
        address, heartbeat = self._greeted()
        if heartbeat['base_mode'] & ARMED_FLAG:
            raise ValueError('the motors run: a vehicle takes a key only while they stand still')
        for _ in range(TIMES_SENT):
            self._post(
                address,
                addressed(
                    'SETUP_SIGNING',
                    self.target,
                    secret_key=list(key.secret),
                    initial_timestamp=ticks_at(time.time()),
                ),
            )
            time.sleep(BETWEEN_S)

    def _greeted(self) -> tuple[Address, Message]:
        """Return address and heartbeat of the vehicle."""
        end_s = time.monotonic() + LISTEN_S
        beat = Message('HEARTBEAT', {'type': 6, 'autopilot': 8, 'mavlink_version': 3})
        while (now_s := time.monotonic()) < end_s:
            if not self.endpoint.is_listening:
                self._post(address_of(self.endpoint), beat)
            for address, data in self.transport.take(now_s):
                for frame in scan(data, is_whole=False).frames:
                    message = decode(
                        frame.message_id, frame.payload, frame.system, frame.component
                    )
                    sender = (message.system, message.component)
                    if message.name == 'HEARTBEAT' and sender == self.target:
                        return address, message
            time.sleep(POLL_S)
        raise ValueError(f'system {self.target[0]} was not heard within {LISTEN_S:g} s')

    def _post(self, address: Address, message: Message) -> None:
        self.transport.send(address, pack_frame(*encode(message), *US, 0, sign=False))


def _new(given: argparse.Namespace) -> None:
    new_key(given.key)
    sys.stdout.write(f'{given.key}: a new key. Write it to the vehicle with: signing send\n')


def _show(given: argparse.Namespace) -> None:
    sys.stdout.write('\n'.join(described(given.key, time.time())) + '\n')


def _reset(given: argparse.Namespace) -> None:
    names = reset(given.key, time.time())
    sys.stdout.write(f'{len(names)} time stamps taken back to now: {", ".join(names) or "none"}\n')


def _send(given: argparse.Namespace) -> None:
    key, endpoint = read_key(given.key), parse_endpoint(given.link)
    if not endpoint.is_local:
        raise ValueError(f'link {given.link!r}: the key is sent in clear, use a serial port (USB)')
    transport = open_transport(endpoint)
    try:
        Courier(transport=transport, endpoint=endpoint, target=(given.system, given.component)
                ).send(key)  # fmt: skip
    finally:
        transport.close()
    sys.stdout.write(
        'the key was sent. A vehicle does not confirm it: look with `rocsafe preflight` '
        'whether it is heard with the key\n'
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='signing', description='Signing keys of MAVLink. Stop the bridge before.'
    )
    commands = parser.add_subparsers(required=True, metavar='COMMAND')
    texts = {
        'new': (_new, 'make a key in a new file of mode 0600'),
        'show': (_show, 'tell the time stamps that are kept beside a key'),
        'reset': (_reset, 'take back time stamps that are ahead of the clock of this machine'),
        'send': (_send, 'write a key to a vehicle by USB or within this machine'),
    }
    for name, (command, text) in texts.items():
        one = commands.add_parser(name, help=text, description=text)
        one.add_argument('key', type=Path, metavar='KEY_FILE', help='file of the signing key')
        one.set_defaults(command=command)
        if name == 'send':
            one.add_argument(
                'link', metavar='LINK', help='the vehicle, e.g. serial:///dev/ttyACM0'
            )
            one.add_argument('--system', type=int, default=1, help='MAVLink system (default: 1)')
            one.add_argument(
                '--component', type=int, default=1, help='MAVLink component (default: 1)'
            )
    return parser


if __name__ == '__main__':
    raise SystemExit(main())
