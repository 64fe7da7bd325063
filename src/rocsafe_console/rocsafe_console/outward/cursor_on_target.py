# SPDX-License-Identifier: Apache-2.0
"""Cursor on Target events (MITRE MTR 04W0000010, version 2.0), which ATAK and WinTAK show.

Heights are above the WGS84 ellipsoid, as all altitudes of the project, so that nothing is
converted.
"""

import math
import re
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from datetime import datetime, timezone
from typing import Any
from xml.etree import ElementTree as Xml

from rocsafe_console.picture.picture import Picture
from rocsafe_console.picture.sections import placed
from rocsafe_view import formats

# What the standard has for an unknown error or height.
UNKNOWN_M = 9_999_999.0
ROTARY_UAV, GROUND_VEHICLE = 'a-f-A-M-H-Q', 'a-f-G-E-V'
SPOT, SHAPE = 'b-m-p-s-m', 'u-d-f'
# How a place came about: by a receiver, by a simulation, of many readings, by a person's click.
BY_GPS, SIMULATED, FUSED, BY_HAND = 'm-g', 'm-s', 'm-f', 'h-e'
# Errors are told as one deviation of a normal distribution in the plane, whose 95 % lie within:
SIGMAS_OF_95 = math.sqrt(-2.0 * math.log(0.05))
# A red line without a filling, as signed 32 bits of alpha, red, green and blue.
RED, CLEAR, LINE_WEIGHT = '-65536', '0', '3.0'
PERIOD_S = 1.0
# Three periods without an event: the receiver shows it as old.
STALE_S = 3.0 * PERIOD_S
LASTING_STALE_S = 60.0
# A datagram is not to be cut into pieces.
MOST_POINTS = 24
MULTICAST = ('239.2.3.1', 6969)
# What XML 1.0 cannot hold, not even escaped: a receiver would close the connection.
_NOT_XML = re.compile('[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]')


@dataclass(frozen=True, slots=True, kw_only=True)
class Event:
    """One event: who, what, where, until when.

    Attributes
    ----------
    circular_error_m
        One deviation of the place in each horizontal direction, metres; nan: not known.
    is_simulated
        Whether there is nothing but in a simulation.
    """

    uid: str
    kind: str
    callsign: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float = math.nan
    circular_error_m: float = math.nan
    how: str = FUSED
    is_simulated: bool = False
    stale_s: float = STALE_S
    remarks: str = ''
    ring: tuple[tuple[float, float], ...] = field(default=())

    def to_xml(self, now_s: float) -> bytes:
        """Return the event as it is at `now_s`, seconds since 1970."""
        times = {'time': _time(now_s), 'start': _time(now_s), 'stale': _time(now_s + self.stale_s)}
        named = {'version': '2.0', 'uid': _xml(self.uid), 'type': self.kind, 'how': self.how}
        operation = {'opex': 's'} if self.is_simulated else {}
        event = Xml.Element('event', {**named, **operation, **times})
        Xml.SubElement(
            event,
            'point',
            lat=f'{self.latitude_deg:.7f}',
            lon=f'{self.longitude_deg:.7f}',
            hae=f'{_known(self.altitude_m):.1f}',
            ce=f'{_known(self.circular_error_m):.1f}',
            le=f'{UNKNOWN_M:.1f}',
        )
        detail = Xml.SubElement(event, 'detail')
        for latitude, longitude in self.ring:
            Xml.SubElement(detail, 'link', point=f'{latitude:.7f},{longitude:.7f}')
        if self.ring:
            Xml.SubElement(detail, 'strokeColor', value=RED)
            Xml.SubElement(detail, 'strokeWeight', value=LINE_WEIGHT)
            Xml.SubElement(detail, 'fillColor', value=CLEAR)
        Xml.SubElement(detail, 'contact', callsign=_xml(self.callsign))
        if self.remarks:
            Xml.SubElement(detail, 'remarks').text = _xml(self.remarks)
        if self.ring:
            Xml.SubElement(detail, 'labels_on', value='true')
        return bytes(Xml.tostring(event, encoding='utf-8', xml_declaration=True))


def events_of(picture: Picture, now_s: float) -> list[Event]:
    """Return an event of each vehicle that is alive, each source, release, zone and mark."""
    mission = picture.mission.mission_id if picture.mission else 'none'
    prefix = f'rocsafe.{mission}'
    found = [
        *_sources(picture, prefix),
        *_releases(picture, prefix),
        *_cordons(picture, prefix),
        *_zones(picture, prefix),
        *_marks(picture, prefix),
    ]
    vehicles = picture.vehicles.values()
    # What simulated vehicles have found is not there.
    is_simulated = bool(vehicles) and all(one.report.is_simulated for one in vehicles)
    return [
        *_vehicles(picture, prefix, now_s),
        *(replace(event, is_simulated=is_simulated) for event in found),
    ]


def _vehicles(picture: Picture, prefix: str, now_s: float) -> Iterator[Event]:
    for vehicle in picture.vehicles.values():
        # Nothing old is sent: the receiver would take it for new.
        if now_s - vehicle.placed_s <= STALE_S:
            rate = formats.spaced(formats.dose_rate(vehicle.dose_rate_now(now_s)))
            is_simulated = vehicle.report.is_simulated
            yield Event(
                uid=f'{prefix}.{vehicle.name}',
                kind=GROUND_VEHICLE if vehicle.report.is_ground else ROTARY_UAV,
                callsign=vehicle.name,
                latitude_deg=vehicle.latitude_deg,
                longitude_deg=vehicle.longitude_deg,
                altitude_m=vehicle.altitude_m,
                how=SIMULATED if is_simulated else BY_GPS,
                is_simulated=is_simulated,
                remarks=f'{vehicle.report.state_name}, {rate}{", simulated" * is_simulated}',
            )


def _sources(picture: Picture, prefix: str) -> Iterator[Event]:
    found = picture.sections.value('sources') or {}
    for one in placed(found.get('sources', [])):
        strength = formats.spaced(formats.dose_rate(one['dose_rate_at_1m_usvh']))
        size_m = max(map(_number, one['half_axes_m']))
        where = f'95 % within {formats.figures(size_m, 2)} m'
        yield Event(
            uid=f'{prefix}.source.{one["id"]}',
            kind=SPOT,
            callsign=f'source {one["id"]}',
            latitude_deg=one['place'][0],
            longitude_deg=one['place'][1],
            circular_error_m=size_m / SIGMAS_OF_95,
            stale_s=LASTING_STALE_S,
            remarks=f'{strength} at 1 m, with {one["probability"]}, {where}; '
            f'{_made(found.get("heard_s"))}',
        )


def _releases(picture: Picture, prefix: str) -> Iterator[Event]:
    found = picture.sections.value('releases') or {}
    for one in placed(found.get('releases', [])):
        rate = f'{formats.figures(_number(one["rate"]), 2)} {found["rate_unit"]}'
        size_m = _number(one['radius_95_m'])
        where = f'95 % within {formats.figures(size_m, 2)} m'
        yield Event(
            uid=f'{prefix}.release.{one["id"]}',
            kind=SPOT,
            callsign=f'release {one["id"]}',
            latitude_deg=one['place'][0],
            longitude_deg=one['place'][1],
            circular_error_m=size_m / SIGMAS_OF_95,
            stale_s=LASTING_STALE_S,
            remarks=f'{rate} of {found["agent"]}, {where}; {_made(found.get("heard_s"))}',
        )


def _cordons(picture: Picture, prefix: str) -> Iterator[Event]:
    for number, one in enumerate(picture.sections.value('cordons') or [], 1):
        level = formats.spaced(formats.dose_rate(one['level_usvh']))
        made = _made(picture.sections.value('cordons_heard_s'))
        remarks = f'upper 95 % of the dose rate; {made}'
        yield from _shape(one, f'{prefix}.cordon.{number}', f'cordon {level}', remarks)


def _zones(picture: Picture, prefix: str) -> Iterator[Event]:
    remarks = f'outer bound of 95 %; {_made(picture.sections.value("zones_heard_s"))}'
    for number, one in enumerate(picture.sections.value('zones') or [], 1):
        yield from _shape(one, f'{prefix}.zone.{number}', one['level'], remarks)


def _shape(line: Mapping[str, Any], uid: str, callsign: str, remarks: str) -> Iterator[Event]:
    """Yield the event of a line around ground, unless it is that of the mean."""
    corners = [(place[0], place[1]) for place in line['ring'] if None not in place]
    if line['is_mean'] or len(corners) < 3:
        return
    ring = (*corners[:: math.ceil(len(corners) / MOST_POINTS)], corners[-1])
    yield Event(
        uid=uid,
        kind=SHAPE,
        callsign=callsign,
        latitude_deg=ring[0][0],
        longitude_deg=ring[0][1],
        stale_s=LASTING_STALE_S,
        remarks=remarks,
        ring=ring,
    )


def _marks(picture: Picture, prefix: str) -> Iterator[Event]:
    for number, one in enumerate(picture.sections.value('marks') or [], 1):
        yield Event(
            uid=f'{prefix}.mark.{number}',
            kind=SPOT,
            callsign=one['text'][:40],
            latitude_deg=one['latitude_deg'],
            longitude_deg=one['longitude_deg'],
            how=BY_HAND,
            stale_s=LASTING_STALE_S,
            remarks=f'{one["text"]} ({one["by"]})',
        )


def _made(heard_s: float | None) -> str:
    """Return when an estimate was made, in words: it is sent until there is another one."""
    if heard_s is None:
        return 'estimated, nobody knows when'
    return f'estimated at {datetime.fromtimestamp(heard_s, tz=timezone.utc):%H:%M:%S} UTC'


def _number(value: float | None) -> float:
    return math.nan if value is None else value


def _xml(text: str) -> str:
    return _NOT_XML.sub('\ufffd', text)


def _known(value: float) -> float:
    return value if math.isfinite(value) else UNKNOWN_M


def _time(seconds: float) -> str:
    at = datetime.fromtimestamp(seconds, tz=timezone.utc)
    return f'{at:%Y-%m-%dT%H:%M:%S}.{at.microsecond // 1000:03d}Z'
