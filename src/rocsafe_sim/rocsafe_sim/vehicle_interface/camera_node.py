# SPDX-License-Identifier: Apache-2.0
"""ROS interface of one camera of a simulated vehicle."""

from rclpy.publisher import Publisher
from std_msgs.msg import Header, String

from rocsafe_interfaces.msg import GimbalCommand
from rocsafe_interfaces.srv import Look, SetFieldOfView
from rocsafe_ros.conversions import jpeg_message, stamp_of_ns
from rocsafe_ros.domain.audience import Audience
from rocsafe_ros.frames import VehicleFrames
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec, of_camera
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_scene.cameras.ground_camera import jpeg_of
from rocsafe_scene.errors import ViewError
from rocsafe_sim.cameras.mounted_camera import CameraPicture, MountedCamera
from rocsafe_sim.clock.cadence import Cadence, period_ns
from rocsafe_sim.messages.picture_conversions import (
    depth_message,
    direction_of,
    gimbal_message,
    image_message,
    info_message,
    labels_message,
    mount_of,
    picture_header,
    pose_message,
)
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.vehicle.snapshot import VehicleSnapshot

GIMBAL_PERIOD_NS = 1_000_000_000


class CameraInterface:
    """Publishes the topics of a camera, and executes the commands to its gimbal.

    Publishes: image_raw, image_raw/compressed, camera_info, depth, labels, label_table, pose,
    gimbal/state, and the frame of a gimbal. Subscribes: gimbal/command. Services: look, set_fov.

    Images are published when the vehicle takes them at viewpoints, and `stream_rate_hz` times a
    simulated second as long as anybody but a recorder subscribes.
    """

    def __init__(
        self, node: VehicleScopeNode, rav: Rav, camera: MountedCamera, frames: VehicleFrames
    ) -> None:
        self._frames = frames
        self._node, self._rav, self._camera = node, rav, camera
        self._vehicle = rav.parts.name
        self._image = self._publisher(topics.CAMERA_IMAGE)
        self._compressed = self._publisher(topics.CAMERA_IMAGE_COMPRESSED)
        self._info = self._publisher(topics.CAMERA_INFO)
        self._depth = self._publisher(topics.CAMERA_DEPTH)
        self._labels = self._publisher(topics.CAMERA_LABELS)
        self._pose = self._publisher(topics.CAMERA_POSE)
        self._table = self._publisher(topics.CAMERA_LABEL_TABLE)
        self._audiences = [
            Audience(node, publisher)
            for publisher in (self._image, self._compressed, self._depth, self._labels)
        ]
        if camera.model.camera.label_table():
            self._table.publish(String(data=camera.model.camera.label_table()))
        rate_hz = camera.settings.stream_rate_hz
        self._stream = Cadence(period_ns(rate_hz)) if rate_hz else None
        for spec, answer in ((calls.LOOK, self._on_look), (calls.SET_FOV, self._on_fov)):
            own = of_camera(spec, camera.name)
            node.create_service(own.call_type, own.name, answer)
        if camera.gimbal is not None:
            self._add_gimbal()

    @property
    def name(self) -> str:
        """Name of the camera."""
        return self._camera.name

    def after_step(self, seen: VehicleSnapshot) -> None:
        """Publish what is due at a step, but for the images of viewpoints."""
        if self._stream is not None and self._stream.is_due(seen.time_ns) and self._is_watched():
            self._publish_look(seen)
        if self._camera.gimbal is not None:
            self._publish_gimbal(seen.time_ns)

    def publish(self, picture: CameraPicture, jpeg: bytes | None = None) -> None:
        """Publish the image of a viewpoint; `jpeg` is its file, if that exists."""
        self._publish(picture, jpeg or self._jpeg_of(picture))

    def _jpeg_of(self, picture: CameraPicture) -> bytes:
        return jpeg_of(picture.image, self._camera.settings.jpeg_quality)

    def _publish(self, picture: CameraPicture, jpeg: bytes | None) -> None:
        header = picture_header(self._vehicle, picture)
        self._info.publish(info_message(picture, header))
        if jpeg is not None:
            self._compressed.publish(jpeg_message(jpeg, header))
        if _is_heard(self._image):
            self._image.publish(image_message(picture, header))
        if _is_heard(self._pose):
            self._pose.publish(pose_message(picture))
        self._publish_truth(picture, header)

    def _publish_truth(self, picture: CameraPicture, header: Header) -> None:
        if picture.truth is None:
            return
        if _is_heard(self._depth):
            self._depth.publish(depth_message(picture.truth, header))
        if _is_heard(self._labels):
            self._labels.publish(labels_message(picture.truth, header))

    def _publish_look(self, seen: VehicleSnapshot) -> None:
        if any(picture.time_ns == seen.time_ns for picture in self._rav.pictures_of(self._camera)):
            return
        try:
            picture = self._rav.look(self._camera, seen)
        except ViewError as error:
            self._node.get_logger().warning(f'{self.name}: no picture: {error}', once=True)
            return
        self._publish(picture, self._jpeg_of(picture) if _is_heard(self._compressed) else None)

    def _on_look(self, request: Look.Request, response: Look.Response) -> Look.Response:
        try:
            picture = self._rav.look(self._camera, self._rav.vehicle.observe())
        except ViewError as error:
            response.message = f'{self._vehicle}: {self.name}: no picture: {error}'
            return response
        header = picture_header(self._vehicle, picture)
        response.image, response.pose = image_message(picture, header), pose_message(picture)
        response.camera_info = info_message(picture, header)
        if request.with_truth and picture.truth is not None:
            response.depth = depth_message(picture.truth, header)
            response.labels = labels_message(picture.truth, header)
        response.success = True
        return response

    def _on_fov(
        self, request: SetFieldOfView.Request, response: SetFieldOfView.Response
    ) -> SetFieldOfView.Response:
        try:
            self._camera.set_fov(request.horizontal_fov_deg)
        except (ViewError, ValueError) as refusal:
            response.message = f'{self._vehicle}: {self.name}: {refusal}'
            return response
        response.success = True
        return response

    def _is_watched(self) -> bool:
        return any(audience.is_watching for audience in self._audiences)

    def _add_gimbal(self) -> None:
        self._gimbals = Cadence(GIMBAL_PERIOD_NS)
        self._is_settled = False
        self._state = self._publisher(topics.GIMBAL_STATE)
        spec = of_camera(topics.GIMBAL_COMMAND, self.name)
        topics.create_subscription(self._node, spec, self._on_command)

    def _on_command(self, command: GimbalCommand) -> None:
        try:
            self._rav.point(self._camera, direction_of(command))
        except ValueError as error:
            self._node.get_logger().warning(f'{self.name}: gimbal/command: {error}')
            return
        self._is_settled = False

    def _publish_gimbal(self, time_ns: int) -> None:
        gimbal = self._camera.gimbal
        if gimbal is None:
            return
        is_news = not self._is_settled
        if self._gimbals.is_due(time_ns) or is_news:
            self._state.publish(gimbal_message(self._vehicle, self.name, gimbal, time_ns))
            frame, rotation = mount_of(self._camera, time_ns)
            self._frames.turn(frame, rotation, stamp_of_ns(time_ns))
        self._is_settled = gimbal.is_settled(time_ns)

    def _publisher(self, spec: TopicSpec) -> Publisher:
        return topics.create_publisher(self._node, of_camera(spec, self.name))


def _is_heard(publisher: Publisher) -> bool:
    return publisher.get_subscription_count() > 0
