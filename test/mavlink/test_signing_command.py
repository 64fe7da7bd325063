# SPDX-License-Identifier: Apache-2.0
"""Keys are made, sent by wire or loopback only, and stamps of the future are taken back."""

import socket
import threading

import pytest
from test.mavlink.airspace import free_port
from test.mavlink.wire import (
    DRONE,
    HEARTBEAT,
    KEY,
    NOW_S,
    WRONG_KEY,
    frame,
    signed_frame,
    signed_link,
)

from rocsafe_mavlink.assembly import clock_warnings
from rocsafe_mavlink.drone_options import DroneFleet, DroneOptions
from rocsafe_mavlink.signing_command import described, main, reset
from rocsafe_mavlink.wire.dialect import decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan
from rocsafe_mavlink.wire.signing import SignatureGate, SignatureVerdict, Signer, read_key
from rocsafe_mavlink.wire.timestamp_store import TimestampStore

YEAR_S = 365.0 * 86_400.0


@pytest.fixture
def key_file(tmp_path):
    """Give a key in a private file."""
    path = tmp_path / 'rav1.key'
    path.write_bytes(KEY.secret)
    path.chmod(0o600)
    return path


def stamps(key_file):
    """Return the path of the time stamps of a key."""
    return key_file.with_name('rav1.key.timestamps')


def test_new_key_is_private_and_never_overwritten(tmp_path, capsys):
    """64 digits of mode 0600; a second time it is refused, and nothing prints it."""
    path = tmp_path / 'new.key'
    assert main(['new', str(path)]) == 0
    assert path.stat().st_mode & 0o777 == 0o600
    secret = read_key(path).secret
    assert main(['new', str(path)]) == 1
    assert read_key(path).secret == secret
    printed = capsys.readouterr()
    assert 'File exists' in printed.err
    assert secret.hex() not in printed.out + printed.err


def test_stamp_of_the_future_is_told_and_taken_back(key_file, capsys):
    """A vehicle whose clock was twenty years ahead is locked out until then, or until this."""
    future = NOW_S + 20.0 * YEAR_S
    link = signed_link(stamps(key_file))
    assert link.receive(DRONE, signed_frame(time_s=future), 0.0, NOW_S)
    again = signed_link(stamps(key_file))
    assert not again.receive(DRONE, signed_frame(time_s=NOW_S + 60.0), 0.0, NOW_S + 60.0)
    (line,) = described(key_file, NOW_S)
    assert line.startswith('link/system/component 1/1/1: 2045-12-27')
    assert ' s ahead of our clock' in line
    fleet = DroneFleet(
        drones=(DroneOptions(name='a', link='udp://127.0.0.1:1', signing_key_file=str(key_file)),)
    )
    (warning,) = clock_warnings(fleet, NOW_S)
    assert 'signing reset' in warning
    assert reset(key_file, NOW_S) == ['1/1/1']
    assert clock_warnings(fleet, NOW_S) == []
    mended = signed_link(stamps(key_file))
    assert mended.receive(DRONE, signed_frame(time_s=NOW_S + 60.0), 0.0, NOW_S + 60.0)
    assert reset(key_file, NOW_S + 120.0) == []
    assert main(['show', str(key_file)]) == 0
    assert KEY.secret.hex() not in capsys.readouterr().out


def test_damaged_or_missing_files_are_named(tmp_path, key_file, capsys):
    """One line, exit code 1."""
    stamps(key_file).write_text('[]')
    for arguments in (['reset', str(tmp_path / 'none')], ['show', str(key_file)]):
        assert main(arguments) == 1
        assert capsys.readouterr().err.count('\n') == 1


class Autopilot:
    """A vehicle without GPS time: its clock is the highest time stamp that it accepted."""

    def __init__(self, time_s):
        self.time_s = time_s
        self.store = TimestampStore()
        self.gate, self.signer = SignatureGate(KEY, self.store), Signer(KEY, 1, self.store)

    def beat(self):
        """Return a signed heartbeat by its clock."""
        body = pack_frame(*encode(HEARTBEAT), 1, 1, 0, sign=True)
        return body + self.signer.signature(body, self.time_s)

    def hear(self, data):
        """Return the verdict on what the station sent."""
        (sent,) = scan(data, is_whole=True).frames
        return self.gate.judge(sent, self.time_s)


@pytest.mark.parametrize('was_heard', [False, True], ids=['new', 'known'])
def test_vehicle_without_gps_time_is_greeted(was_heard):
    """Ten years behind on a link that only listens: our heartbeat sets its clock."""
    link, vehicle = signed_link(allowed=()), Autopilot(NOW_S - 10.0 * YEAR_S)
    if was_heard:
        assert link.receive(DRONE, signed_frame(HEARTBEAT), 0.0, NOW_S)
    assert link.receive(DRONE, vehicle.beat(), 1.0, NOW_S) == []
    assert link.stations == (DRONE,)
    greeting = link.pack(HEARTBEAT, 1.0, NOW_S + 1.0)
    assert vehicle.hear(greeting) is SignatureVerdict.GOOD
    assert link.receive(DRONE, vehicle.beat(), 2.0, NOW_S + 1.0)


def test_only_holders_of_the_key_are_greeted_and_few_of_them():
    """Neither unsigned nor by another key; and not for ever."""
    link = signed_link(allowed=())
    old_s = NOW_S - YEAR_S
    for data in (frame(HEARTBEAT), signed_frame(HEARTBEAT, key=WRONG_KEY, time_s=old_s)):
        link.receive(DRONE, data, 0.0, NOW_S)
    assert link.stations == ()
    for port in range(100):
        link.receive(('192.0.2.1', port), signed_frame(HEARTBEAT, time_s=old_s), 0.0, NOW_S)
    assert len(link.stations) == 8
    link.receive(DRONE, frame(HEARTBEAT), 10.0, NOW_S)
    assert link.stations == ()


@pytest.mark.slow
def test_key_is_sent_to_the_vehicle(key_file, capsys):
    """It waits for the heartbeat, and sends key and time to that vehicle, within this machine."""
    port, got = free_port(), []

    def fly():
        vehicle = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        vehicle.settimeout(0.2)
        for _ in range(40):
            vehicle.sendto(frame(HEARTBEAT), ('127.0.0.1', port))
            try:
                (sent,) = scan(vehicle.recv(400), is_whole=True).frames
            except TimeoutError:
                continue
            got.append(decode(sent.message_id, sent.payload, sent.system, sent.component))
            break
        vehicle.close()

    thread = threading.Thread(target=fly)
    thread.start()
    assert main(['send', str(key_file), f'udp://127.0.0.1:{port}']) == 0
    thread.join(timeout=20.0)
    (message,) = got
    assert (message.name, message['target_system']) == ('SETUP_SIGNING', 1)
    assert bytes(message['secret_key']) == KEY.secret
    assert KEY.secret.hex() not in capsys.readouterr().out


def test_key_is_not_sent_over_a_network(key_file, capsys):
    """In clear only by a wire."""
    assert main(['send', str(key_file), 'udpout://192.0.2.1:14550']) == 1
    assert 'use a serial port (USB)' in capsys.readouterr().err
