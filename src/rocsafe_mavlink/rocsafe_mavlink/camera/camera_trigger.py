# SPDX-License-Identifier: Apache-2.0
"""Camera triggers as autopilots report them: three messages, one value.

CAMERA_IMAGE_CAPTURED comes from a camera, CAMERA_FEEDBACK from an autopilot that saw the shutter,
CAMERA_TRIGGER from one that only triggered it. Where better ones come, the others are not counted.
Reports that were lost are filled in from the track, and marked.
"""

import math
from collections import deque
from dataclasses import dataclass, replace

from rocsafe_geo.angle import wrap_rad, yaw_of_heading_rad
from rocsafe_geo.position import GeoPosition, distance_m
from rocsafe_mavlink.knowledge.telemetry import Attitude, VehicleTelemetry
from rocsafe_mavlink.wire.dialect import Message
from rocsafe_mavlink.wire.units import m_of_mm, position_of_e7

TRIGGER, FEEDBACK, CAPTURED = 'CAMERA_TRIGGER', 'CAMERA_FEEDBACK', 'CAMERA_IMAGE_CAPTURED'
# Source and number of a trigger that is known only from its image.
IMAGE, NO_INDEX = 'IMAGE', -1
# Time of day, position, height above home, attitude.
Place = tuple[float, GeoPosition, float, Attitude | None]
RANKS = {TRIGGER: 1, FEEDBACK: 2, CAPTURED: 3}


@dataclass(frozen=True, slots=True, kw_only=True)
class TriggerOptions:
    """Options of filling in reports that were lost.

    Attributes
    ----------
    largest_gap
        A larger gap in the numbers means that the camera counts anew, not a loss.
    track_length
        Number of places of the track that are kept.
    earliest_unix_s
        An earlier time of day comes from a clock that was never set.
    dense_track_s
        Between places of the track that are nearer in time, the path is known well, seconds.
    largest_gap_m, largest_turn_rad
        Between two places that are farther apart, or whose yaw differs by more, no place is
        interpolated.
    """

    largest_gap: int = 50
    track_length: int = 1200
    earliest_unix_s: float = 1e9
    dense_track_s: float = 2.0
    largest_gap_m: float = 60.0
    largest_turn_rad: float = 0.2


TRIGGERS = TriggerOptions()


@dataclass(frozen=True, slots=True, kw_only=True)
class CameraTrigger:
    """One photograph that was taken.

    Attributes
    ----------
    index
        Number by the camera's count.
    unix_s
        Time of day of the exposure.
    position
        Altitude above the ellipsoid, NaN if not known.
    height_m
        Height above home.
    attitude
        Attitude of the vehicle; None if it was not told.
    source
        Name of the message that reported it.
    is_interpolated
        Whether no report came and it is filled in from the track.
    position_std_m
        Standard deviation of the position beside that of the receiver: half of the way between
        the two known places around it, where the track has a gap.
    reported_s
        Time of day by our clock at which it was reported; NaN: not known.
    """

    index: int
    unix_s: float
    position: GeoPosition
    height_m: float
    attitude: Attitude | None
    source: str
    is_interpolated: bool = False
    position_std_m: float = 0.0
    reported_s: float = math.nan


class TriggerLog:
    """Collects the camera triggers of one vehicle, each index once and in order.

    Parameters
    ----------
    last
        Last trigger that an earlier process took; None: there was none.
    """

    def __init__(self, last: CameraTrigger | None = None) -> None:
        self._rank = 0
        self._last = last
        self._track: deque[Place] = deque(maxlen=TRIGGERS.track_length)
        if last is not None:
            self._track.append((last.unix_s, last.position, last.height_m, last.attitude))

    @property
    def newest_s(self) -> float:
        """Time of the last place of the track, 0 before the first."""
        return self._track[-1][0] if self._track else 0.0

    def found(self, unix_s: float, index: int = NO_INDEX) -> CameraTrigger | None:
        """Return the trigger of an image without a report, from its time only.

        None where place and direction are unknown: not between two known places, or
        these are too far apart, or the vehicle has turned between them.
        """
        if not self._track or not self._track[0][0] <= unix_s <= self.newest_s:
            return None
        before, after = self._around(unix_s)
        is_gap = after[0] - before[0] > TRIGGERS.dense_track_s
        if is_gap and distance_m(before[1], after[1]) > TRIGGERS.largest_gap_m:
            return None
        if is_gap and self._has_turned(before, after):
            return None
        return self._at(unix_s, index, IMAGE, is_interpolated=True)

    def take(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float
    ) -> list[CameraTrigger]:
        """Take a message that came at `unix_s`; return the triggers that it reports."""
        motion = vehicle.motion
        if message.name == 'GLOBAL_POSITION_INT' and motion is not None:
            place = (unix_s, motion.position, motion.height_above_home_m, vehicle.attitude)
            self._track.append(place)
        rank = RANKS.get(message.name, 0)
        if not rank or rank < self._rank:
            return []
        self._rank = rank
        trigger = self._trigger(message, vehicle, unix_s)
        last = self._last
        if trigger is None or (
            last is not None and 0 <= last.index - trigger.index < TRIGGERS.largest_gap
        ):
            return []
        self._last = trigger
        return [*self._missing(last, trigger), replace(trigger, reported_s=unix_s)]

    def _trigger(
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

    def _missing(self, last: CameraTrigger | None, trigger: CameraTrigger) -> list[CameraTrigger]:
        """Return the triggers between two reports, evenly spread over the time between them."""
        count = 0 if last is None else trigger.index - last.index
        if last is None or not 1 < count < TRIGGERS.largest_gap:
            return []
        found = []
        for number in range(1, count):
            unix_s = last.unix_s + (trigger.unix_s - last.unix_s) * number / count
            filled = self._at(unix_s, last.index + number, trigger.source, is_interpolated=True)
            found += [] if filled is None else [filled]
        return found

    def _at(
        self, unix_s: float, index: int, source: str, *, is_interpolated: bool = False
    ) -> CameraTrigger | None:
        """Return a trigger where the track was at `unix_s`; None if there is no track."""
        if not self._track:
            return None
        before, after = self._around(unix_s)
        span_s = after[0] - before[0]
        gap_m = distance_m(before[1], after[1]) if span_s > TRIGGERS.dense_track_s else 0.0
        share = 0.0 if span_s <= 0.0 else (unix_s - before[0]) / span_s
        return CameraTrigger(
            index=index,
            unix_s=unix_s,
            position=_between(before[1], after[1], share),
            height_m=before[2] + share * (after[2] - before[2]),
            attitude=before[3],
            source=source,
            is_interpolated=is_interpolated,
            position_std_m=0.5 * gap_m,
        )

    def _has_turned(self, before: Place, after: Place) -> bool:
        """Return whether the yaw changes over a gap, or is unknown."""
        later = (place[3] for place in self._track if place[0] >= after[0])
        attitude = next((known for known in later if known is not None), None)
        if before[3] is None or attitude is None:
            return True
        return abs(wrap_rad(attitude.yaw_rad - before[3].yaw_rad)) > TRIGGERS.largest_turn_rad

    def _around(self, unix_s: float) -> tuple[Place, Place]:
        """Return the places of the track before and after a time; the nearest at its ends."""
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
        return before, after


def _time_of_day(told_s: float, arrived_s: float) -> float:
    """Return the time of a trigger: as reported, or its arrival if only the uptime is reported."""
    return told_s if told_s > TRIGGERS.earliest_unix_s else arrived_s


def _between(a: GeoPosition, b: GeoPosition, share: float) -> GeoPosition:
    return GeoPosition(
        a.latitude_deg + share * (b.latitude_deg - a.latitude_deg),
        a.longitude_deg + share * (b.longitude_deg - a.longitude_deg),
        a.altitude_m + share * (b.altitude_m - a.altitude_m),
    )
