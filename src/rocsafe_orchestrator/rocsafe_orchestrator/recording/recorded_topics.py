# SPDX-License-Identifier: Apache-2.0
"""Topics that a run records, as channels of its recording: all but those of `LEFT_OUT`."""

from collections.abc import Iterable, Iterator

from rocsafe_orchestrator.recording.segments import Channel
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import Scope, TopicSpec, of_camera

LEFT_OUT: dict[str, str] = {
    topics.CAMERA_IMAGE.name: 'its JPEG is recorded; taken only while somebody looks',
    topics.CAMERA_DEPTH.name: 'drawn only while somebody looks',
    topics.CAMERA_LABELS.name: 'drawn only while somebody looks',
    topics.SHOT.name: 'the image store has each photograph with its record',
    topics.DOSE_RATE.name: 'the same readings in another unit',
    **dict.fromkeys(
        (spec.name for spec in (topics.IMU, topics.BAROMETER, topics.MAGNETOMETER, topics.RANGE)),
        'many in a second; they follow from seed and flight, and `ros2 bag record` takes them',
    ),
    topics.STEP_DONE.name: 'the clock tells when a step was done',
}
"""Topics that are not recorded, each with its reason."""

REAL_ONLY = frozenset(
    spec.name for spec in (topics.REL_ALT, topics.HEADING, topics.PREDICTED_FIX, topics.EVENTS)
)
# Every vehicle publishes these from its start, so a recorder may wait until it hears them.
AWAITED_TOPICS: tuple[TopicSpec, ...] = (topics.FIX, topics.STATE, topics.RADIATION)
# Topics of every camera but the first; gimbals are among them where there are any.
CAMERA_TOPICS: tuple[TopicSpec, ...] = (
    topics.CAMERA_IMAGE_COMPRESSED,
    topics.CAMERA_INFO,
    topics.CAMERA_POSE,
    topics.GIMBAL_COMMAND,
    topics.GIMBAL_STATE,
)


def recorded_topics(
    vehicles: Iterable[str], other_cameras: Iterable[str] = (), real_vehicles: Iterable[str] = ()
) -> Iterator[tuple[TopicSpec, str]]:
    """Yield each topic to record with the vehicle it belongs to, empty for the fleet's.

    Parameters
    ----------
    vehicles
        Names of all vehicles.
    other_cameras
        Names of the vehicles' cameras besides the first.
    real_vehicles
        Those of `vehicles` that are no simulation: they have topics that others lack.
    """
    cameras, real = tuple(other_cameras), frozenset(real_vehicles)
    kept = [spec for spec in topics.TOPICS if spec.name not in LEFT_OUT]
    for vehicle in vehicles:
        for spec in kept:
            is_here = spec.name not in REAL_ONLY or vehicle in real
            if spec.scope is Scope.VEHICLE and is_here:
                yield spec, vehicle
        for camera in cameras:
            for spec in CAMERA_TOPICS:
                yield of_camera(spec, camera), vehicle
    for spec in kept:
        if spec.scope is Scope.FLEET:
            yield spec, ''


def channel_of(spec: TopicSpec, full_name: str) -> Channel:
    """Return the channel that records `spec`, resolved to `full_name`."""
    package = spec.message_type.__module__.partition('.')[0]
    return Channel(
        topic=full_name,
        message_type=f'{package}/msg/{spec.message_type.__name__}',
        depth=max(spec.qos.depth, 1),
        is_latched=spec.qos.durability.name == 'TRANSIENT_LOCAL',
    )
