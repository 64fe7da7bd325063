# SPDX-License-Identifier: Apache-2.0
"""Packets between agents over Zenoh, on loopback."""

import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

from rocsafe_fleet.errors import LinkError
from rocsafe_fleet.link.zenoh_link import ZenohLink
from rocsafe_fleet.options import AgentOptions

DEADLINE_S = 20.0
SHARED_MEMORY = Path('/dev/shm')
pytest.importorskip('zenoh', reason='needs pip install eclipse-zenoh')
Open = Callable[..., ZenohLink]


def free_addresses(count: int) -> list[str]:
    """Return addresses on loopback that nobody uses now."""
    sockets = [socket.create_server(('127.0.0.1', 0)) for _ in range(count)]
    found = [f'127.0.0.1:{one.getsockname()[1]}' for one in sockets]
    for one in sockets:
        one.close()
    return found


@pytest.fixture
def link() -> Iterator[Open]:
    """Give a function that opens a link; all are closed with the test."""
    made: list[ZenohLink] = []

    def begin(listen: str, *peers: str, fleet: str = 'run-1') -> ZenohLink:
        made.append(ZenohLink(fleet, listen, peers))
        return made[-1]

    yield begin
    for one in made:
        one.close()


def heard(sender: ZenohLink, receiver: ZenohLink, data: bytes) -> list[bytes]:
    """Send until the receiver has something, and return that."""
    end_s = time.monotonic() + DEADLINE_S
    while not (found := receiver.receive()):
        assert time.monotonic() < end_s, 'nothing has come'
        sender.send(data)
        time.sleep(0.05)
    return found


def test_packets_reach_all_peers_and_bytes_are_counted(link: Open) -> None:
    """Whoever starts first; own packets do not come back."""
    here, there, third = free_addresses(3)
    first = link(here, there, third)
    others = [link(there, here, third), link(third, here, there)]
    for other in others:
        found = heard(first, other, b'12345')
        assert set(found) == {b'12345'}
        assert other.bytes_received == 5 * len(found)
    assert first.bytes_sent % 5 == 0
    assert first.receive() == []
    assert heard(others[1], first, b'back')[0] == b'back'


def test_another_fleet_is_not_heard(link: Open) -> None:
    """Packets of two fleets on one machine stay apart."""
    here, there, third = free_addresses(3)
    first, other = link(here), link(there, here, fleet='run-2')
    mine = link(third, here)
    assert heard(first, mine, b'mine')
    assert other.receive() == []


def test_peer_that_comes_back_is_found_again(link: Open) -> None:
    """A host that was lost joins the fleet, and nobody needs to be told."""
    here, there = free_addresses(2)
    first, second = link(here, there), ZenohLink('run-1', there, (here,))
    assert heard(first, second, b'before')
    second.close()
    first.send(b'lost')
    again = link(there, here)
    assert set(heard(first, again, b'after')) == {b'after'}


@pytest.mark.parametrize('address', ['van:47613', '127.0.0.1', '127.0.0.1:0', '127.0.0.1:x', ''])
def test_wrong_address_is_refused(address: str) -> None:
    """One line with the value."""
    with pytest.raises(LinkError, match='must be an IPv4 address and a port'):
        ZenohLink('run-1', address, ())


def test_address_of_another_machine_cannot_be_opened() -> None:
    """One line, without a trace of the library."""
    with pytest.raises(
        LinkError, match=r'^192\.0\.2\.1:47613: cannot be opened by Zenoh: [^\n]+$'
    ):
        ZenohLink('run-1', '192.0.2.1:47613', ())


@pytest.mark.parametrize(
    ('changes', 'text'),
    [
        ({'link': 'radio'}, "link = 'radio': must be dds or zenoh"),
        ({'link': 'zenoh'}, 'link_listen: must be given with link = zenoh'),
        ({'link_listen': '127.0.0.1:1'}, 'link_listen: must be given with link = zenoh, and only'),
    ],
)
def test_options_of_the_link_fit_together(changes: dict[str, str], text: str) -> None:
    """A link that would not be used is refused."""
    with pytest.raises(ValueError, match=text):
        AgentOptions(vehicles=('rav1',), plan_file='plan.json', **changes)  # type: ignore[arg-type]


def test_nothing_is_kept_in_shared_memory(link: Open) -> None:
    """Its segments would stay after the agents."""
    before = set(SHARED_MEMORY.glob('*.zenoh'))
    here, there = free_addresses(2)
    first, other = link(here, there), link(there, here)
    assert heard(first, other, b'1')
    assert set(SHARED_MEMORY.glob('*.zenoh')) == before
