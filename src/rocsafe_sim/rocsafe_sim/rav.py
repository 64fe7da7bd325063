# SPDX-License-Identifier: Apache-2.0
"""A simulated RAV: a vehicle with its sensors, its camera, its journal and its photographs."""

from dataclasses import dataclass
from pathlib import Path

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_optical
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.shot import Shot
from rocsafe_geo.shot_store import ShotStore
from rocsafe_sim.camera import Camera, Truth, jpeg_of
from rocsafe_sim.flight_record import VehicleRecord
from rocsafe_sim.journal import read_journal, write_journal
from rocsafe_sim.observation import Observation, ShotDue
from rocsafe_sim.route import Enu
from rocsafe_sim.sensing_noise import SensorNoise
from rocsafe_sim.vehicle import Vehicle

JOURNAL_NAME = 'journal.json'


@dataclass(frozen=True, slots=True, kw_only=True)
class Fix:
    """Where a receiver believes it is, and where it is.

    Attributes
    ----------
    true_position, position : true and measured.
    position_enu : measured, metres.
    """

    true_position: GeoPosition
    position: GeoPosition
    position_enu: Enu


@dataclass(frozen=True, slots=True, kw_only=True)
class RavParts:
    """What a RAV is made of.

    Attributes
    ----------
    name : of the vehicle.
    frame : local frame of the mission.
    noise : of its sensors.
    camera : with its ground.
    jpeg_quality : 1 to 100.
    """

    name: str
    frame: LocalFrame
    noise: SensorNoise
    camera: Camera
    jpeg_quality: int


class Rav:
    """Steps a vehicle, takes its photographs, keeps its journal.

    Parameters
    ----------
    parts : sensors and frame.
    vehicle : as switched on; a journal in `spool` overrides its state.
    spool : folder of journal and photographs; None keeps them in memory only.

    Raises
    ------
    JournalError, SpoolError: if the spool holds what cannot be read.
    """

    def __init__(self, parts: RavParts, vehicle: Vehicle, spool: Path | None = None) -> None:
        self.parts = parts
        self.vehicle = vehicle
        self.shots = ShotStore(spool)
        self._journal = None if spool is None else spool / JOURNAL_NAME
        self._written: VehicleRecord | None = None
        self._truths: dict[int, Truth | None] = {}
        if self._journal is not None:
            record = read_journal(self._journal)
            if record is not None:
                vehicle.restore(record)
                self._written = record

    def step(self, time_ns: int) -> tuple[Observation, list[Shot]]:
        """Advance to `time_ns`; return what is true then and the photographs taken on the way.

        Photographs are on disk before the journal counts them.
        """
        observation = self.vehicle.step(time_ns)
        self._truths.clear()
        taken = [self._photograph(due) for due in observation.shots]
        for shot in taken:
            self.shots.add(shot)
        self.keep_journal()
        return observation, taken

    def truth_of(self, shot: Shot) -> Truth | None:
        """Return what is true of a photograph of the last step; None if nobody knows."""
        return self._truths.get(shot.sequence)

    def keep_journal(self) -> None:
        """Write the journal if an order, a photograph or a landing changed it."""
        record = self.vehicle.record
        if self._journal is not None and record is not self._written and record != self._written:
            write_journal(self._journal, record)
        self._written = record

    def fix(self, time_ns: int, true_enu: Enu) -> Fix:
        """Return what the receiver says at a time and true place."""
        error = self.parts.noise.gps_error_m(time_ns)
        measured: Enu = (true_enu[0] + error[0], true_enu[1] + error[1], true_enu[2] + error[2])
        frame = self.parts.frame
        return Fix(
            true_position=frame.position_of(true_enu),
            position=frame.position_of(measured),
            position_enu=measured,
        )

    def _photograph(self, due: ShotDue) -> Shot:
        parts = self.parts
        roll, pitch = parts.noise.sway_rad(due.sequence)
        roll_error, pitch_error, yaw_error = parts.noise.attitude_error_rad(due.sequence)
        yaw = due.pose.yaw_rad
        rotation = rotation_enu_from_optical(yaw, pitch, roll)
        image = parts.camera.photograph(due.pose.position_enu, rotation, due.time_ns)
        self._truths[due.sequence] = parts.camera.truth
        measured = rotation_enu_from_optical(
            yaw + yaw_error, pitch + pitch_error, roll + roll_error
        )
        fix = self.fix(due.time_ns, due.pose.position_enu)
        x, y, z, w = quaternion_of_rotation(measured).tolist()
        return Shot(
            vehicle=parts.name,
            sequence=due.sequence,
            viewpoint_id=due.viewpoint_id,
            time_ns=due.time_ns,
            position=fix.position,
            horizontal_std_m=parts.noise.gps_horizontal_std_m,
            vertical_std_m=parts.noise.gps_vertical_std_m,
            height_m=fix.position_enu[2],
            quaternion_xyzw=(x, y, z, w),
            width_px=parts.camera.lens.image_width_px,
            height_px=parts.camera.lens.image_height_px,
            jpeg=jpeg_of(image, parts.jpeg_quality),
        )
