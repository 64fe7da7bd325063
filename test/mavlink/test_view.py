# SPDX-License-Identifier: Apache-2.0
"""Simulated vehicles as a ground station sees them."""

import math
import socket
import threading
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.link.endpoint import parse_endpoint
from rocsafe_mavlink.view.answers import ACCEPTED, DENIED, MISSION_DENIED, answers
from rocsafe_mavlink.view.sight import Sight, mission_of
from rocsafe_mavlink.view.station_view import MOST_VEHICLES, StationView
from rocsafe_mavlink.view.telemetry_messages import fast_messages, slow_messages
from rocsafe_mavlink.view_options import ViewOptions
from rocsafe_mavlink.wire.authority import COMMANDS, REQUEST_MESSAGE
from rocsafe_mavlink.wire.dialect import Message, addressed, decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan

HOME = GeoPosition(53.28, -9.06, 66.0)
VIEWPOINTS = (GeoPosition(53.2801, -9.0601, 98.0), GeoPosition(53.2802, -9.0602, 97.0))
STATION = (255, 190)


def sight(**changes: Any) -> Sight:
    """Return a vehicle in the air over its route, flying north-east."""
    values = {
        'system': 3,
        'position': GeoPosition(53.2805, -9.0605, 98.5),
        'home': HOME,
        'velocity_enu': (3.0, 4.0, -0.5),
        'yaw_rad': 0.0,
        'battery_fraction': 0.73,
        'voltage_v': 15.2,
        'is_airborne': True,
        'items': mission_of(VIEWPOINTS, HOME),
        'reached': 1,
    }
    return Sight(**{**values, **changes})


def asked(name: str, **fields: Any) -> Message:
    """Return what a ground station asks of system 3."""
    message = addressed(name, (3, 1), **fields)
    number, payload = encode(message)
    return decode(number, payload, *STATION)


def told(messages: Iterator[Message]) -> dict[str, Message]:
    """Return messages by name."""
    return {message.name: message for message in messages}


def test_axes_and_units_are_those_of_mavlink() -> None:
    """North, east, down in cm/s; heading clockwise from north; millimetres above home."""
    place = told(fast_messages(sight(), 5000))['GLOBAL_POSITION_INT']
    assert (place['vx'], place['vy'], place['vz']) == (400, 300, 50)
    assert place['hdg'] == 9000
    assert place['relative_alt'] == 32_500
    assert place['lat'] == 532_805_000
    attitude = told(fast_messages(sight(yaw_rad=math.pi), 0))['ATTITUDE']
    assert attitude['yaw'] == pytest.approx(-math.pi / 2.0)


def test_every_message_can_be_packed() -> None:
    """Also of a vehicle of which nothing is known, and one with absurd values."""
    for one in (
        sight(),
        Sight(system=1),
        sight(velocity_enu=(1e6, -1e6, 1e6), current_a=1e9, voltage_v=1e9, battery_fraction=7.0),
    ):
        for message in (*slow_messages(one, 10), *fast_messages(one, 10)):
            number, payload = encode(message)
            assert scan(pack_frame(number, payload, one.system, 1, 0, sign=False), is_whole=True)


def test_nothing_is_said_of_a_place_that_is_not_known() -> None:
    """Before the first fix there is a heartbeat and no position."""
    assert list(fast_messages(Sight(system=1), 0)) == []
    assert 'HEARTBEAT' in told(slow_messages(Sight(system=1), 0))


@pytest.mark.parametrize('number', sorted({*COMMANDS, 176, 185, 246, 511}))
@pytest.mark.parametrize('name', ['COMMAND_LONG', 'COMMAND_INT'])
def test_every_command_is_denied(name: str, number: int) -> None:
    """Arming, take-off, modes, ending a flight: each gets its refusal, whatever its numbers."""
    for value in (1.0, math.nan):
        (answer,) = answers(sight(), asked(name, command=number, param1=value))
        assert answer['result'] == DENIED
        assert answer['target_system'] == STATION[0]


def test_who_it_is_can_be_asked() -> None:
    """The version is told on request: MAVSDK waits for it."""
    found = told(answers(sight(), asked('COMMAND_LONG', command=REQUEST_MESSAGE, param1=148.0)))
    assert found['COMMAND_ACK']['result'] == ACCEPTED
    assert found['AUTOPILOT_VERSION'].system == 3


@pytest.mark.parametrize(
    'name', ['MISSION_COUNT', 'MISSION_CLEAR_ALL', 'MISSION_SET_CURRENT', 'MISSION_ITEM_INT']
)
def test_missions_cannot_be_written(name: str) -> None:
    """Each attempt is denied, and the mission stays."""
    one = sight()
    before = one.items
    (answer,) = answers(one, asked(name))
    assert (answer.name, answer['type']) == ('MISSION_ACK', MISSION_DENIED)
    assert one.items is before


def test_no_message_of_the_dialect_changes_anything() -> None:
    """What a vehicle shows is the same after every kind of message that can be addressed to it."""
    one, same = sight(), sight()
    for name in (
        'SET_MODE', 'PARAM_SET', 'RC_CHANNELS_OVERRIDE', 'FILE_TRANSFER_PROTOCOL',
        'SET_POSITION_TARGET_GLOBAL_INT', 'SET_ATTITUDE_TARGET', 'PARAM_REQUEST_LIST',
        'MISSION_REQUEST_LIST', 'SET_HOME_POSITION',
    ):  # fmt: skip
        message = Message(name, {'target_system': 3})
        list(answers(one, decode(*encode(message), *STATION)))
    assert one == same


def test_an_item_beyond_the_end_is_refused() -> None:
    """No index error, a refusal."""
    (answer,) = answers(sight(), asked('MISSION_REQUEST_INT', seq=4, mission_type=0))
    assert answer.name == 'MISSION_ACK'


@pytest.mark.parametrize('endpoint', ['udp://0.0.0.0:14550', 'tcp://127.0.0.1:5760', 'nonsense'])
def test_only_a_place_to_send_to_is_taken(endpoint: str) -> None:
    """A view listens to nobody but the station that it shows vehicles to."""
    with pytest.raises(ValueError, match='endpoint'):
        ViewOptions(endpoint=endpoint)


@pytest.fixture
def shown() -> Iterator[Callable[[StationView], int]]:
    """Give a function that serves a view in a thread until the test ends."""
    stop, threads = threading.Event(), []

    def serve(view: StationView) -> None:
        rounds = 0
        while not stop.wait(0.01):
            if rounds % 10 == 0:
                view.show(rounds * 10, is_slow=rounds % 50 == 0)
            view.answer(rounds * 0.01)
            rounds += 1
        view.close()

    def start(view: StationView) -> None:
        threads.append(threading.Thread(target=serve, args=(view,)))
        threads[-1].start()

    yield start
    stop.set()
    for thread in threads:
        thread.join()


def free_port() -> int:
    """Return a UDP port that nobody uses."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as probe:
        probe.bind(('127.0.0.1', 0))
        return int(probe.getsockname()[1])


def test_garbage_of_a_station_is_survived(shown: Callable[[StationView], None]) -> None:
    """Datagrams that are no messages change nothing: the next request is answered."""
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as station:
        station.bind(('127.0.0.1', 0))
        station.settimeout(10.0)
        view = StationView(parse_endpoint(f'udpout://127.0.0.1:{station.getsockname()[1]}'))
        view.add('rav1')
        shown(view)
        _data, address = station.recvfrom(512)
        for junk in (b'', b'\xfd' * 300, bytes(range(256))):
            station.sendto(junk, address)
        request = addressed('MISSION_REQUEST_LIST', (1, 1), mission_type=0)
        station.sendto(pack_frame(*encode(request), *STATION, 0, sign=False), address)
        frames = (
            frame for data in iter(lambda: station.recv(512), None)
            for frame in scan(data, is_whole=True).frames
        )  # fmt: skip
        names = (decode(f.message_id, f.payload, f.system, f.component).name for f in frames)
        assert 'MISSION_COUNT' in names


def test_systems_are_numbered_and_limited() -> None:
    """Each vehicle keeps its number; there are no more than MAVLink has."""
    view = StationView(parse_endpoint(f'udpout://127.0.0.1:{free_port()}'))
    try:
        systems = [view.add(f'rav{k}').system for k in range(MOST_VEHICLES)]
        assert systems == list(range(1, MOST_VEHICLES + 1))
        assert view.add('rav0').system == 1
        with pytest.raises(ValueError, match='at most 250'):
            view.add('one more')
    finally:
        view.close()


@pytest.mark.slow
def test_mavsdk_sees_and_cannot_command(shown: Callable[[StationView], None]) -> None:
    """The real MAVSDK finds the vehicle, reads it and its mission, and is refused all else."""
    mavsdk = pytest.importorskip('mavsdk', reason='needs the wheel of MAVSDK')
    from mavsdk.plugins.action import Action
    from mavsdk.plugins.mission_raw import MissionRaw
    from mavsdk.plugins.telemetry import Telemetry

    port = free_port()
    configuration = mavsdk.Configuration.create_with_component_type(
        mavsdk.ComponentType.GROUND_STATION
    )
    station = mavsdk.Mavsdk(configuration)
    station.add_any_connection(f'udpin://127.0.0.1:{port}')
    view = StationView(parse_endpoint(f'udpout://127.0.0.1:{port}'))
    view.sights['rav3'] = sight()
    shown(view)
    drone = station.first_autopilot(20.0)
    assert drone is not None
    assert drone.get_system_id() == 3
    heard, places = threading.Event(), []
    telemetry = Telemetry(drone)
    telemetry.subscribe_position(lambda place, *_: (places.append(place), heard.set()))
    assert heard.wait(20.0)
    assert places[0].latitude_deg == pytest.approx(53.2805, abs=1e-7)
    assert places[0].relative_altitude_m == pytest.approx(32.5, abs=1e-3)
    assert [item.command for item in MissionRaw(drone).download_mission()] == [22, 16, 16, 20]
    for order in (Action(drone).arm, Action(drone).takeoff, MissionRaw(drone).clear_mission):
        with pytest.raises(Exception, match='DENIED'):
            order()
    station.destroy()
