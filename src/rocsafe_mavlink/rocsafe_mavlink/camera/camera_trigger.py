# SPDX-License-Identifier: Apache-2.0
"""Photographs as autopilots report them: three messages, one value.

CAMERA_IMAGE_CAPTURED comes from a camera, CAMERA_FEEDBACK from an autopilot that saw its shutter,
CAMERA_TRIGGER from one that only pulled it. Where better ones come, the others are not counted.
Reports that were lost on the way are filled in from the track, and marked.
"""

import math
from collections import deque
from dataclasses import dataclass

from rocsafe_geo.angle import wrap_rad, yaw_of_heading_rad
from rocsafe_geo.position import GeoPosition
from rocsafe_mavlink.knowledge.telemetry import Attitude, VehicleTelemetry
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.units import m_of_mm, position_of_e7

TRIGGER, FEEDBACK, CAPTURED = 'CAMERA_TRIGGER', 'CAMERA_FEEDBACK', 'CAMERA_IMAGE_CAPTURED'
RANKS = {TRIGGER: 1, FEEDBACK: 2, CAPTURED: 3}
# A gap wider than this is another count, not a loss.
LARGEST_GAP = 50
TRACK_LENGTH = 1200
# Before it a time of day is none.
EARLIEST_UNIX_S = 1e9


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraTrigger:
    """One photograph.

    Attributes
    ----------
    index: as the camera counts.
    unix_s: time of day of the exposure.
    position: altitude above the ellipsoid, NaN if not known.
    height_m: above home.
    attitude: of the vehicle; None if it was not told.
    source: message that reported it.
    is_interpolated: whether no report came, and it is taken from the track.
    """

    index: int
    unix_s: float
    position: GeoPosition
    height_m: float
    attitude: Attitude | None
    source: str
    is_interpolated: bool = False


class TriggerLog:
    """Makes shots of the messages of one vehicle, each index once and in order."""

    def __init__(self) -> None:
        self._rank = 0
        self._last: CameraTrigger | None = None
        self._track: deque[tuple[float, GeoPosition, float, Attitude | None]] = deque(
            maxlen=TRACK_LENGTH
        )

    def take(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float
    ) -> list[CameraTrigger]:
        """Take a message that came at `unix_s`; return the shots that it tells of."""
        motion = vehicle.motion
        if message.name == 'GLOBAL_POSITION_INT' and motion is not None:
            place = (unix_s, motion.position, motion.height_above_home_m, vehicle.attitude)
            self._track.append(place)
        rank = RANKS.get(message.name, 0)
        if not rank or rank < self._rank:
            return []
        self._rank = rank
        shot = self._shot(message, vehicle, unix_s)
        last = self._last
        if shot is None or (last is not None and 0 <= last.index - shot.index < LARGEST_GAP):
            return []
        self._last = shot
        return [*self._missing(last, shot), shot]

    def _shot(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float
    ) -> CameraTrigger | None:
        if message.name == FEEDBACK:
            return self._of_feedback(message, vehicle, unix_s)
        if message.name == CAPTURED:
            return self._of_captured(message, vehicle, unix_s)
        taken_s = _time_of_day(message['time_usec'] / 1e6, unix_s)
        return self._at(taken_s, int(message['seq']), TRIGGER)

    def _of_feedback(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float
    ) -> CameraTrigger | None:
        index = int(message['img_idx'])
        taken_s = _time_of_day(message['time_usec'] / 1e6, unix_s)
        if not message['lat'] and not message['lng']:
            return self._at(taken_s, index, FEEDBACK)
        altitude_m = message['alt_msl'] + vehicle.geoid_separation_m
        heading_rad = math.radians(message['yaw'])
        return CameraTrigger(
            index=index,
            unix_s=taken_s,
            position=position_of_e7(message['lat'], message['lng'], altitude_m),
            height_m=message['alt_rel'],
            attitude=Attitude(
                roll_rad=math.radians(message['roll']),
                pitch_rad=-math.radians(message['pitch']),
                yaw_rad=wrap_rad(yaw_of_heading_rad(heading_rad)),
            ),
            source=FEEDBACK,
        )

    def _of_captured(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float
    ) -> CameraTrigger | None:
        if message['capture_result'] != 1:
            return None
        altitude_m = m_of_mm(message['alt']) + vehicle.geoid_separation_m
        return CameraTrigger(
            index=int(message['image_index']),
            unix_s=_time_of_day(message['time_utc'] / 1e6, unix_s),
            position=position_of_e7(message['lat'], message['lon'], altitude_m),
            height_m=m_of_mm(message['relative_alt']),
            attitude=vehicle.attitude,
            source=CAPTURED,
        )

    def _missing(self, last: CameraTrigger | None, shot: CameraTrigger) -> list[CameraTrigger]:
        """Return the shots between two reports, evenly spread over the time between them."""
        count = 0 if last is None else shot.index - last.index
        if last is None or not 1 < count < LARGEST_GAP:
            return []
        found = []
        for number in range(1, count):
            unix_s = last.unix_s + (shot.unix_s - last.unix_s) * number / count
            filled = self._at(unix_s, last.index + number, shot.source, is_interpolated=True)
            found += [] if filled is None else [filled]
        return found

    def _at(
        self, unix_s: float, index: int, source: str, *, is_interpolated: bool = False
    ) -> CameraTrigger | None:
        """Return a shot where the track was at `unix_s`; None if there is no track."""
        if not self._track:
            return None
        before = max(
            (place for place in self._track if place[0] <= unix_s),
            key=lambda place: place[0],
            default=self._track[0],
        )
        after = min(
            (place for place in self._track if place[0] >= unix_s),
            key=lambda place: place[0],
            default=before,
        )
        span_s = after[0] - before[0]
        share = 0.0 if span_s <= 0.0 else (unix_s - before[0]) / span_s
        return CameraTrigger(
            index=index,
            unix_s=unix_s,
            position=_between(before[1], after[1], share),
            height_m=before[2] + share * (after[2] - before[2]),
            attitude=before[3],
            source=source,
            is_interpolated=is_interpolated,
        )


def _time_of_day(told_s: float, arrived_s: float) -> float:
    """Return when a shot was taken: as told, or as it arrived where only the uptime is told."""
    return told_s if told_s > EARLIEST_UNIX_S else arrived_s


def _between(a: GeoPosition, b: GeoPosition, share: float) -> GeoPosition:
    return GeoPosition(
        a.latitude_deg + share * (b.latitude_deg - a.latitude_deg),
        a.longitude_deg + share * (b.longitude_deg - a.longitude_deg),
        a.altitude_m + share * (b.altitude_m - a.altitude_m),
    )
