# SPDX-License-Identifier: Apache-2.0
"""Qualities of service that the topics of ROCSAFE are published with."""

from rclpy.duration import Duration
from rclpy.qos import DurabilityPolicy, LivelinessPolicy, QoSProfile, ReliabilityPolicy

# One minute of one vehicle's readings at 10 Hz, for a subscriber that falls behind.
STREAM_DEPTH = 600
# Measurements that pass at full speed during the discovery of a subscriber; more would only fill
# an operator's `ros2 topic echo` with history.
MEASUREMENTS_KEPT = 50
# Images are large; a subscriber that was away for longer finds them in the image store.
PICTURES_KEPT = 8
# States that a recorder which falls behind does not miss: at full speed several come at once.
STATES_KEPT = 10
# All decisions of a mission, so that a late subscriber gets all of them.
DECISIONS_KEPT = 500
# A vehicle without a heartbeat for this long is taken for lost.
HEARTBEAT_LEASE_S = 2.0


def stream() -> QoSProfile:
    """Return a stream of which a subscriber that falls behind loses nothing for a minute."""
    return QoSProfile(depth=STREAM_DEPTH, reliability=ReliabilityPolicy.RELIABLE)


def newest() -> QoSProfile:
    """Return a stream of orders each of which replaces the ones before: none is followed late."""
    return QoSProfile(depth=STATES_KEPT, reliability=ReliabilityPolicy.RELIABLE)


def kept(depth: int = MEASUREMENTS_KEPT) -> QoSProfile:
    """Return a stream whose last `depth` messages also reach late subscribers.

    A recorder or field that is started again, or discovers a vehicle late, misses nothing.
    Subscribers that do not ask for transient local messages are served as by any stream.
    """
    return QoSProfile(
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE,
        durability=DurabilityPolicy.TRANSIENT_LOCAL,
    )


def pictures() -> QoSProfile:
    """Return a stream of images, which are large."""
    return QoSProfile(depth=PICTURES_KEPT, reliability=ReliabilityPolicy.RELIABLE)


def radio() -> QoSProfile:
    """Return a stream whose lost messages are not sent again: who sends repairs that itself."""
    return QoSProfile(depth=MEASUREMENTS_KEPT, reliability=ReliabilityPolicy.BEST_EFFORT)


def latched() -> QoSProfile:
    """Return a stream whose last message also reaches late subscribers."""
    return kept(1)


def heartbeat() -> QoSProfile:
    """Return a kept stream whose silence its subscribers are told of."""
    profile = kept(STATES_KEPT)
    profile.liveliness = LivelinessPolicy.AUTOMATIC
    profile.liveliness_lease_duration = Duration(seconds=HEARTBEAT_LEASE_S)
    profile.deadline = Duration(seconds=HEARTBEAT_LEASE_S)
    return profile
