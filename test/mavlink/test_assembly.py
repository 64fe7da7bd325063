# SPDX-License-Identifier: Apache-2.0
"""From a drones file to stations: what is refused, what is heard, what is never told."""

import re
from pathlib import Path

import pytest
import yaml
from test.mavlink.airspace import free_port
from test.mavlink.wire import KEY, NOW_S, STRANGER, frame, signed_frame

from rocsafe_mavlink.assembly import make_drone, make_stations
from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.drone_options import DroneFleet, DroneOptions, read_drones
from rocsafe_mavlink.errors import KeyFileError
from rocsafe_mavlink.link.endpoint import parse_endpoint
from rocsafe_mavlink.wire.counters import Reason

ROOT = Path(__file__).parents[2]
OPTIONS = BridgeOptions()


def fleet(count=1, **given):
    """Return drones on one free port."""
    link = f'udp://127.0.0.1:{free_port()}'
    return DroneFleet(
        drones=tuple(
            DroneOptions(**{'name': f'rav{n + 1}', 'link': link, 'system': n + 1, **given})
            for n in range(count)
        )
    )


def only_station(drones):
    """Return the one station of drones, with what it serves; the caller closes it."""
    (station,) = make_stations(OPTIONS, drones).values()
    return station, [make_drone(drone, OPTIONS, station) for drone in drones.drones]


@pytest.fixture
def key_file(tmp_path):
    """Give a signing key that only its owner can read."""
    path = tmp_path / 'drone.key'
    path.write_bytes(KEY.secret)
    path.chmod(0o600)
    return path


def written(tmp_path, *drones):
    """Return the path of a drones file."""
    path = tmp_path / 'drones.yaml'
    path.write_text(yaml.safe_dump({'drones': list(drones)}))
    return str(path)


FIRST = {'name': 'rav1', 'link': 'udp://127.0.0.1:14550'}
SECOND = {'name': 'rav2', 'link': 'udp://127.0.0.1:14550'}


@pytest.mark.parametrize(
    ('drones', 'line'),
    [
        ([{'name': 'rav1'}], 'drones[0].link: is missing'),
        ([{**FIRST, 'sytem': 2}], 'drones[0].sytem: unknown key (did you mean system?)'),
        ([{**FIRST, 'system': 256}], 'drones[0]: system is 256: must be within 1 and 255'),
        ([{**FIRST, 'speed_mps': 0}], 'drones[0]: speed_mps is 0 m/s: must be above 0'),
        ([{**FIRST, 'speed_mps': 60}], 'drones[0]: speed_mps is 60 m/s'),
        ([{**FIRST, 'hover_s': -1}], 'drones[0]: hover_s is -1 s'),
        ([{**FIRST, 'endurance_s': 0}], 'drones[0]: endurance_s is 0 s'),
        ([{**FIRST, 'geoid_separation_m': 500}], 'drones[0]: geoid_separation_m is 500 m'),
        ([FIRST, FIRST], 'drones: rav1 is named twice'),
        ([FIRST, SECOND], 'drones on udp://127.0.0.1:14550 must differ in system or component'),
        (
            [FIRST, {**SECOND, 'system': 2, 'signing_key_file': 'a.key'}],
            'drones on udp://127.0.0.1:14550 must have one signing_key_file',
        ),
    ],
)
def test_wrong_drones_file_is_refused_in_a_line(tmp_path, drones, line):
    """The line names the file, the key, the value and the limit."""
    with pytest.raises(ValueError, match=f'^{re.escape("drones.yaml: " + line)}'):
        read_drones(written(tmp_path, *drones))


def test_missing_drones_file_is_named(tmp_path):
    """Not given, or not there."""
    with pytest.raises(ValueError, match='drones_file is empty'):
        read_drones('')
    with pytest.raises(ValueError, match='no such file'):
        read_drones(str(tmp_path / 'none.yaml'))


def test_drones_file_of_the_manual_can_be_used(tmp_path):
    """The example of docs/real-drones.md, as it stands there."""
    text = (ROOT / 'docs' / 'real-drones.md').read_text()
    (example,) = [
        block for block in re.findall(r'```yaml\n(.*?)```', text, re.DOTALL) if 'drones:' in block
    ]
    path = tmp_path / 'drones.yaml'
    path.write_text(example)
    drones = read_drones(str(path)).drones
    assert [drone.name for drone in drones] == ['rav1', 'rav2']
    for drone in drones:
        parse_endpoint(drone.link)


def test_drones_share_a_socket_and_nothing_else():
    """One station for one link; each drone has its own numbers and session."""
    station, drones = only_station(fleet(3))
    assert [drone.spec.target for drone in drones] == [(1, 1), (2, 1), (3, 1)]
    assert len({id(drone.session) for drone in drones}) == 3
    station.close()


BEYOND = 'udp://0.0.0.0:14550'


@pytest.mark.parametrize(
    ('given', 'words'),
    [
        ({'link': BEYOND}, 'listens beyond this machine: set allow_lan: true'),
        ({'link': 'udp://drone.example:14550'}, 'listens beyond this machine'),
        ({'link': BEYOND, 'signing_key_file': 'a.key'}, 'set allow_lan: true'),
        ({'link': BEYOND, 'unsigned': True}, 'set allow_lan: true'),
        ({'link': BEYOND, 'allow_lan': True}, 'set signing_key_file, or unsigned: true'),
        ({'link': 'tcp://192.0.2.1:5760'}, 'set signing_key_file, or unsigned: true'),
        ({'link': 'udpout://192.0.2.1:14550'}, 'set signing_key_file, or unsigned: true'),
        (
            {'link': BEYOND, 'allow_lan': True, 'unsigned': True, 'signing_key_file': 'a.key'},
            'unsigned is true: signing_key_file must be left out',
        ),
        ({'link': 'udp://127.0.0.1'}, 'must be HOST:PORT'),
    ],
)
def test_link_beyond_this_machine_is_refused_with_the_key_to_set(given, words):
    """Neither open to a network nor unsigned there, unless each was said by name."""
    with pytest.raises(ValueError, match=re.escape(words)):
        DroneOptions(name='rav1', **given)


def test_link_beyond_this_machine_is_opened_when_told(key_file):
    """With a key, or without one by name; then any host is heard, and a wrong key is not."""
    link = f'udp://0.0.0.0:{free_port()}'
    station, _ = only_station(fleet(link=link, allow_lan=True, unsigned=True))
    assert heard(station, frame())
    station.close()
    station, _ = only_station(fleet(link=link, allow_lan=True, signing_key_file=str(key_file)))
    assert not heard(station, frame())
    assert heard(station, signed_frame())
    station.close()


def test_drones_on_a_link_agree_on_signatures():
    """One of them cannot open the link of another."""
    drones = [DroneOptions(name='a', link='udp://127.0.0.1:1', system=1, unsigned=True),
              DroneOptions(name='b', link='udp://127.0.0.1:1', system=2)]  # fmt: skip
    with pytest.raises(ValueError, match='must have one value of unsigned'):
        DroneFleet(drones=tuple(drones))


def test_key_that_others_can_read_is_refused(key_file):
    """The message names file and mode, never the key."""
    key_file.chmod(0o640)
    with pytest.raises(KeyFileError, match='mode 0640: must be 0600') as refusal:
        make_stations(OPTIONS, fleet(signing_key_file=str(key_file)))
    assert KEY.secret.hex() not in str(refusal.value)


def heard(station, data, time_s=NOW_S):
    """Return the messages that a station believes."""
    return station.link.receive(STRANGER, data, 0.0, time_s)


def test_signed_link_hears_only_who_has_the_key_also_after_a_restart(key_file):
    """What was recorded before is not believed by the next process, whatever its run."""
    drones = fleet(signing_key_file=str(key_file))
    station, data = only_station(drones)[0], signed_frame(time_s=NOW_S)
    assert heard(station, frame()) == []
    assert len(heard(station, data)) == 1
    station.close()
    again = only_station(drones)[0]
    assert heard(again, data, NOW_S + 5.0) == []
    assert again.link.counters.dropped(Reason.REPLAYED) == 1
    again.close()
    stamps = key_file.with_name('drone.key.timestamps')
    assert KEY.secret.hex() not in stamps.read_text()


def test_stranger_with_the_right_number_changes_nothing(key_file):
    """Unsigned commands of another station on a signed link: no state, counted."""
    station, (drone,) = only_station(fleet(signing_key_file=str(key_file)))
    for data in (frame(), signed_frame(key=type(KEY)(b'x' * 32)), b'\xfd' * 600):
        assert heard(station, data) == []
    assert drone.vehicle.autopilot is None
    counters = station.link.counters
    assert counters.dropped(Reason.UNSIGNED) == counters.dropped(Reason.FORGED) == 1
    station.close()
