# SPDX-License-Identifier: Apache-2.0
"""From options to lines and drones."""

from collections.abc import Callable
from pathlib import Path

from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.camera.camera_trigger import Photographer
from rocsafe_mavlink.camera.numbering import Film
from rocsafe_mavlink.camera.sources import open_source
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.line import Line
from rocsafe_mavlink.drone.station import Station
from rocsafe_mavlink.flight.flight_journal import FlightJournal
from rocsafe_mavlink.link.endpoint import parse_endpoint
from rocsafe_mavlink.link.link import Link, LinkRules
from rocsafe_mavlink.link.transport import address_of, open_transport
from rocsafe_mavlink.protocols.stream_rates import StreamRates
from rocsafe_mavlink.wire.signing import SignatureGate, Signer, read_key
from rocsafe_mavlink.wire.timestamp_store import TimestampStore

LINK_ID = 0


def make_lines(options: BridgeOptions) -> dict[str, Line]:
    """Return a line for each different link, opened.

    Raises
    ------
    MavlinkError: if a link is none or cannot be opened, or a key cannot be read.
    ValueError: if vehicles on one link have different keys, or a file is damaged.
    """
    lines: dict[str, Line] = {}
    try:
        for text in dict.fromkeys(options.links):
            lines[text] = _line(text, options)
    except BaseException:
        for line in lines.values():
            line.close()
        raise
    return lines


def make_drones(options: BridgeOptions, lines: dict[str, Line]) -> list[Drone]:
    """Return the drones, each listening on its line.

    Raises
    ------
    ValueError: if a journal is damaged.
    """
    drones = []
    for index, text in enumerate(options.links):
        spec = options.spec(index)
        folder = options.state_path(spec.name)
        journal = FlightJournal(None if folder is None else folder / 'flight.json')
        drones.append(Drone(spec, lines[text], journal))
    return drones


def make_photographer(
    options: BridgeOptions, index: int, clock: Callable[[], float]
) -> Photographer:
    """Return who follows the camera of vehicle `index`.

    Raises
    ------
    ValueError: if its pictures are to come from nowhere.
    SpoolError: if photographs of an earlier run cannot be read.
    """
    folder = options.state_path(options.vehicles[index])
    return Photographer(
        Film(None if folder is None else folder / 'shots'),
        open_source(options.text_of('image_folders', index), clock),
        None if folder is None else folder / 'shots.csv',
    )


def _line(text: str, options: BridgeOptions) -> Line:
    endpoint = parse_endpoint(text, allow_network=options.allow_network)
    members = [index for index, link in enumerate(options.links) if link == text]
    is_listening = endpoint.host and not endpoint.peers and endpoint.kind.value == 'udp'
    called = () if endpoint.kind.value == 'udp' else (address_of(endpoint),)
    rules = LinkRules(
        allowed=frozenset((*endpoint.peers, *called)),
        called=frozenset(called),
        is_discovering=bool(is_listening) and endpoint.is_loopback,
        is_stream=endpoint.is_stream,
    )
    key_file = _key_file(options, members)
    gate = signer = None
    if key_file:
        key, store = read_key(Path(key_file)), _store(Path(key_file))
        gate, signer = SignatureGate(key, store), Signer(key, LINK_ID, store)
    link = Link(rules, options.identity, gate, signer)
    station = Station(
        link,
        [options.targets[index] for index in members],
        (options.source_system, options.source_component),
        {options.targets[index]: options.separation_m(index) for index in members},
    )
    for index in members:
        station.member(options.targets[index]).rates = StreamRates(options.position_rate_hz)
    return Line(text, open_transport(endpoint), station)


def _key_file(options: BridgeOptions, members: list[int]) -> str:
    files = {options.text_of('signing_key_files', index) for index in members}
    if len(files) > 1:
        names = ', '.join(options.vehicles[index] for index in members)
        raise ValueError(f'{names} share a link: must have one signing key')
    return files.pop()


def _store(key_file: Path) -> TimestampStore:
    """Return the time stamps that go with a key: they outlive runs, as the key does."""
    return TimestampStore(key_file.with_name(f'{key_file.name}.timestamps'))
