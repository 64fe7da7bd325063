# SPDX-License-Identifier: Apache-2.0
"""Geotagged photographs, made of camera triggers and images."""

import io
import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

from PIL import Image

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_optical
from rocsafe_geo.position import distance_m
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_mavlink.camera.camera_trigger import CameraTrigger, TriggerLog
from rocsafe_mavlink.camera.numbering import ShotNumbering
from rocsafe_mavlink.camera.pairing import ImagePair, ImagePairing
from rocsafe_mavlink.camera.picture_journal import SHOTS, PictureJournal
from rocsafe_mavlink.camera.source import ImageSource
from rocsafe_mavlink.flight.flight_journal import Assignment
from rocsafe_mavlink.knowledge.telemetry import Gps, VehicleTelemetry
from rocsafe_mavlink.wire.dialect import Message


@dataclass(frozen=True, slots=True, kw_only=True)
class GeotagOptions:
    """Options of finding images and triggers that have no partner.

    Attributes
    ----------
    late_s
        A trigger is reported within this time, seconds. An image without such a report is
        placed by its own time.
    settled_s
        Images and triggers that have no partner so long after the last news are reported,
        seconds.
    largest_named
        Number of them that a report names.
    set_alike_s
        A trigger is reported in less time than this, seconds: clocks that differ by more were not
        set by the same source.
    """

    late_s: float = 5.0
    settled_s: float = 10.0
    largest_named: int = 5
    set_alike_s: float = 5.0


GEOTAG = GeotagOptions()


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
    folder
        Folder of the journal of triggers and photographs; None: a restart forgets them.

    Raises
    ------
    ValueError
        If the journal is damaged.
    """

    def __init__(
        self, numbering: ShotNumbering, source: ImageSource | None, folder: Path | None
    ) -> None:
        self.numbering = numbering
        self._source = source
        self._journal = PictureJournal(folder, numbering.next_sequence)
        taken = self._journal.taken
        is_folder = source is not None and not source.is_stream
        self._log = TriggerLog(taken.last)
        self._pairing = ImagePairing(
            triggers=taken.waiting if is_folder else (), offset_s=taken.offset_s
        )
        self._waiting: list[tuple[CameraTrigger, float]] = []
        self._faults: list[str] = []
        self._news_s: float | None = None
        if source is not None:
            source.skip(taken.names)
            if source.is_stream and taken.waiting:
                names = _named([f'shot {trigger.index}' for trigger in taken.waiting])
                self._faults.append(f'no picture before this bridge began of {names}')

    @property
    def shot_count(self) -> int:
        """Number of triggers."""
        return self._journal.shot_count

    @property
    def pending(self) -> int:
        """Number of triggers whose photograph is not in the image store yet."""
        unpaired = len(self._pairing.triggers) + len(self._waiting)
        return len(self.numbering.store) + (0 if self._source is None else unpaired)

    def owed(self, assignment: Assignment | None, visited: int) -> int:
        """Return how many photographs of a flight the image store must get.

        All that were triggered; and one for each of the `visited` stops where the plan takes them
        there, since the report of a trigger can be lost. A picture that is missing is among them.
        """
        if self._source is None or assignment is None:
            return 0
        plan = assignment.plan
        is_each = plan.takes_photographs and not plan.trigger_distance_m
        return max(self._journal.count_of(assignment.plan_id), visited if is_each else 0)

    def on_message(
        self, message: Message, vehicle: VehicleTelemetry, unix_s: float, plan_id: str = ''
    ) -> list[CameraTrigger]:
        """Take a message of the vehicle; return the triggers that it reports.

        `plan_id` names the plan that it flies.
        """
        triggers = self._log.take(message, vehicle, unix_s)
        self._waiting += [(trigger, unix_s) for trigger in triggers]
        for trigger in triggers:
            self._note(trigger, plan_id)
        return triggers

    def tagged(self, context: GeotagContext, refuse: Callable[[str], None]) -> list[Shot]:
        """Return the photographs whose image and trigger have both come since; they are kept.

        `refuse` is called with a line for one that cannot be kept, whose image stays where the
        camera wrote it, for a trigger without an image and an image without a trigger.
        """
        if self._source is None:
            self._waiting.clear()
            return []
        pairs = self._pairs(self._source)
        faults, self._faults = [*self._faults, *self._unpaired(bool(pairs))], []
        for fault in faults:
            refuse(f'{context.vehicle}: {fault}')
        made = []
        for pair in pairs:
            photograph = self._photograph(pair, context)
            if photograph is None:
                refuse(f'{context.vehicle}: {pair.image.name} is no image')
                continue
            try:
                self._journal.add_picture(photograph.sequence, pair)
                self.numbering.add(photograph)
                made.append(photograph)
            except OSError as error:
                refuse(f'{context.vehicle}: {pair.image.name} is not sent: {error}')
        return made

    def _pairs(self, source: ImageSource) -> list[ImagePair]:
        new, self._waiting = self._waiting, []
        if source.is_stream:
            return self._of_stream(source, new)
        images = source.take()
        if new or images:
            self._news_s = self._log.newest_s
        return [*self._pairing.add([trigger for trigger, _ in new], images), *self._by_time()]

    def _of_stream(
        self, source: ImageSource, new: list[tuple[CameraTrigger, float]]
    ) -> list[ImagePair]:
        pairs = []
        for trigger, arrived_s in new:
            image = source.at(_moment_of(trigger, arrived_s))
            if image is None:
                self._faults.append(_without_image(trigger))
            else:
                pairs.append(ImagePair(trigger, image))
        return pairs

    def _by_time(self) -> list[ImagePair]:
        """Return images whose trigger was not reported, for instance while the bridge was down."""
        offset_s, pairs = self._pairing.offset_s, []
        for image in self._pairing.images if offset_s is not None else ():
            taken_s = image.unix_s - (offset_s or 0.0)
            found = (
                self._log.found(taken_s) if taken_s + GEOTAG.late_s < self._log.newest_s else None
            )
            if found is not None:
                guessed = self._pairing.settle(image)
                pairs.append(ImagePair(found, image, guessed))
        return pairs

    def _unpaired(self, is_new: bool) -> list[str]:
        """Return a line that names what found no partner, once it has settled."""
        if self._news_s is None or is_new or self._log.newest_s - self._news_s < GEOTAG.settled_s:
            return []
        self._news_s = None
        shots = [f'shot {trigger.index}' for trigger in self._pairing.triggers]
        files = [image.name for image in self._pairing.images]
        lines = []
        if shots:
            lines.append(f'{len(shots)} without a picture: {_named(shots)}')
        if files:
            lines.append(f'{len(files)} pictures without a place: {_named(files)}')
        return lines

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
            horizontal_std_m=math.hypot(context.gps.horizontal_std_m, trigger.position_std_m),
            vertical_std_m=context.gps.vertical_std_m,
            height_m=trigger.height_m,
            quaternion_xyzw=(x, y, z, w),
            width_px=size[0],
            height_px=size[1],
            jpeg=pair.image.jpeg,
        )

    def _note(self, trigger: CameraTrigger, plan_id: str) -> None:
        try:
            self._journal.add_shot(trigger, plan_id)
        except OSError as error:
            self._faults.append(f'shot {trigger.index} is not in {SHOTS}: {error}')


def _without_image(trigger: CameraTrigger) -> str:
    return f'shot {trigger.index} has no picture: the camera sent none then'


def _named(names: list[str]) -> str:
    more = len(names) - GEOTAG.largest_named
    return ', '.join(names[: GEOTAG.largest_named]) + (f' and {more} more' if more > 0 else '')


def _moment_of(trigger: CameraTrigger, arrived_s: float) -> float:
    """Return the time of a trigger by our clock: the autopilot's clock may never have been set."""
    return trigger.unix_s if abs(trigger.unix_s - arrived_s) < GEOTAG.set_alike_s else arrived_s


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
