# SPDX-License-Identifier: Apache-2.0
"""Construction of RAVs from options."""

from pathlib import Path

from rocsafe_geo.position import GeoPosition
from rocsafe_sim.cameras.mounted_camera import MountedCamera
from rocsafe_sim.options import VehicleOptions
from rocsafe_sim.rav.rav import Rav, RavParts
from rocsafe_sim.rav.shared_parts import SharedParts
from rocsafe_sim.sensors.rangefinder import above_level_ground_m
from rocsafe_sim.sensors.sensing_noise import sensor_noise
from rocsafe_sim.sensors.sensor_suite import make_suite
from rocsafe_sim.vehicle.free_vehicle import FreeVehicle


def make_rav(
    options: VehicleOptions,
    name: str,
    home: GeoPosition,
    shared: SharedParts,
    spool: Path | None,
) -> Rav:
    """Return the RAV `name` on the ground at `home`, with the parts of `make_shared`.

    Raises
    ------
    JournalError, SpoolError
        If a file in `spool` cannot be read.
    ValueError
        If the file of the autopilot or of the sensors is wrong, or there is too much wind.
    """
    frame = options.frame()
    east, north, _ = frame.enu_of(home).tolist()
    surroundings = shared.surroundings
    noise = sensor_noise(options, name)
    parts = RavParts(
        name=name,
        frame=frame,
        noise=noise,
        drift=options.drift(),
        cameras=tuple(map(MountedCamera, shared.cameras)),
        sensors=make_suite(
            options.sensors(),
            noise.draws,
            frame,
            above_level_ground_m if surroundings is None else surroundings.first_hit_m,
            noise.attitude_std_rad,
        ),
    )
    up = 0.0 if surroundings is None else surroundings.ground_up_m(east, north)
    vehicle = FreeVehicle(options.airframe(), (east, north, up), surroundings)
    return Rav(parts, vehicle, spool, is_lockstep=options.lock_step)
