# SPDX-License-Identifier: Apache-2.0
"""How the hosts of a mission meet: identity, clocks and plan over one TCP connection each.

Lines of JSON. The joining host names itself, asks for the head's clock some times, and says that
it has joined. The head then sends the plan as soon as there is one, a sign of life every second,
and the end. Everything else goes by ROS. Only addresses that the scenario names are answered.
"""

import hashlib
import json
import select
import socket
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.run_directory import RunDirectory

JOIN_PORT = 47611
# A connection without a sign of life for so long is lost, seconds.
LOST_S = 10.0
ALIVE_S = 1.0
# Clocks of two hosts may differ by so much: times of readings and photographs are compared.
CLOCK_LIMIT_S = 0.5
CLOCK_LOOKS = 8
CONNECT_S = 2.0
LONGEST_LINE = 64 * 2**20
_POLL_S = 0.2


class LinkLostError(Exception):
    """The other side is not heard any more."""


class Lines:
    """JSON messages over a connection, one a line. Every wait has a limit."""

    def __init__(self, connection: socket.socket) -> None:
        self._socket = connection
        self._socket.settimeout(LOST_S)
        self._received = b''
        self.heard_s = time.monotonic()

    def send(self, **message: object) -> None:
        """Send a message; raises `LinkLostError`."""
        try:
            self._socket.sendall(json.dumps(message).encode() + b'\n')
        except OSError as error:
            raise LinkLostError(str(error)) from error

    def receive(self, limit_s: float) -> dict[str, Any]:
        """Return the next message, an empty one if there is none in time.

        Raises
        ------
        LinkLostError
            If the connection ends, is silent for too long, or the other side does not speak JSON.
        """
        end_s = time.monotonic() + limit_s
        while b'\n' not in self._received:
            left_s = end_s - time.monotonic()
            if left_s <= 0.0 or not select.select([self._socket], [], [], left_s)[0]:
                if time.monotonic() - self.heard_s > LOST_S:
                    raise LinkLostError(f'silent for {LOST_S:g} s')
                return {}
            self._read()
        line, _, self._received = self._received.partition(b'\n')
        try:
            message = json.loads(line)
        except ValueError as error:
            raise LinkLostError('speaks no JSON') from error
        if not isinstance(message, dict):
            raise LinkLostError('speaks no JSON objects')
        return message

    def _read(self) -> None:
        try:
            data = self._socket.recv(2**16)
        except OSError as error:
            raise LinkLostError(str(error)) from error
        if not data or len(self._received) > LONGEST_LINE:
            raise LinkLostError('has ended the connection')
        self._received += data
        self.heard_s = time.monotonic()

    def close(self) -> None:
        """End the connection."""
        self._socket.close()


@dataclass(frozen=True, slots=True, kw_only=True)
class Welcome:
    """What the head tells a host that joins.

    Attributes
    ----------
    mission, token
        Identity of the mission.
    scenario
        As flown, YAML.
    """

    mission: str
    token: str
    scenario: str


@dataclass(frozen=True, slots=True, kw_only=True)
class HostNews:
    """What a host tells the head: a remark, or a process that it has started again."""

    host: str
    text: str
    restarted: str = ''


class HostServer:
    """Welcomes the other hosts of a mission, in threads.

    Parameters
    ----------
    address
        Of this host.
    hosts
        Address of each host that may join, by name.
    welcome
        What they are told.
    plan
        File of the plan; it is sent when it is there.

    Attributes
    ----------
    news
        What the hosts have told.

    Raises
    ------
    SetupError
        If the port cannot be opened.
    """

    def __init__(
        self,
        address: tuple[str, int],
        hosts: Mapping[str, str],
        welcome: Welcome,
        plan: Path,
    ) -> None:
        self.news: deque[HostNews] = deque()
        self._hosts, self._welcome, self._plan = hosts, welcome, plan
        self._is_over = threading.Event()
        try:
            self._socket = socket.create_server(address)
        except OSError as error:
            text = f'{address[0]}:{address[1]}: cannot be opened for other hosts'
            raise SetupError(f'{text}: {error.strerror}') from error
        self._socket.settimeout(_POLL_S)
        self.port: int = self._socket.getsockname()[1]
        self._threads = [threading.Thread(target=self._accept, name='hosts', daemon=True)]
        self._threads[0].start()

    def close(self) -> None:
        """Tell all hosts that the mission is over, and end."""
        self._is_over.set()
        end_s = time.monotonic() + LOST_S
        for thread in self._threads:
            thread.join(max(0.0, end_s - time.monotonic()))
        self._socket.close()

    def _accept(self) -> None:
        while not self._is_over.is_set():
            with suppress(TimeoutError):
                connection, (address, *_) = self._socket.accept()
                serve = threading.Thread(
                    target=self._serve, args=(connection, address), daemon=True
                )
                serve.start()
                self._threads = [t for t in self._threads if t.is_alive()] + [serve]

    def _serve(self, connection: socket.socket, address: str) -> None:
        lines, name = Lines(connection), ''
        try:
            name = str(lines.receive(LOST_S).get('host', ''))
            if self._hosts.get(name) != address:
                lines.send(refused=f'{name!r} at {address} is no host of this mission')
                return
            lines.send(**{key: getattr(self._welcome, key) for key in Welcome.__slots__})
            self._attend(lines, name)
        except LinkLostError as error:
            if name in self._hosts:
                self._tell(name, f'host {name} is not heard any more: it {error}')
        finally:
            lines.close()

    def _attend(self, lines: Lines, name: str) -> None:
        """Serve a host until the mission is over."""
        alive_s, has_plan = 0.0, False
        while not self._is_over.is_set():
            message = lines.receive(_POLL_S)
            if 'clock' in message:
                lines.send(clock=time.time())
            if 'text' in message:
                self._tell(name, str(message['text']), str(message.get('restarted', '')))
            if not has_plan and self._plan.is_file():
                has_plan = True
                lines.send(plan=self._plan.read_text(encoding='utf-8'))
            if time.monotonic() >= alive_s:
                alive_s = time.monotonic() + ALIVE_S
                lines.send(alive=True)
        lines.send(end=True)

    def _tell(self, host: str, text: str, restarted: str = '') -> None:
        self.news.append(HostNews(host=host, text=text, restarted=restarted))


def join(name: str, address: tuple[str, int], own: str) -> tuple[Lines, Welcome]:
    """Join the mission of a head once and return the connection.

    Parameters
    ----------
    name
        Of this host in the scenario.
    address
        Of the head.
    own
        Address of this host.

    Raises
    ------
    LinkLostError
        If the head cannot be reached.
    SetupError
        If it refuses this host, or the clocks differ too much.
    """
    try:
        connection = socket.create_connection(address, CONNECT_S, (own, 0))
    except OSError as error:
        raise LinkLostError(str(error)) from error
    lines = Lines(connection)
    try:
        lines.send(host=name, alive=True)
        told = _welcomed(lines, address[0])
        offset_s = _clock_offset_s(lines)
        _require_clock(name, address[0], offset_s)
        lines.send(text=f'host {name} has joined, its clock differs by {1e3 * offset_s:.0f} ms')
        return lines, Welcome(**{key: str(told[key]) for key in Welcome.__slots__})
    except (LinkLostError, SetupError, KeyError) as error:
        lines.close()
        if isinstance(error, KeyError):
            raise LinkLostError(f'tells no {error}') from error
        raise


def write_photographs_token(run: RunDirectory, token: str) -> None:
    """Write the token by which hosts of a mission hand over photographs, for its owner only."""
    path = run.photographs_token
    path.unlink(missing_ok=True)
    path.touch(mode=0o600)
    path.write_text(hashlib.sha256(f'photographs/{token}'.encode()).hexdigest())


def _welcomed(lines: Lines, head: str) -> dict[str, Any]:
    """Return what the head tells; raises `SetupError` if it refuses this host."""
    told = _next(lines, 'mission', 'refused')
    if 'refused' in told:
        raise SetupError(f'{head}: {told["refused"]}')
    return told


def _next(lines: Lines, *keys: str) -> dict[str, Any]:
    """Return the next message with one of the keys."""
    end_s = time.monotonic() + LOST_S
    while time.monotonic() < end_s:
        message = lines.receive(_POLL_S)
        if any(key in message for key in keys):
            return message
    raise LinkLostError(f'does not tell {" or ".join(keys)}')


def _clock_offset_s(lines: Lines, wall: Callable[[], float] = time.time) -> float:
    """Return own minus other time, seconds, of the quickest of some answers (RFC 5905)."""
    looks = []
    for _ in range(CLOCK_LOOKS):
        before = wall()
        lines.send(clock=True)
        theirs = float(_next(lines, 'clock')['clock'])
        after = wall()
        looks.append((after - before, 0.5 * (before + after) - theirs))
    return min(looks)[1]


def _require_clock(name: str, head: str, offset_s: float) -> None:
    if abs(offset_s) > CLOCK_LIMIT_S:
        how = 'ahead of' if offset_s > 0.0 else 'behind'
        raise SetupError(
            f'the clock of {name} is {abs(offset_s):.1f} s {how} that of {head}, at most '
            f'{CLOCK_LIMIT_S:g} s are allowed: set both by one time server'
        )
