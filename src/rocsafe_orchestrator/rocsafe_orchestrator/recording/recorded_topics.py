# SPDX-License-Identifier: Apache-2.0
"""Which topics a run records, as channels of its recording.

Left out: ``camera/image_raw`` (its JPEG is recorded), ``camera/shot`` (its photographs are stored
one by one), ``path`` (the fixes hold it), ``dose_rate`` (the readings hold it), ``/clock`` and the
lock-step (log times hold them).
"""

from collections.abc import Iterable, Iterator

from rocsafe_orchestrator.recording.segments import Channel
from rocsafe_ros import topics
from rocsafe_ros.topics import TopicSpec

VEHICLE_TOPICS: tuple[TopicSpec, ...] = (
    topics.FIX,
    topics.GROUND_TRUTH_FIX,
    topics.VELOCITY,
    topics.ODOM,
    topics.BATTERY_STATE,
    topics.STATE,
    topics.RADIATION,
    topics.ACCUMULATED_DOSE,
    topics.DOSE_ALARM,
    topics.GAS,
    topics.BIO,
    topics.ANEMOMETER,
    topics.CAMERA_IMAGE_COMPRESSED,
    topics.CAMERA_INFO,
    topics.ROUTE_MARKERS,
)
FLEET_TOPICS: tuple[TopicSpec, ...] = (
    topics.REGION,
    topics.PLAN,
    topics.MISSION_STATE,
    topics.RECEIPTS,
    topics.HAZARD_SOURCES,
    topics.DOSE_MAP,
    topics.CORDONS,
    topics.BELIEF_MAP,
    topics.MOSAIC,
    topics.SCENE_MARKERS,
    topics.DIAGNOSTICS,
)
# Every vehicle publishes these from its start, so a recorder may wait until it hears them.
AWAITED_TOPICS: tuple[TopicSpec, ...] = (topics.FIX, topics.STATE, topics.RADIATION)


# Of every camera; gimbals are among them where there are any.
CAMERA_TOPICS: tuple[TopicSpec, ...] = (
    topics.CAMERA_IMAGE_COMPRESSED,
    topics.CAMERA_INFO,
    topics.GIMBAL_STATE,
)


def recorded_topics(
    vehicles: Iterable[str], other_cameras: Iterable[str] = ()
) -> Iterator[tuple[TopicSpec, str]]:
    """Yield each topic to record with the vehicle it belongs to, empty for the fleet's.

    `other_cameras` are the names of the vehicles' cameras besides the first.
    """
    cameras = tuple(other_cameras)
    for vehicle in vehicles:
        for spec in VEHICLE_TOPICS:
            yield spec, vehicle
        for camera in cameras:
            for spec in CAMERA_TOPICS:
                yield topics.of_camera(spec, camera), vehicle
    for spec in FLEET_TOPICS:
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
