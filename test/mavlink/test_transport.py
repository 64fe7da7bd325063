# SPDX-License-Identifier: Apache-2.0
"""Endpoints are understood or refused in a line; transports carry bytes and open again."""

import os
import socket
import time

import pytest

from rocsafe_mavlink.errors import EndpointError
from rocsafe_mavlink.link.endpoint import Endpoint, EndpointKind, parse_endpoint
from rocsafe_mavlink.link.link_limits import LINK_LIMITS
from rocsafe_mavlink.link.transport import UdpTransport, address_of, open_transport

DEADLINE_S = 60.0
LOOPBACK = '127.0.0.1'


def taken(transport, now_s=0.0):
    """Return the first pieces that come."""
    end = time.monotonic() + DEADLINE_S
    while time.monotonic() < end:
        if pieces := transport.take(now_s):
            return pieces
        time.sleep(0.001)
    pytest.fail('nothing came')


@pytest.mark.parametrize(
    ('text', 'endpoint'),
    [
        (
            'udp://127.0.0.1:14550?peer=127.0.0.1:14551&peer=10.0.0.2:5',
            Endpoint(
                kind=EndpointKind.UDP,
                host=LOOPBACK,
                port=14550,
                peers=((LOOPBACK, 14551), ('10.0.0.2', 5)),
            ),
        ),
        (
            'udpout://10.0.0.2:14550',
            Endpoint(kind=EndpointKind.UDP_OUT, host='10.0.0.2', port=14550),
        ),
        ('tcp://[::1]:5760', Endpoint(kind=EndpointKind.TCP, host='::1', port=5760)),
        (
            'serial:///dev/ttyACM0?baud=115200',
            Endpoint(kind=EndpointKind.SERIAL, device='/dev/ttyACM0', baud=115200),
        ),
    ],
)
def test_endpoint_is_understood(text, endpoint):
    """Each kind of link has its words."""
    assert parse_endpoint(text) == endpoint


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('127.0.0.1:14550', 'must begin with one of: udp://'),
        ('udp://127.0.0.1', 'must be HOST:PORT'),
        ('udp://127.0.0.1:70000', 'out of range'),
        ('udp://127.0.0.1:1?pear=1', "option 'pear' is not known"),
        ('tcp://127.0.0.1:1?peer=127.0.0.1:2', 'only udp:// has peers'),
        ('tcp://127.0.0.1:1/x', 'is not understood'),
        ('serial://ttyACM0', 'must name a device'),
        ('serial:///dev/ttyACM0?baud=fast', "baud = 'fast'"),
    ],
)
def test_wrong_endpoint_is_refused(text, words):
    """The text says what is wrong with which link."""
    with pytest.raises(EndpointError, match=words) as caught:
        parse_endpoint(text)
    assert repr(text) in str(caught.value)


def test_udp_carries_datagrams_both_ways():
    """Who waits answers who calls."""
    waiting = UdpTransport(parse_endpoint('udp://127.0.0.1:0'))
    calling = open_transport(parse_endpoint(f'udpout://127.0.0.1:{waiting.port}'))
    assert calling.take(0.0) == []
    assert calling.send(None, b'one')
    ((sender, data),) = taken(waiting)
    assert data == b'one'
    assert waiting.send(sender, b'two')
    assert taken(calling) == [((LOOPBACK, waiting.port), b'two')]
    waiting.close()
    calling.close()
    assert not calling.send(None, b'three')


def test_taken_port_is_named():
    """Two cannot wait at one port."""
    first = UdpTransport(parse_endpoint('udp://127.0.0.1:0'))
    with pytest.raises(EndpointError, match=f'udp 127.0.0.1:{first.port}: Address already in use'):
        UdpTransport(parse_endpoint(f'udp://127.0.0.1:{first.port}'))
    first.close()


def test_nobody_at_the_other_end_is_no_error():
    """A refused datagram is lost, as on a radio."""
    free = UdpTransport(parse_endpoint('udp://127.0.0.1:0'))
    port = free.port
    free.close()
    calling = open_transport(parse_endpoint(f'udpout://127.0.0.1:{port}'))
    calling.send(None, b'one')
    assert calling.take(0.0) == []
    calling.close()


def test_tcp_opens_again():
    """A line that was cut is called again after a second, not before."""
    server = socket.create_server((LOOPBACK, 0))
    server.settimeout(DEADLINE_S)
    endpoint = parse_endpoint(f'tcp://127.0.0.1:{server.getsockname()[1]}')
    transport = open_transport(endpoint)
    assert not transport.send(None, b'too early')
    transport.take(0.0)
    with server.accept()[0] as line:
        line.sendall(b'one')
        assert taken(transport) == [(address_of(endpoint), b'one')]
        assert transport.send(None, b'two')
        assert line.recv(10) == b'two'
    end = time.monotonic() + DEADLINE_S
    while transport.is_open and time.monotonic() < end:
        transport.take(0.0)
    assert not transport.is_open
    transport.take(LINK_LIMITS.retry_s / 2.0)
    assert not transport.is_open
    transport.take(LINK_LIMITS.retry_s)
    with server.accept()[0] as line:
        line.sendall(b'three')
        assert taken(transport) == [(address_of(endpoint), b'three')]
    transport.close()
    server.close()


def test_serial_line_is_raw():
    """A terminal device carries any byte unchanged."""
    far, near = os.openpty()
    endpoint = parse_endpoint(f'serial://{os.ttyname(near)}')
    transport = open_transport(endpoint)
    transport.take(0.0)
    data = bytes(range(256))
    os.write(far, data)
    heard = b''
    while len(heard) < len(data):
        heard += b''.join(piece for _, piece in taken(transport))
    assert heard == data
    assert transport.send(None, b'\n\x03\xfd')
    assert os.read(far, 10) == b'\n\x03\xfd'
    transport.close()
    os.close(far)
    os.close(near)


def test_missing_device_is_waited_for():
    """A device that is not there is no error: it may be plugged in."""
    transport = open_transport(parse_endpoint('serial:///dev/rocsafe-none'))
    assert transport.take(0.0) == []
    assert not transport.send(None, b'x')


def test_unknown_baud_rate_is_named():
    """The system's own list decides."""
    with pytest.raises(EndpointError, match='no baud rate 12345'):
        open_transport(parse_endpoint('serial:///dev/ttyACM0?baud=12345'))
