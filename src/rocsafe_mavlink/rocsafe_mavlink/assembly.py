# SPDX-License-Identifier: Apache-2.0
"""Construction of stations, drones and cameras from options."""

import math
import secrets
from collections.abc import Callable, Container
from pathlib import Path

from rocsafe_mavlink.bridge_options import BridgeOptions
from rocsafe_mavlink.camera.folder_source import FolderSource
from rocsafe_mavlink.camera.geotagging import Geotagger
from rocsafe_mavlink.camera.numbering import ShotNumbering
from rocsafe_mavlink.camera.source import ImageSource
from rocsafe_mavlink.camera.video_source import VideoSource
from rocsafe_mavlink.drone.drone import Drone
from rocsafe_mavlink.drone.station import Station
from rocsafe_mavlink.drone.vehicle_session import VehicleSession
from rocsafe_mavlink.drone_options import DroneFleet, DroneOptions
from rocsafe_mavlink.flight.flight_journal import FlightJournal
from rocsafe_mavlink.link.endpoint import Endpoint, parse_endpoint
from rocsafe_mavlink.link.link import Link, LinkRules
from rocsafe_mavlink.link.transport import address_of, open_transport
from rocsafe_mavlink.wire.signing import TICKS_PER_S, SignatureGate, Signer, read_key, ticks_at
from rocsafe_mavlink.wire.timestamp_store import TimestampStore

LINK_ID = 0
# Clocks differ by less where all are set by GPS or by a time server.
LARGEST_AHEAD_S = 60.0
STREAM_PREFIXES = ('rtsp://', 'http://', 'https://', '/dev/video')


def make_stations(options: BridgeOptions, fleet: DroneFleet) -> dict[str, Station]:
    """Return a station for each link, its transport open.

    Raises
    ------
    MavlinkError
        If a link cannot be understood or opened, or a key cannot be read.
    ValueError
        If a file is damaged.
    """
    stations: dict[str, Station] = {}
    # Not 0, which other stations send.
    instance = secrets.randbits(31) + 1
    try:
        for link in fleet.links:
            key_file = fleet.on(link)[0].signing_key_file
            stations[link] = _station(link, key_file, options, instance)
    except BaseException:
        for station in stations.values():
            station.close()
        raise
    return stations


def require_files(fleet: DroneFleet, names: Container[str]) -> None:
    """Read keys and find image folders of the vehicles named, as a bridge on this machine would.

    Raises
    ------
    KeyFileError
        If a key cannot be read.
    ValueError
        If an image folder is missing, or a file of time stamps is damaged.
    """
    for drone in fleet.drones:
        if drone.name not in names:
            continue
        if drone.signing_key_file:
            read_key(Path(drone.signing_key_file))
            timestamps_of(Path(drone.signing_key_file))
        if not drone.image_folder.startswith(STREAM_PREFIXES):
            open_source(drone.image_folder, lambda: 0.0)


def clock_warnings(fleet: DroneFleet, now_s: float) -> list[str]:
    """Return a line for each key with time stamps ahead of our clock; see the command signing."""
    lines = []
    for key_file in sorted({drone.signing_key_file for drone in fleet.drones} - {''}):
        newest = max(timestamps_of(Path(key_file)).limits.values(), default=0)
        ahead_s = (newest - ticks_at(now_s)) / TICKS_PER_S
        if ahead_s > LARGEST_AHEAD_S:
            lines.append(
                f'{key_file}: time stamps are {ahead_s:.0f} s ahead of our clock; if that clock '
                'is right, end the bridge and call: ros2 run rocsafe_mavlink signing reset'
            )
    return lines


def make_drone(drone: DroneOptions, options: BridgeOptions, station: Station) -> Drone:
    """Return a drone that `station` serves.

    Raises
    ------
    ValueError
        If its journal is damaged.
    """
    identity, separation_m = options.identity, drone.geoid_separation_m
    session = VehicleSession.of(
        drone.target,
        (identity.system, identity.component),
        separation_m=math.nan if separation_m is None else separation_m,
        position_rate_hz=options.position_rate_hz,
    )
    folder = options.state_path(drone.name)
    journal = FlightJournal(None if folder is None else folder / 'flight.json')
    made = Drone(options.spec(drone), session, journal)
    station.add(made)
    return made


def make_geotagger(
    drone: DroneOptions, options: BridgeOptions, clock: Callable[[], float]
) -> Geotagger:
    """Return what makes photographs of the images of a drone; `clock` is the time of day.

    Raises
    ------
    ValueError
        If its images cannot be found.
    SpoolError
        If photographs of an earlier run cannot be read.
    """
    folder = options.state_path(drone.name)
    return Geotagger(
        ShotNumbering(None if folder is None else folder / 'shots'),
        open_source(drone.image_folder, clock),
        folder,
    )


def open_source(text: str, clock: Callable[[], float]) -> ImageSource | None:
    """Return the source of images that `text` names; None if it is empty.

    Raises
    ------
    ValueError
        If it is neither a folder nor a stream.
    """
    if not text:
        return None
    if text.startswith(STREAM_PREFIXES):
        return VideoSource(text, clock)
    folder = Path(text)
    if not folder.is_dir():
        raise ValueError(
            f'image folder {text!r} is no folder, nor rtsp://..., http://... or /dev/video...'
        )
    return FolderSource(folder)


def _station(link: str, key_file: str, options: BridgeOptions, instance: int) -> Station:
    endpoint = parse_endpoint(link)
    gate = signer = None
    if key_file:
        key, store = read_key(Path(key_file)), timestamps_of(Path(key_file))
        gate, signer = SignatureGate(key, store), Signer(key, LINK_ID, store)
    return Station(
        open_transport(endpoint),
        Link(_rules(endpoint), options.identity, gate, signer),
        instance,
    )


def _rules(endpoint: Endpoint) -> LinkRules:
    called = () if endpoint.is_listening else (address_of(endpoint),)
    return LinkRules(
        allowed=frozenset((*endpoint.peers, *called)),
        called=frozenset(called),
        is_discovering=endpoint.is_listening and not endpoint.peers,
        is_stream=endpoint.is_stream,
    )


def timestamps_of(key_file: Path) -> TimestampStore:
    """Return the time stamps of a key: they outlive runs, as the key does.

    Raises
    ------
    ValueError
        If their file is damaged.
    """
    return TimestampStore(key_file.with_name(f'{key_file.name}.timestamps'))
