# SPDX-License-Identifier: Apache-2.0
"""Where each vehicle was in a recorded run: its fixes in the recording, one a second."""

import struct
from collections.abc import Iterator
from pathlib import Path
from typing import Any, BinaryIO

from mcap.exceptions import McapError
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

FIX_SUFFIX = '/fix'
FIX_TYPE = 'sensor_msgs/msg/NavSatFix'
STEP_NS = 1_000_000_000
MOST_FIXES = 200_000

Track = dict[str, list[float]]


def tracks_of(recording: Path) -> dict[str, Track]:
    """Return times (s), latitudes and longitudes (degrees) of each vehicle; none if torn."""
    tracks: dict[str, Track] = {}
    try:
        with recording.open('rb') as stream:
            for count, (name, fix) in enumerate(_fixes(stream)):
                if count >= MOST_FIXES:
                    break
                empty: Track = {'time_s': [], 'latitude_deg': [], 'longitude_deg': []}
                track = tracks.setdefault(name, empty)
                track['time_s'].append(fix.header.stamp.sec + fix.header.stamp.nanosec / 1e9)
                track['latitude_deg'].append(fix.latitude)
                track['longitude_deg'].append(fix.longitude)
    except (OSError, McapError, ValueError, struct.error):
        return {}
    return tracks


def _fixes(stream: BinaryIO) -> Iterator[tuple[str, Any]]:
    """Yield name of the vehicle and fix, of each vehicle one a second."""
    reader, factory = make_reader(stream), DecoderFactory()
    summary = reader.get_summary()
    channels = summary.channels.values() if summary else ()
    topics = [c.topic for c in channels if _vehicle_of(c.topic)]
    newest_ns: dict[str, int] = {}
    for schema, channel, message in reader.iter_messages(topics=topics):
        if message.log_time - newest_ns.get(channel.topic, -STEP_NS) < STEP_NS:
            continue
        newest_ns[channel.topic] = message.log_time
        decode = factory.decoder_for(channel.message_encoding, schema)
        if schema is None or schema.name != FIX_TYPE or decode is None:
            continue
        fix = decode(message.data)
        # NaN is not equal to itself: a vehicle without a fix has no place.
        if fix.latitude == fix.latitude:
            yield _vehicle_of(channel.topic), fix


def _vehicle_of(topic: str) -> str:
    """Return the vehicle whose fix a topic is, empty for other topics."""
    name = topic.strip('/').removesuffix(FIX_SUFFIX)
    return name if topic.endswith(FIX_SUFFIX) and '/' not in name else ''
