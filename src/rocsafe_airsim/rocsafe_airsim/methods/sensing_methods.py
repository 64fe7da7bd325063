# SPDX-License-Identifier: Apache-2.0
"""Methods that tell what is known of a vehicle and what its cameras see."""

import math
import re
from collections.abc import Mapping, Sequence
from typing import Any

from rocsafe_airsim import images, values
from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.methods.access import Access, matches, served
from rocsafe_airsim.methods.given import number, sequence, shown, table, text
from rocsafe_airsim.methods.given_motion import vector_of
from rocsafe_airsim.ned import Quaternion, attitude_ned, heading, product
from rocsafe_airsim.rotors import rotor_states
from rocsafe_airsim.vehicle import AIRBORNE, DISARMED, Picture

# A camera that is rolled by no more counts as level.
LEVEL_RAD = math.radians(1.0)
# The pose of a thing that is not there.
_NOWHERE = values.pose((math.nan,) * 3, (math.nan,) * 4)
# All images of a call are in memory at once.
MOST_IMAGES = 64


class SensingMethods:
    """State, sensors and images."""

    def __init__(self, at: Access) -> None:
        self._at = at

    @served('getMultirotorState')
    async def _get_multirotor_state(self, name: str = '') -> values.Plain:
        vehicle = self._at.vehicle(name)
        return values.multirotor_state(vehicle, vehicle.now())

    @served('getGpsData')
    async def _get_gps_data(self, _gps: str = '', name: str = '') -> values.Plain:
        return values.gps_data(self._at.vehicle(name).now())

    @served('simGetVehiclePose')
    async def _sim_get_vehicle_pose(self, name: str = '') -> values.Plain:
        vehicle = self._at.simulated(name)
        now = vehicle.now()
        return values.pose(vehicle.origin.to_ned(now.true_enu), attitude_ned(now.attitude))

    @served('simSetVehiclePose')
    async def _sim_set_vehicle_pose(
        self, pose: Any, _ignore_collision: Any = True, name: str = ''
    ) -> None:
        vehicle = self._at.led(self._at.simulated(name).name)
        if vehicle.now().state != DISARMED:
            raise AirsimError(f'{vehicle.name} has flown: can be placed before its first flight')
        place = vehicle.origin.to_enu(vector_of(table(pose, 'pose').get('position')))
        await vehicle.set_home(self._at.world.to_geodetic(place))

    @served('simGetGroundTruthKinematics')
    async def _sim_get_ground_truth_kinematics(self, name: str = '') -> values.Plain:
        vehicle = self._at.simulated(name)
        return values.kinematics(vehicle, vehicle.now(), is_true=True)

    @served('simGetGroundTruthEnvironment')
    async def _sim_get_ground_truth_environment(self, name: str = '') -> values.Plain:
        vehicle = self._at.simulated(name)
        return values.environment(vehicle, vehicle.now())

    @served('simGetCollisionInfo')
    async def _sim_get_collision_info(self, name: str = '') -> values.Plain:
        vehicle = self._at.simulated(name)
        return values.collision(vehicle, vehicle.now())

    @served('getRadSensorData')
    async def _get_rad_sensor_data(self, _sensor: str = '', name: str = '') -> Any:
        return dict(self._at.vehicle(name).reading('radiation'))

    @served('getRotorStates')
    async def _get_rotor_states(self, name: str = '') -> values.Plain:
        vehicle = self._at.vehicle(name)
        if not vehicle.is_simulated:
            raise AirsimError(f'{vehicle.name} is a real vehicle: it tells nothing of its rotors')
        now = vehicle.now()
        if now.state not in AIRBORNE:
            return rotor_states(now.stamp_ns, 0.0)
        imu = vehicle.reading('imu')
        return rotor_states(imu['time_stamp'], -imu['linear_acceleration']['z_val'])

    @served('getImuData')
    async def _get_imu_data(self, _imu: str = '', name: str = '') -> Any:
        return dict(self._at.vehicle(name).reading('imu'))

    @served('getBarometerData')
    async def _get_barometer_data(self, _barometer: str = '', name: str = '') -> Any:
        return dict(self._at.vehicle(name).reading('barometer'))

    @served('getMagnetometerData')
    async def _get_magnetometer_data(self, _magnetometer: str = '', name: str = '') -> Any:
        return dict(self._at.vehicle(name).reading('magnetometer'))

    @served('getDistanceSensorData')
    async def _get_distance_sensor_data(self, _sensor: str = '', name: str = '') -> Any:
        return dict(self._at.vehicle(name).reading('range'))

    @served('getGasData')
    async def _get_gas_data(self, _sensor: str = '', name: str = '') -> Any:
        return dict(self._at.vehicle(name).reading('gas'))

    @served('simGetImages')
    async def _sim_get_images(
        self, requests: Sequence[Mapping[str, Any]], name: str = '', *_external: Any
    ) -> list[values.Plain]:
        vehicle = self._at.simulated(name)
        requests = [table(one, 'a request') for one in sequence(requests, 'requests')]
        if len(requests) > MOST_IMAGES:
            raise AirsimError(f'{len(requests)} images: must be {MOST_IMAGES} at most in a call')
        kinds = [images.image_type(one.get('image_type', 0)) for one in requests]
        looks: dict[str, Picture] = {}
        for one in requests:
            camera = self._at.camera(vehicle, one.get('camera_name', ''))
            with_truth = any(kind != images.SCENE for kind in kinds)
            if camera not in looks:
                looks[camera] = await vehicle.look(camera, with_truth=with_truth)
        answers = []
        for one in requests:
            picture = looks[self._at.camera(vehicle, one.get('camera_name', ''))]
            place = vehicle.origin.to_ned(picture.place_enu)
            aim = (place, attitude_ned(_body_of_optical(picture.attitude)))
            answers.append(images.response(picture, one, aim, self._at.ids))
        return answers

    @served('simGetImage')
    async def _sim_get_image(
        self, camera: str, image_type: int, name: str = '', *_external: Any
    ) -> bytes:
        request = {'camera_name': camera, 'image_type': image_type, 'compress': True}
        (found,) = await self._sim_get_images([request], name)
        return bytes(found['image_data_uint8'])

    @served('simGetCameraInfo')
    async def _sim_get_camera_info(
        self, camera: str, name: str = '', *_external: Any
    ) -> values.Plain:
        vehicle = self._at.simulated(name)
        own = self._at.camera(vehicle, camera)
        picture = await vehicle.look(own, with_truth=False)
        place = vehicle.origin.to_ned(picture.place_enu)
        aim = attitude_ned(_body_of_optical(picture.attitude))
        height, width = picture.pixels.shape[:2]
        fov_deg = picture.fov_deg
        return {
            'pose': values.pose(place, aim),
            'fov': fov_deg,
            'proj_mat': {'matrix': _projection(fov_deg, width / height)},
        }

    @served('simSetCameraPose')
    async def _sim_set_camera_pose(
        self, camera: str, pose: Any, name: str = '', *_external: Any
    ) -> None:
        vehicle = self._at.simulated(name)
        own = self._at.camera(vehicle, camera)
        if any(vector_of(table(pose, 'pose').get('position'))):
            raise AirsimError('position must be 0, 0, 0: cameras stay where they are mounted')
        roll, pitch, yaw = _roll_pitch_yaw(table(pose.get('orientation'), 'orientation'))
        if abs(roll) > LEVEL_RAD:
            raise AirsimError(
                f'roll is {math.degrees(roll):.1f} deg: must be 0, gimbals keep level'
            )
        # AirSim's yaw is clockwise.
        await vehicle.point(own, pitch, -yaw)

    @served('simSetCameraFov')
    async def _sim_set_camera_fov(
        self, camera: str, fov_deg: float, name: str = '', *_external: Any
    ) -> None:
        vehicle = self._at.simulated(name)
        own = self._at.camera(vehicle, camera)
        await vehicle.set_fov(own, number(fov_deg, 'fov_degrees'))

    @served('simListSceneObjects')
    async def _sim_list_scene_objects(self, name_regex: str = '.*') -> list[str]:
        return [str(row['name']) for row in self._at.instances() if matches(name_regex, row)]

    @served('simGetObjectPose')
    async def _sim_get_object_pose(self, mesh: str, *_is_ned: Any) -> values.Plain:
        row = self._at.instance(mesh)
        if row is None:
            # As AirSim answers: scripts ask in this way whether there is such a thing.
            return _NOWHERE
        if 'place' not in row:
            raise AirsimError(f'{shown(mesh)}: has no place of its own, or moves')
        return values.pose(
            self._at.vehicle('').origin.to_ned(row['place']), heading(float(row['yaw']))
        )

    @served('simGetSegmentationObjectID')
    async def _sim_get_segmentation_object_id(self, mesh: str) -> int:
        row = self._at.instance(mesh)
        if row is None:
            return -1
        number = int(row['number'])
        return self._at.ids.get(number, number % images.MOST_IDS)

    @served('simSetSegmentationObjectID')
    async def _sim_set_segmentation_object_id(
        self, mesh: str, object_id: int, is_regex: bool = False
    ) -> bool:
        if not 0 <= (chosen := int(number(object_id, 'object_id'))) < images.MOST_IDS:
            raise AirsimError(f'object_id is {object_id}: must be within 0 and 255')
        pattern = mesh if is_regex else re.escape(text(mesh, 'mesh_name'))
        found = [row for row in self._at.instances() if matches(pattern, row)]
        self._at.ids |= {int(row['number']): chosen for row in found}
        return bool(found)


def _body_of_optical(attitude: Quaternion) -> Quaternion:
    """Return the attitude of a body (ahead, left, up) whose camera has this optical attitude."""
    # Optical right, down, ahead are the body's -y, -z, x.
    return product(attitude, (0.5, -0.5, 0.5, 0.5))


def _roll_pitch_yaw(orientation: Mapping[str, Any]) -> tuple[float, float, float]:
    """Return the angles of a Quaternionr, rad: pitch is positive for up, yaw for clockwise."""
    w, x, y, z = (number(orientation.get(f'{axis}_val'), f'{axis}_val') for axis in 'wxyz')
    size = math.sqrt(w * w + x * x + y * y + z * z)
    if not (math.isfinite(size) and size > 0.0):
        raise AirsimError('orientation must be a quaternion that is not zero')
    w, x, y, z = w / size, x / size, y / size, z / size
    return (
        math.atan2(2.0 * (w * x + y * z), 1.0 - 2.0 * (x * x + y * y)),
        math.asin(min(max(2.0 * (w * y - z * x), -1.0), 1.0)),
        math.atan2(2.0 * (w * z + x * y), 1.0 - 2.0 * (y * y + z * z)),
    )


def _projection(fov_deg: float, aspect: float) -> list[list[float]]:
    """Return a projection of the near plane 0.1 m, without a far plane."""
    scale = 1.0 / math.tan(math.radians(fov_deg) / 2.0)
    return [
        [scale, 0.0, 0.0, 0.0],
        [0.0, scale * aspect, 0.0, 0.0],
        [0.0, 0.0, 0.0, 0.1],
        [0.0, 0.0, 1.0, 0.0],
    ]
