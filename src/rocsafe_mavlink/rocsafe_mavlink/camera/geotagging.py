# SPDX-License-Identifier: Apache-2.0
"""From camera triggers and images to geotagged photographs, and a table of the triggers."""

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
# Reports take less time; clocks that differ by more were not set by the same source.
SET_ALIKE_S = 5.0


@dataclass(frozen=True, slots=True, kw_only=True)
class GeotagContext:
    """What a photograph takes from its vehicle.

    Attributes
    ----------
    vehicle
        Name of the vehicle.
    assignment
        Plan that it flies; None: none.
    gps
        Quality of its position.
    clock_s
        Time of the mission less the time of day.
    """

    vehicle: str
    assignment: Assignment | None
    gps: Gps
    clock_s: float


class Geotagger:
    """Makes geotagged photographs for one vehicle.

    Parameters
    ----------
    numbering
        Numbers and keeps the photographs.
    source
        Source of the images; None: there are none, and triggers are only counted.
    table
        CSV file of the triggers; None: none is written.
    """

    def __init__(
        self, numbering: ShotNumbering, source: ImageSource | None, table: Path | None
    ) -> None:
        self.numbering = numbering
        self._source = source
        self._table = table
        self._log = TriggerLog()
        self._pairing = ImagePairing()
        self._waiting: list[tuple[CameraTrigger, float]] = []
        self.shot_count = 0

    @property
    def delivered(self) -> int:
        """Number of photographs that are, or will be, in the image store."""
        return self.numbering.next_sequence

    def on_message(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float
    ) -> list[CameraTrigger]:
        """Take a message of the vehicle; return the triggers that it reports."""
        triggers = self._log.take(message, vehicle, unix_s)
        self.shot_count += len(triggers)
        self._waiting += [(trigger, unix_s) for trigger in triggers]
        for trigger in triggers:
            self._write_row(trigger)
        return triggers

    def tagged(self, context: GeotagContext, refuse: Callable[[str], None]) -> list[Shot]:
        """Return the photographs whose image and trigger have both come since; they are kept.

        `refuse` is called with a line for one that cannot be kept, whose image stays where the
        camera wrote it, and for a trigger for which a stream has no image.
        """
        if self._source is None:
            self._waiting.clear()
            return []
        made = []
        for pair in self._pairs(self._source, context.vehicle, refuse):
            photograph = self._photograph(pair, context)
            if photograph is None:
                refuse(f'{context.vehicle}: {pair.image.name} is no image')
                continue
            try:
                self.numbering.add(photograph)
                made.append(photograph)
            except SpoolError as error:
                refuse(f'{context.vehicle}: {pair.image.name} is not sent: {error}')
        return made

    def _pairs(
        self, source: ImageSource, vehicle: str, refuse: Callable[[str], None]
    ) -> list[ImagePair]:
        new, self._waiting = self._waiting, []
        if not source.is_stream:
            return self._pairing.add([trigger for trigger, _ in new], source.take())
        pairs = []
        for trigger, arrived_s in new:
            image = source.at(_moment_of(trigger, arrived_s))
            if image is None:
                refuse(
                    f'{vehicle}: shot {trigger.index} has no picture: the camera sent none then'
                )
            else:
                pairs.append(ImagePair(trigger, image))
        return pairs

    def close(self) -> None:
        """Close the source."""
        if self._source is not None:
            self._source.close()

    def _photograph(self, pair: ImagePair, context: GeotagContext) -> Shot | None:
        size = _size_of(pair.image.jpeg)
        if size is None:
            return None
        trigger, attitude = pair.trigger, pair.trigger.attitude
        angles = (0.0, 0.0, 0.0)
        if attitude is not None:
            angles = (attitude.yaw_rad, attitude.pitch_rad, attitude.roll_rad)
        x, y, z, w = quaternion_of_rotation(rotation_enu_from_optical(*angles)).tolist()
        return Shot(
            vehicle=context.vehicle,
            sequence=self.numbering.next_sequence,
            viewpoint_id=viewpoint_of(trigger, context.assignment),
            time_ns=round((trigger.unix_s + context.clock_s) * NS_PER_S),
            position=trigger.position,
            horizontal_std_m=context.gps.horizontal_std_m,
            vertical_std_m=context.gps.vertical_std_m,
            height_m=trigger.height_m,
            quaternion_xyzw=(x, y, z, w),
            width_px=size[0],
            height_px=size[1],
            jpeg=pair.image.jpeg,
        )

    def _write_row(self, trigger: CameraTrigger) -> None:
        if self._table is None:
            return
        is_new = not self._table.exists()
        self._table.parent.mkdir(parents=True, exist_ok=True)
        attitude = trigger.attitude
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
            place = trigger.position
            writer.writerow(
                [
                    trigger.index,
                    f'{trigger.unix_s:.3f}',
                    f'{place.latitude_deg:.7f}',
                    f'{place.longitude_deg:.7f}',
                    f'{place.altitude_m:.3f}',
                    f'{trigger.height_m:.3f}',
                    *angles,
                    trigger.source,
                    int(trigger.is_interpolated),
                ]
            )


def _moment_of(trigger: CameraTrigger, arrived_s: float) -> float:
    """Return the time of a trigger by our clock: the autopilot's clock may never have been set."""
    return trigger.unix_s if abs(trigger.unix_s - arrived_s) < SET_ALIKE_S else arrived_s


def viewpoint_of(trigger: CameraTrigger, assignment: Assignment | None) -> int:
    """Return the viewpoint of the plan that is nearest to a trigger; 0 without a plan."""
    if assignment is None:
        return 0
    stops = zip(assignment.viewpoint_ids, assignment.plan.stops, strict=True)
    return min(stops, key=lambda stop: distance_m(trigger.position, stop[1].position))[0]


def _size_of(jpeg: bytes) -> tuple[int, int] | None:
    """Return width and height of an image from its header; None if it is no image."""
    try:
        with Image.open(io.BytesIO(jpeg)) as opened:
            return int(opened.width), int(opened.height)
    except (OSError, SyntaxError):
        return None
