# SPDX-License-Identifier: Apache-2.0
"""The drones of a bridge, as its `drones_file` describes them."""

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.limits import require_between, require_positive
from rocsafe_geo.storage.value_file import read_values
from rocsafe_mavlink.errors import EndpointError
from rocsafe_mavlink.knowledge.fix import LARGEST_SEPARATION_M
from rocsafe_mavlink.link.endpoint import parse_endpoint

LARGEST_SPEED_MPS = 50.0
LARGEST_HOVER_S = 600.0
ON_WIND = ('warn', 'return')


@dataclass(frozen=True, slots=True, kw_only=True)
class DroneOptions:
    """One drone of the file.

    Attributes
    ----------
    name
        Name of the vehicle, which is its namespace.
    link
        ``udp://HOST:PORT``, ``udpout://HOST:PORT``, ``tcp://HOST:PORT`` or
        ``serial:///dev/NAME?baud=N``; drones may share one.
    system, component
        MAVLink numbers of the autopilot, 1 to 255.
    speed_mps
        Speed over ground, m/s.
    hover_s
        Time that it stays at a viewpoint, seconds.
    endurance_s
        Flight time on a full battery, seconds.
    image_folder
        Folder of its JPEG files, or ``rtsp://...``, ``http://...``, ``/dev/video...``; empty: no
        images.
    signing_key_file
        Signing key, mode 0600; the time stamps are kept beside it; empty: unsigned.
    allow_lan
        Whether the link may wait for vehicles beyond this machine.
    unsigned
        Whether a link beyond this machine may be without signatures: whoever reaches it can then
        command the vehicle and speak for it.
    geoid_separation_m
        Height of the geoid above the ellipsoid where it flies, metres; None: the drone tells.
    max_wind_mps, max_gust_mps
        Greatest mean wind and gust of a minute in which it flies, m/s, as its autopilot estimates
        them; 0: no limit.
    drives
        Whether it is a ground vehicle (ArduPilot Rover): it gets its ways by drive_route.
    on_wind
        What happens when they are exceeded in the air: ``warn`` (a return is offered) or
        ``return``.
    """

    name: str
    link: str
    system: int = 1
    component: int = 1
    speed_mps: float = 5.0
    hover_s: float = 1.0
    endurance_s: float = 1500.0
    image_folder: str = ''
    signing_key_file: str = ''
    allow_lan: bool = False
    unsigned: bool = False
    geoid_separation_m: float | None = None
    max_wind_mps: float = 0.0
    max_gust_mps: float = 0.0
    drives: bool = False
    on_wind: str = 'warn'

    def __post_init__(self) -> None:
        for name, value in (('system', self.system), ('component', self.component)):
            if not 1 <= value <= 255:
                raise ValueError(f'{name} is {value}: must be within 1 and 255')
        self._require_safe_link()
        require_positive('speed_mps', self.speed_mps, 'm/s')
        require_between('speed_mps', self.speed_mps, 0.0, LARGEST_SPEED_MPS, 'm/s')
        require_between('hover_s', self.hover_s, 0.0, LARGEST_HOVER_S, 's')
        require_positive('endurance_s', self.endurance_s, 's')
        require_between('max_wind_mps', self.max_wind_mps, 0.0, LARGEST_SPEED_MPS, 'm/s')
        require_between('max_gust_mps', self.max_gust_mps, 0.0, LARGEST_SPEED_MPS, 'm/s')
        if self.on_wind not in ON_WIND:
            raise ValueError(f'on_wind is {self.on_wind!r}: must be one of {", ".join(ON_WIND)}')
        if self.geoid_separation_m is not None:
            largest_m = LARGEST_SEPARATION_M
            require_between(
                'geoid_separation_m', self.geoid_separation_m, -largest_m, largest_m, 'm'
            )

    @property
    def target(self) -> tuple[int, int]:
        """(system, component)."""
        return self.system, self.component

    def _require_safe_link(self) -> None:
        """Refuse a link beyond this machine that was not allowed, or is open to everybody."""
        try:
            endpoint = parse_endpoint(self.link)
        except EndpointError as error:
            raise ValueError(str(error)) from error
        if self.unsigned and self.signing_key_file:
            raise ValueError('unsigned is true: signing_key_file must be left out')
        if endpoint.is_local:
            return
        if endpoint.is_listening and not self.allow_lan:
            raise ValueError(
                f'link {self.link!r} listens beyond this machine: set allow_lan: true to allow it '
                '(in a scenario: below drone)'
            )
        if not self.signing_key_file and not self.unsigned:
            raise ValueError(
                f'link {self.link!r} reaches beyond this machine: set signing_key_file, '
                'or unsigned: true to do without signatures (in a scenario: below drone)'
            )


@dataclass(frozen=True, slots=True, kw_only=True)
class DroneFleet:
    """All drones of the file; those on one link differ in their numbers and share their key."""

    drones: tuple[DroneOptions, ...]

    def __post_init__(self) -> None:
        for lines in (self._repeated_names(), self._repeated_targets(), self._different_keys()):
            for line in lines:
                raise ValueError(line)

    @property
    def links(self) -> tuple[str, ...]:
        """Each link once."""
        return tuple(dict.fromkeys(drone.link for drone in self.drones))

    def on(self, link: str) -> tuple[DroneOptions, ...]:
        """Return the drones on `link`."""
        return tuple(drone for drone in self.drones if drone.link == link)

    def _repeated_names(self) -> Iterator[str]:
        names = [drone.name for drone in self.drones]
        for name in sorted({name for name in names if names.count(name) > 1}):
            yield f'drones: {name} is named twice'

    def _repeated_targets(self) -> Iterator[str]:
        for link in self.links:
            targets = [drone.target for drone in self.on(link)]
            if len(set(targets)) < len(targets):
                yield f'drones on {link} must differ in system or component'

    def _different_keys(self) -> Iterator[str]:
        for link in self.links:
            if len({drone.signing_key_file for drone in self.on(link)}) > 1:
                yield f'drones on {link} must have one signing_key_file'
            if len({drone.unsigned for drone in self.on(link)}) > 1:
                yield f'drones on {link} must have one value of unsigned'


def read_drones(path: str) -> DroneFleet:
    """Return the drones that the file at `path` describes.

    Raises
    ------
    ValueError
        With one line for each mistake; a path that is empty is one.
    """
    if not path:
        raise ValueError('drones_file is empty: must name the YAML file of the drones')
    return read_values(Path(path), DroneFleet)
