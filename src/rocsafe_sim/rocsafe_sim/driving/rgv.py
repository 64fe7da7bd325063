# SPDX-License-Identifier: Apache-2.0
"""A simulated RGV: a `Rover` with receiver, camera, journal and photographs; without ROS."""

import math
from pathlib import Path

from rocsafe_geo.evidence.shot import Shot
from rocsafe_geo.evidence.shot_store import ShotStore
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.state import Enu
from rocsafe_geo.pinhole import quaternion_of_rotation
from rocsafe_scene.cameras.ground_camera import jpeg_of
from rocsafe_sim.cameras.mounted_camera import Attitude, Exposure, MountedCamera, VehiclePose
from rocsafe_sim.driving.caution import CautionOptions
from rocsafe_sim.driving.chassis import Skid
from rocsafe_sim.driving.drive_journal import read_drive, write_drive
from rocsafe_sim.driving.drive_state import DriveState, Ledger
from rocsafe_sim.driving.rgv_options import RgvOptions
from rocsafe_sim.driving.rover import Rover
from rocsafe_sim.driving.rover_parts import EvidenceShot, RoverParts
from rocsafe_sim.rav.rav import Fix
from rocsafe_sim.rav.shared_parts import SharedParts, shared_parts
from rocsafe_sim.sensors.sensing_noise import SensorNoise, sensor_noise

JOURNAL_NAME = 'drive.json'
# Numbers of the photographs of evidence: no viewpoint of a survey has one of these.
FIRST_EVIDENCE_ID = 2**31
# A restarted process drives the rest of this time again, exactly as before.
JOURNAL_PERIOD_NS = 2_000_000_000


class Rgv:
    """Steps a rover, takes its photographs and writes its journal.

    Parameters
    ----------
    name
        Of the vehicle.
    options
        Of its node.

    Attributes
    ----------
    rover
        Its motion.
    shots
        Photographs without a receipt.
    spool
        Folder of journal and photographs; None: memory only.

    Raises
    ------
    JournalError, SpoolError
        If a file in the spool cannot be read.
    ValueError, ViewError
        If an option is wrong, or the scene cannot be loaded.
    """

    def __init__(self, name: str, options: RgvOptions) -> None:
        self.name, self._mast_m = name, options.mast_m
        self.frame: LocalFrame = options.frame()
        self.spool = Path(options.spool_directory) if options.spool_directory else None
        self.shots = ShotStore(self.spool)
        shared = shared_parts(options, (options.camera(),))
        self.camera = MountedCamera(shared.cameras[0])
        self.noise: SensorNoise = sensor_noise(options, name)
        parts = _parts(name, options, shared, self.noise)
        self.rover = Rover(parts, self._restored() or _parked(options, parts))
        self._written = (-1, 0)

    def step(self, time_ns: int) -> list[Shot]:
        """Advance to `time_ns` and return the photographs since; then keep the journal."""
        taken = [self._photograph(due) for due in self.rover.step(time_ns)]
        for shot in taken:
            self.shots.add(shot)
        self.keep_journal()
        return taken

    def keep_journal(self) -> None:
        """Write the journal if a command or a stand changed it, or some time has passed."""
        now = self.rover.changes, self.rover.state.time_ns // JOURNAL_PERIOD_NS
        if self.spool is None or now == self._written:
            return
        if now[0] == self._written[0] and self.rover.is_idle:
            return
        self._written = now
        write_drive(self.spool / JOURNAL_NAME, self.rover.state)

    def place_enu(self) -> Enu:
        """Return the true place of the top of its mast."""
        state = self.rover.state
        up = self.rover.parts.ground_up_m(state.place)
        return state.east_m, state.north_m, up + self._mast_m

    def velocity_enu(self) -> Enu:
        """Return its speed over ground, east, north, up."""
        state = self.rover.state
        speed, yaw = state.speed_mps, state.yaw_rad
        return speed * math.cos(yaw), speed * math.sin(yaw), 0.0

    def fix(self) -> Fix:
        """Return the fix of its receiver, which is on the mast."""
        true_enu = self.place_enu()
        error = self.noise.gps_error_m(self.rover.state.time_ns)
        measured: Enu = (true_enu[0] + error[0], true_enu[1] + error[1], true_enu[2] + error[2])
        return Fix(
            true_position=self.frame.position_of(true_enu),
            position=self.frame.position_of(measured),
            position_enu=measured,
        )

    def _photograph(self, due: EvidenceShot) -> Shot:
        camera, fix = self.camera, self.fix()
        attitude = Attitude(yaw_rad=due.yaw_rad)
        stand = VehiclePose(position_enu=self.place_enu(), attitude=attitude)
        rng = self.noise.picture_rng(camera.name, due.time_ns)
        exposure = Exposure(time_ns=due.time_ns, stand=stand, around=(stand, stand), rng=rng)
        picture = camera.take(exposure)
        roll, pitch, yaw = self.noise.attitude_error_rad(due.sequence)
        measured = Attitude(yaw_rad=due.yaw_rad + yaw, pitch_rad=pitch, roll_rad=roll)
        x, y, z, w = quaternion_of_rotation(camera.rotation(measured, due.time_ns)).tolist()
        settings = camera.settings
        return Shot(
            vehicle=self.name,
            sequence=due.sequence,
            viewpoint_id=FIRST_EVIDENCE_ID + due.stop,
            time_ns=due.time_ns,
            position=fix.position,
            horizontal_std_m=self.noise.gps_horizontal_std_m,
            vertical_std_m=self.noise.gps_vertical_std_m,
            height_m=self._mast_m,
            quaternion_xyzw=(x, y, z, w),
            width_px=settings.image_width_px,
            height_px=settings.image_height_px,
            jpeg=jpeg_of(picture.image, settings.jpeg_quality, camera.model.camera.remark),
        )

    def _restored(self) -> DriveState | None:
        return None if self.spool is None else read_drive(self.spool / JOURNAL_NAME)


def _parts(name: str, options: RgvOptions, shared: SharedParts, noise: SensorNoise) -> RoverParts:
    chassis = options.chassis()
    return RoverParts(
        chassis=chassis,
        skid=Skid(chassis=chassis, seed=options.seed, vehicle=name),
        noise=noise,
        caution=CautionOptions(),
        has_detector=options.reading_period_s > 0.0,
        surroundings=shared.surroundings,
    )


def _parked(options: RgvOptions, parts: RoverParts) -> DriveState:
    east, north, _ = options.frame().enu_of(options.home).tolist()
    return DriveState(
        time_ns=0, east_m=east, north_m=north, charge_j=parts.chassis.capacity_j, ledger=Ledger()
    )
