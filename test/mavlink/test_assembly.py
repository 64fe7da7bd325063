# SPDX-License-Identifier: Apache-2.0
"""From options to links: what is refused, what is heard, what is never told."""

import pytest
from test.mavlink.airspace import free_port
from test.mavlink.wire import KEY, NOW_S, STRANGER, frame, signed_frame

from rocsafe_mavlink.assembly import make_drones, make_lines
from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.errors import EndpointError, KeyFileError
from rocsafe_mavlink.link.endpoint import parse_endpoint
from rocsafe_mavlink.wire.counters import Reason


def options(count=1, **given):
    """Return options of vehicles on one free port."""
    values = {
        'vehicles': tuple(f'rav{n + 1}' for n in range(count)),
        'links': (f'udp://127.0.0.1:{free_port()}',) * count,
        'systems': tuple(range(1, count + 1)),
    }
    return BridgeOptions(**{**values, **given})


def only_line(given):
    """Return the one line of options; the caller closes it."""
    (line,) = make_lines(given).values()
    return line


@pytest.fixture
def key_file(tmp_path):
    """Give a signing key that only its owner can read."""
    path = tmp_path / 'drone.key'
    path.write_bytes(KEY.secret)
    path.chmod(0o600)
    return path


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        ({'links': ()}, 'links has 0 entries: must have 2'),
        ({'systems': (1,)}, 'systems has 1 entries: must have 2 or none'),
        ({'systems': (1, 1)}, 'must differ in systems or components'),
        ({'vehicles': ('rav1', 'rav1')}, 'must differ from each other'),
    ],
)
def test_lists_that_do_not_fit_are_refused(given, words):
    """The list is named, and how long it must be."""
    with pytest.raises(ValueError, match=words):
        options(2, **given)


def test_vehicles_share_a_socket_and_nothing_else():
    """One line for one link; each drone has its own target and journal."""
    given = options(3)
    lines = make_lines(given)
    drones = make_drones(given, lines)
    assert len(lines) == 1
    assert [drone.spec.target for drone in drones] == [(1, 1), (2, 1), (3, 1)]
    for line in lines.values():
        line.close()


def test_nothing_listens_beyond_this_machine_unless_told():
    """Neither does a wrong key leave the first socket open."""
    with pytest.raises(EndpointError, match='allowed explicitly'):
        make_lines(options(links=(f'udp://0.0.0.0:{free_port()}',)))
    parse_endpoint('udp://0.0.0.0:14550', allow_network=True)


def test_key_that_others_can_read_is_refused(key_file):
    """The message names file and mode, never the key."""
    key_file.chmod(0o640)
    with pytest.raises(KeyFileError, match='mode 0640: must be 0600') as refusal:
        make_lines(options(signing_key_files=(str(key_file),)))
    assert KEY.secret.hex() not in str(refusal.value)


def test_vehicles_on_one_link_have_one_key(key_file):
    """Two keys on one socket could not be told apart by what they sign."""
    with pytest.raises(ValueError, match='must have one signing key'):
        make_lines(options(2, signing_key_files=(str(key_file), '')))


def test_signed_link_hears_only_who_has_the_key_also_after_a_restart(key_file):
    """What was recorded before is not believed by the next process, whatever its run."""
    given = options(signing_key_files=(str(key_file),))
    line = only_line(given)
    station, data = line.station, signed_frame(time_s=NOW_S)
    assert station.receive(STRANGER, frame(), 0.0, NOW_S).messages == []
    assert len(station.receive(STRANGER, data, 0.0, NOW_S).messages) == 1
    line.close()
    again = only_line(given)
    assert again.station.receive(STRANGER, data, 0.0, NOW_S + 5.0).messages == []
    assert again.station.link.counters.dropped(Reason.REPLAYED) == 1
    again.close()
    stamps = key_file.with_name('drone.key.timestamps')
    assert KEY.secret.hex() not in stamps.read_text()


def test_stranger_with_the_right_number_changes_nothing(key_file):
    """Unsigned orders of another station on a signed link: no state, counted."""
    line = only_line(options(signing_key_files=(str(key_file),)))
    for data in (frame(), signed_frame(key=type(KEY)(b'x' * 32)), b'\xfd' * 600):
        assert line.station.receive(STRANGER, data, 0.0, NOW_S).messages == []
    assert line.station.vehicle((1, 1)).autopilot is None
    counters = line.station.link.counters
    assert counters.dropped(Reason.UNSIGNED) == counters.dropped(Reason.FORGED) == 1
    line.close()
