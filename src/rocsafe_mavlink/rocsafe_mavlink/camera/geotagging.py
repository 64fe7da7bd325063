# SPDX-License-Identifier: Apache-2.0
"""From shots and pictures to photographs of a plan, and a table of the shots of each flight."""

import csv
import io
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_optical
from rocsafe_geo.position import distance_m
from rocsafe_geo.storage.shot import Shot
from rocsafe_geo.storage.shot_store import SpoolError
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mavlink.camera.camera_trigger import CameraTrigger, TriggerLog
from rocsafe_mavlink.camera.numbering import ShotNumbering
from rocsafe_mavlink.camera.pairing import ImagePair, ImagePairing
from rocsafe_mavlink.camera.source import ImageSource
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.knowledge.telemetry import Gps, VehicleTelemetry
from rocsafe_mavlink.wire.dialect import Message

COLUMNS = ('index', 'unix_s', 'latitude_deg', 'longitude_deg', 'altitude_ellipsoid_m',
           'height_above_home_m', 'roll_rad', 'pitch_rad', 'yaw_rad', 'source',
           'is_interpolated')  # fmt: skip
# A report is under way for less; clocks that differ by more are not set by the same source.
SET_ALIKE_S = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class GeotagContext:
    """What a photograph takes from its vehicle at the moment.

    Attributes
    ----------
    vehicle: its name.
    assignment: the plan it flies; None: none.
    gps: how good its position is.
    clock_s: time of the mission less the time of day.
    """

    vehicle: str
    assignment: Assignment | None
    gps: Gps
    clock_s: float


class Geotagger:
    """Follows the camera of one vehicle.

    Parameters
    ----------
    film: numbers and keeps the photographs.
    source: where the pictures come from; None: there are none, only shots are counted.
    table: CSV file of the shots; None: none is written.
    """

    def __init__(
        self, film: ShotNumbering, source: ImageSource | None, table: Path | None
    ) -> None:
        self.film = film
        self._source = source
        self._table = table
        self._log = TriggerLog()
        self._pairing = ImagePairing()
        self._new: list[tuple[CameraTrigger, float]] = []
        self.shot_count = 0

    @property
    def delivered(self) -> int:
        """Photographs that are, or will be, in the image store."""
        return self.film.next_sequence

    def on_message(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float
    ) -> list[CameraTrigger]:
        """Take a message of the vehicle; return the shots that it tells of."""
        shots = self._log.take(message, vehicle, unix_s)
        self.shot_count += len(shots)
        self._new += [(shot, unix_s) for shot in shots]
        for shot in shots:
            self._note(shot)
        return shots

    def develop(self, exposure: GeotagContext, refuse: Callable[[str], None]) -> list[Shot]:
        """Return the photographs whose picture and shot are both here now; they are kept.

        One that cannot be kept is told to `refuse`: its picture stays where the camera wrote it.
        So is a shot of which a stream has no frame.
        """
        if self._source is None:
            self._new.clear()
            return []
        made = []
        for pair in self._pairs(self._source, exposure.vehicle, refuse):
            photograph = self._photograph(pair, exposure)
            if photograph is None:
                refuse(f'{exposure.vehicle}: {pair.picture.name} is no image')
                continue
            try:
                self.film.add(photograph)
                made.append(photograph)
            except SpoolError as error:
                refuse(f'{exposure.vehicle}: {pair.picture.name} is not sent: {error}')
        return made

    def _pairs(
        self, source: ImageSource, vehicle: str, refuse: Callable[[str], None]
    ) -> list[ImagePair]:
        new, self._new = self._new, []
        if not source.is_stream:
            return self._pairing.add([shot for shot, _ in new], source.take())
        pairs = []
        for shot, arrived_s in new:
            picture = source.at(_moment_of(shot, arrived_s))
            if picture is None:
                refuse(f'{vehicle}: shot {shot.index} has no picture: the camera sent none then')
            else:
                pairs.append(ImagePair(shot, picture))
        return pairs

    def close(self) -> None:
        """Give the source back."""
        if self._source is not None:
            self._source.close()

    def _photograph(self, pair: ImagePair, exposure: GeotagContext) -> Shot | None:
        size = _size_of(pair.picture.jpeg)
        if size is None:
            return None
        shot, attitude = pair.shot, pair.shot.attitude
        angles = (0.0, 0.0, 0.0)
        if attitude is not None:
            angles = (attitude.yaw_rad, attitude.pitch_rad, attitude.roll_rad)
        x, y, z, w = quaternion_of_rotation(rotation_enu_from_optical(*angles)).tolist()
        return Shot(
            vehicle=exposure.vehicle,
            sequence=self.film.next_sequence,
            viewpoint_id=viewpoint_of(shot, exposure.assignment),
            time_ns=round((shot.unix_s + exposure.clock_s) * NS_PER_S),
            position=shot.position,
            horizontal_std_m=exposure.gps.horizontal_std_m,
            vertical_std_m=exposure.gps.vertical_std_m,
            height_m=shot.height_m,
            quaternion_xyzw=(x, y, z, w),
            width_px=size[0],
            height_px=size[1],
            jpeg=pair.picture.jpeg,
        )

    def _note(self, shot: CameraTrigger) -> None:
        if self._table is None:
            return
        is_new = not self._table.exists()
        self._table.parent.mkdir(parents=True, exist_ok=True)
        attitude = shot.attitude
        angles = ('', '', '')
        if attitude is not None:
            angles = tuple(  # type: ignore[assignment]
                f'{angle:.5f}'
                for angle in (attitude.roll_rad, attitude.pitch_rad, attitude.yaw_rad)
            )
        with self._table.open('a', encoding='utf-8', newline='') as file:
            writer = csv.writer(file)
            if is_new:
                writer.writerow(COLUMNS)
            place = shot.position
            writer.writerow(
                [
                    shot.index,
                    f'{shot.unix_s:.3f}',
                    f'{place.latitude_deg:.7f}',
                    f'{place.longitude_deg:.7f}',
                    f'{place.altitude_m:.3f}',
                    f'{shot.height_m:.3f}',
                    *angles,
                    shot.source,
                    int(shot.is_interpolated),
                ]
            )


def _moment_of(shot: CameraTrigger, arrived_s: float) -> float:
    """Return when a shot was taken by our clock: an autopilot's may never have been set."""
    return shot.unix_s if abs(shot.unix_s - arrived_s) < SET_ALIKE_S else arrived_s


def viewpoint_of(shot: CameraTrigger, assignment: Assignment | None) -> int:
    """Return the viewpoint of the plan that a shot was taken nearest to; 0 without a plan."""
    if assignment is None:
        return 0
    stops = zip(assignment.viewpoint_ids, assignment.plan.stops, strict=True)
    return min(stops, key=lambda stop: distance_m(shot.position, stop[1].position))[0]


def _size_of(jpeg: bytes) -> tuple[int, int] | None:
    """Return width and height of an image file, from its head; None if it is none."""
    try:
        with Image.open(io.BytesIO(jpeg)) as image:
            return int(image.width), int(image.height)
    except (OSError, SyntaxError):
        return None
