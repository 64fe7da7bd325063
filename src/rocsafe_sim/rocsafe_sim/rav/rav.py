# SPDX-License-Identifier: Apache-2.0
"""A simulated RAV: a `FreeVehicle` with sensors, cameras, journal and photographs.

It knows nothing of ROS; `rocsafe_sim.vehicle_node` gives it its topics.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.evidence.shot_store import ShotStore
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import quaternion_of_rotation, rotation_enu_from_body
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_scene.cameras.ground_camera import jpeg_of
from rocsafe_sim.cameras.gimbal import Direction
from rocsafe_sim.cameras.gimbal_file import read_gimbal, write_gimbal
from rocsafe_sim.cameras.mounted_camera import (
    Attitude,
    CameraPicture,
    Exposure,
    MountedCamera,
    VehiclePose,
)
from rocsafe_sim.clock.step_times import StepTimes
from rocsafe_sim.flight.segment import FlightPose, Mode
from rocsafe_sim.flight.wind_drift import WindDrift
from rocsafe_sim.sensors.body_motion import BodyState
from rocsafe_sim.sensors.readings import Reading
from rocsafe_sim.sensors.sensing_noise import SensorNoise
from rocsafe_sim.sensors.sensor_suite import NO_SENSORS, SensorSuite
from rocsafe_sim.vehicle.flight_record import VehicleRecord
from rocsafe_sim.vehicle.free_vehicle import FreeVehicle
from rocsafe_sim.vehicle.journal import read_journal, write_journal
from rocsafe_sim.vehicle.snapshot import ShotDue, VehicleSnapshot
from rocsafe_sim.vehicle.surroundings import on_ground

JOURNAL_NAME = 'journal.json'
STEPS_NAME = 'steps'
_ON_ITS_WAY = (Mode.WAITING, Mode.TAKING_OFF, Mode.FLYING, Mode.RETURNING)
# Height of the cameras of a vehicle on the ground.
LANDED_CAMERA_M = 0.4
# Height from which on the body sways in full; on the ground it stands still.
FULL_SWAY_M = 1.0


@dataclass(frozen=True, slots=True, kw_only=True)
class Fix:
    """True and measured position of a GPS receiver.

    Attributes
    ----------
    true_position, position
        True and measured position.
    position_enu
        Measured position in the local frame, metres.
    """

    true_position: GeoPosition
    position: GeoPosition
    position_enu: Enu


@dataclass(frozen=True, slots=True, kw_only=True)
class RavParts:
    """Sensors and cameras of a RAV.

    Attributes
    ----------
    name
        Name of the vehicle.
    frame
        Local frame of the mission.
    noise
        Errors of its sensors.
    cameras
        Cameras; the first takes the photographs of the survey. Without one it takes none.
    sensors
        Sensors of motion, air, field and distance.
    drift
        How the wind pushes it off its way; None: the wind is steady.
    """

    name: str
    frame: LocalFrame
    noise: SensorNoise
    cameras: tuple[MountedCamera, ...]
    sensors: SensorSuite = NO_SENSORS
    drift: WindDrift | None = None


class Rav:
    """Steps a vehicle, takes its photographs and writes its journal.

    Parameters
    ----------
    parts
        Sensors, cameras and frame.
    vehicle
        Vehicle after power-up; a journal in `spool` replaces its state.
    spool
        Folder of journal and photographs; None: memory only.
    is_lockstep
        Whether simulated time waits for the vehicle.

    Attributes
    ----------
    spool
        As given.
    pictures
        Images of all cameras at the viewpoints of the last step.
    readings
        Samples of the sensors in the last step, in order of time.

    Raises
    ------
    JournalError, SpoolError
        If a file in the spool cannot be read.
    """

    def __init__(
        self,
        parts: RavParts,
        vehicle: FreeVehicle,
        spool: Path | None = None,
        *,
        is_lockstep: bool = False,
    ) -> None:
        self.parts = parts
        self.vehicle = vehicle
        self.shots = ShotStore(spool)
        self.spool = spool
        self._journal = None if spool is None else spool / JOURNAL_NAME
        self._steps = StepTimes(spool and spool / STEPS_NAME, is_lockstep=is_lockstep)
        self._written: VehicleRecord | None = None
        self.pictures: list[CameraPicture] = []
        self.readings: list[Reading] = []
        if self._journal is not None:
            record = read_journal(self._journal)
            if record is not None:
                vehicle.restore(record)
                self._written = record
                # It goes on from its last step, not from its last command.
                vehicle.step(max(vehicle.time_ns, self._steps.last_ns or 0))
        self._restore_gimbals()

    def _restore_gimbals(self) -> None:
        for camera in self.parts.cameras:
            if camera.gimbal is not None and self.spool is not None:
                turn = read_gimbal(self.spool, camera.name)
                camera.gimbal.turn = turn or camera.gimbal.turn

    @property
    def shots_taken(self) -> int:
        """Photographs since power-up."""
        return self.vehicle.record.shots_taken if self.parts.cameras else 0

    def hold_if_cut_off(self, time_ns: int) -> int:
        """Hold where it was when it was stepped last, if it has missed steps before `time_ns`.

        Others may have taken over its work. Returns for how long it was cut off, nanoseconds; 0 if
        it was not, or does not fly and is not about to.
        """
        missed_ns = self._steps.missed_ns(time_ns)
        if not missed_ns or self.vehicle.mode not in _ON_ITS_WAY:
            return 0
        self.vehicle.hold()
        return missed_ns

    def step(self, time_ns: int) -> tuple[VehicleSnapshot, list[Shot]]:
        """Advance to `time_ns`; return the state at that time and the photographs since.

        Photographs are on disk before the journal counts them. `pictures` then holds the images of
        all cameras at the same times.
        """
        snapshot = self._step_and_sense(time_ns)
        self.pictures.clear()
        taken = [self._photograph(due) for due in snapshot.shots if self.parts.cameras]
        for shot in taken:
            self.shots.add(shot)
        self.keep_journal()
        self._steps.note(time_ns)
        return snapshot, taken

    def _step_and_sense(self, time_ns: int) -> VehicleSnapshot:
        """Step the vehicle through the times of its samples, and on to `time_ns`."""
        sensors = self.parts.sensors
        shots: list[ShotDue] = []
        self.readings.clear()
        for sample_ns in sensors.times(self.vehicle.time_ns, time_ns):
            shots += self.vehicle.step(sample_ns).shots
            self.readings += sensors.read(sample_ns, self._body_at)
        snapshot = self.vehicle.step(time_ns)
        return replace(
            snapshot,
            pose=self._blown(snapshot.pose, time_ns),
            shots=(*shots, *snapshot.shots),
        )

    def _blown(self, pose: FlightPose, time_ns: int) -> FlightPose:
        """Return a pose on its way with what the wind adds to it, which grows with the height."""
        if self.parts.drift is None:
            return pose
        (east, north, up), (east_mps, north_mps, up_mps) = pose.position_enu, pose.velocity_enu
        flight = self.vehicle.flight
        command = None if flight is None else flight.command
        offset, rate = self.parts.drift.at(time_ns, self._way_at, command)
        share = min(1.0, max(0.0, self._height_m(pose.position_enu) / FULL_SWAY_M))
        return replace(
            pose,
            position_enu=(east + share * offset[0], north + share * offset[1], up),
            velocity_enu=(east_mps + share * rate[0], north_mps + share * rate[1], up_mps),
        )

    def _way_at(self, time_ns: int) -> FlightPose:
        """Return the pose on its way; before the last command straight back, also in a restart."""
        flight = self.vehicle.flight
        if flight is None or time_ns >= flight.command.start_ns:
            return self.vehicle.pose_at(time_ns)
        start = flight.command.start
        since_s = (time_ns - flight.command.start_ns) / NS_PER_S
        moved = np.array(start.position_enu) + since_s * np.array(start.velocity_enu)
        east, north, up = moved.tolist()
        return replace(start, position_enu=(east, north, up))

    def _pose_at(self, time_ns: int) -> FlightPose:
        """Return the true pose at a time."""
        return self._blown(self.vehicle.pose_at(time_ns), time_ns)

    def _body_at(self, time_ns: int) -> BodyState:
        """Return the true motion of the body: it sways as the cameras of a stream see it."""
        pose = self._pose_at(time_ns)
        share = min(1.0, max(0.0, self._height_m(pose.position_enu) / FULL_SWAY_M))
        roll, pitch = self.parts.noise.sway_at_rad(time_ns)
        return BodyState(
            time_ns=time_ns,
            position_enu=pose.position_enu,
            velocity_enu=pose.velocity_enu,
            rotation=rotation_enu_from_body(pose.yaw_rad, share * pitch, share * roll),
        )

    def pictures_of(self, camera: MountedCamera) -> list[CameraPicture]:
        """Return the images of a camera at the viewpoints of the last step."""
        return [each for each in self.pictures if each.camera == camera.name]

    def point(self, camera: MountedCamera, target: Direction) -> None:
        """Turn the gimbal of a camera, if it has one, from the last step on."""
        if camera.gimbal is not None:
            camera.gimbal.point(target, self.vehicle.time_ns)
            if self.spool is not None:
                write_gimbal(self.spool, camera.name, camera.gimbal.turn)

    def look(self, camera: MountedCamera, seen: VehicleSnapshot) -> CameraPicture:
        """Return the image of a camera at a step, for a stream.

        Raises
        ------
        ViewError
            If the view cannot be drawn.
        """

        def stand(time_ns: int) -> VehiclePose:
            pose, sway = self._pose_at(time_ns), self.parts.noise.sway_at_rad(time_ns)
            east, north, up = pose.position_enu
            on_legs = LANDED_CAMERA_M - self._height_m(pose.position_enu)
            return VehiclePose(
                position_enu=(east, north, up + max(0.0, on_legs)),
                attitude=_attitude(pose.yaw_rad, sway),
            )

        return self._take(camera, seen.time_ns, stand, is_quick=True)

    def _take(
        self,
        camera: MountedCamera,
        time_ns: int,
        stand: Callable[[int], VehiclePose],
        *,
        is_quick: bool = False,
    ) -> CameraPicture:
        half_ns, rng = camera.span_ns // 2, self.parts.noise.picture_rng(camera.name, time_ns)
        around = (stand(time_ns - half_ns), stand(time_ns + half_ns))
        return camera.take(
            Exposure(
                time_ns=time_ns, stand=stand(time_ns), around=around, rng=rng, is_quick=is_quick
            )
        )

    def keep_journal(self) -> None:
        """Write the journal if a command, a photograph or a landing changed it."""
        record = self.vehicle.record
        if self._journal is not None and record is not self._written and record != self._written:
            write_journal(self._journal, record)
        self._written = record

    def fix(self, time_ns: int, true_enu: Enu) -> Fix:
        """Return the fix of the receiver at a time and a true place."""
        error = self.parts.noise.gps_error_m(time_ns)
        measured: Enu = (true_enu[0] + error[0], true_enu[1] + error[1], true_enu[2] + error[2])
        frame = self.parts.frame
        return Fix(
            true_position=frame.position_of(true_enu),
            position=frame.position_of(measured),
            position_enu=measured,
        )

    def _photograph(self, due: ShotDue) -> Shot:
        parts, own = self.parts, self._blown(due.pose, due.time_ns)
        place = own.position_enu
        sway = parts.noise.sway_rad(due.sequence)

        def stand(time_ns: int) -> VehiclePose:
            pose = own if time_ns == due.time_ns else self._pose_at(time_ns)
            attitude = _attitude(pose.yaw_rad, sway)
            return VehiclePose(position_enu=pose.position_enu, attitude=attitude)

        first, *others = parts.cameras
        picture = self._take(first, due.time_ns, stand)
        self.pictures.append(picture)
        for other in others:
            if other.settings.at_viewpoints:
                self.pictures.append(self._take(other, due.time_ns, stand))
        attitude = stand(due.time_ns).attitude
        measured = self._measured(first.held(attitude), due.sequence)
        rotation = first.rotation(measured, due.time_ns)
        fix = self.fix(due.time_ns, place)
        x, y, z, w = quaternion_of_rotation(rotation).tolist()
        return Shot(
            vehicle=parts.name,
            sequence=due.sequence,
            viewpoint_id=due.viewpoint_id,
            time_ns=due.time_ns,
            position=fix.position,
            horizontal_std_m=parts.noise.gps_horizontal_std_m,
            vertical_std_m=parts.noise.gps_vertical_std_m,
            height_m=self._height_m(fix.position_enu),
            quaternion_xyzw=(x, y, z, w),
            width_px=first.settings.image_width_px,
            height_px=first.settings.image_height_px,
            jpeg=jpeg_of(picture.image, first.settings.jpeg_quality, first.model.camera.remark),
        )

    def _height_m(self, place_enu: Enu) -> float:
        """Return the height of a place above the ground below it."""
        surroundings = self.vehicle.surroundings
        if surroundings is None:
            return place_enu[2]
        return place_enu[2] - on_ground(surroundings, place_enu)[2]

    def _measured(self, attitude: Attitude, sequence: int) -> Attitude:
        roll, pitch, yaw = self.parts.noise.attitude_error_rad(sequence)
        return Attitude(
            yaw_rad=attitude.yaw_rad + yaw,
            pitch_rad=attitude.pitch_rad + pitch,
            roll_rad=attitude.roll_rad + roll,
        )


def _attitude(yaw_rad: float, sway_rad: tuple[float, float]) -> Attitude:
    roll, pitch = sway_rad
    return Attitude(yaw_rad=yaw_rad, pitch_rad=pitch, roll_rad=roll)
