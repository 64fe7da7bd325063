# SPDX-License-Identifier: Apache-2.0
"""Writers of the recording of a run: MCAP segments in flight, then one indexed file.

A segment has no chunks, so that a flush hands every message to the kernel: a recorder that is
killed leaves a file of which at most the last record is incomplete. A restarted recorder opens
the next segment. `rocsafe_orchestrator.recording.finalising` makes one file of them.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

from mcap.well_known import MessageEncoding, Profile, SchemaEncoding
from mcap.writer import CompressionType, Writer

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.recording.message_definitions import MessageDefinitions

LIBRARY = 'rocsafe_orchestrator'
MISSION_FILE = 'mission.mcap'
SEGMENT_PATTERN = 'mission.part-*.mcap'
# A stamp further ahead of the recorder's clock cannot come from message order.
STAMP_LEAD_LIMIT_NS = NS_PER_S

# Values of rmw's enumerations and its infinite duration, as rosbag2 writes them.
_RMW_KEEP_LAST = 1
_RMW_RELIABLE = 1
_RMW_TRANSIENT_LOCAL = 1
_RMW_VOLATILE = 2
_RMW_LIVELINESS_AUTOMATIC = 1
_RMW_INFINITE = '{sec: 9223372036, nsec: 854775807}'

_CDR_PREFIX_SIZE = 4
_STAMP_SIZE = 8


@dataclass(frozen=True, slots=True, kw_only=True)
class Channel:
    """A topic to record.

    Attributes
    ----------
    topic
        Full name, with its leading slash.
    message_type
        ``<package>/msg/<Name>``.
    depth
        Depth of the publisher's history.
    is_latched
        Whether late subscribers receive the last message (transient local).
    """

    topic: str
    message_type: str
    depth: int = 10
    is_latched: bool = False

    def __post_init__(self) -> None:
        """Refuse relative topic names and types that are no message."""
        if not self.topic.startswith('/'):
            raise ValueError(f"topic {self.topic!r} must start with '/'")
        if len(self.message_type.split('/')) != 3:
            raise ValueError(f'message_type {self.message_type!r} must be <package>/msg/<Name>')
        if self.depth < 1:
            raise ValueError(f'depth {self.depth} must be at least 1')

    def offered_qos_profiles(self) -> str:
        """Return the publisher's quality of service as rosbag2 stores it, a YAML list of one."""
        durability = _RMW_TRANSIENT_LOCAL if self.is_latched else _RMW_VOLATILE
        return (
            f'- history: {_RMW_KEEP_LAST}\n  depth: {self.depth}\n'
            f'  reliability: {_RMW_RELIABLE}\n  durability: {durability}\n'
            f'  deadline: {_RMW_INFINITE}\n  lifespan: {_RMW_INFINITE}\n'
            f'  liveliness: {_RMW_LIVELINESS_AUTOMATIC}\n'
            f'  liveliness_lease_duration: {_RMW_INFINITE}\n'
            '  avoid_ros_namespace_conventions: false'
        )


def stamp_ns(data: bytes) -> int:
    """Return the stamp, ns since the epoch, of a serialised message that starts with a header."""
    order = '<' if data[1] else '>'
    seconds, nanoseconds = struct.unpack_from(f'{order}iI', data, _CDR_PREFIX_SIZE)
    return int(seconds) * NS_PER_S + int(nanoseconds)


class RosWriter:
    """An MCAP file of ROS 2 messages, each type defined in it once.

    Parameters
    ----------
    stream
        File to write to; it is not closed.
    is_indexed
        Whether it is chunked, compressed and indexed.
    """

    def __init__(self, stream: BinaryIO, *, is_indexed: bool) -> None:
        self.mcap = Writer(stream, use_chunking=is_indexed, compression=CompressionType.ZSTD)
        self.mcap.start(profile=Profile.ROS2, library=LIBRARY)
        self._schemas: dict[tuple[str, bytes], int] = {}

    def add_channel(
        self, topic: str, schema: tuple[str, bytes], metadata: Mapping[str, str]
    ) -> int:
        """Add a channel and return its number; `schema` is the type's name and definition."""
        if schema not in self._schemas:
            self._schemas[schema] = self.mcap.register_schema(
                name=schema[0], encoding=SchemaEncoding.ROS2, data=schema[1]
            )
        number: int = self.mcap.register_channel(
            topic=topic,
            message_encoding=MessageEncoding.CDR,
            schema_id=self._schemas[schema],
            metadata=dict(metadata),
        )
        return number


class SegmentWriter:
    """One segment of the recording, in the first free ``mission.part-N.mcap`` of a directory.

    Parameters
    ----------
    directory
        The run directory, made if it is missing.
    definitions
        Where the types of the channels are defined.
    """

    def __init__(self, directory: Path, definitions: MessageDefinitions) -> None:
        directory.mkdir(parents=True, exist_ok=True)
        self.path, self._stream = open_next_segment(directory)
        self._definitions = definitions
        self._writer = RosWriter(self._stream, is_indexed=False)
        self._stamped: dict[int, bool] = {}
        self.message_count = 0

    def add_channel(self, channel: Channel) -> int:
        """Add `channel` and return the number by which `write` knows it.

        Raises
        ------
        DefinitionError
            If the definition of its type is not found.
        """
        text = self._definitions.text(channel.message_type)
        number = self._writer.add_channel(
            channel.topic,
            schema=(channel.message_type, text.encode()),
            metadata={
                'offered_qos_profiles': channel.offered_qos_profiles(),
                'topic_type_hash': self._definitions.type_hash(channel.message_type),
            },
        )
        self._stamped[number] = self._definitions.starts_with_header(channel.message_type)
        return number

    def write(self, number: int, data: bytes, now_ns: int) -> None:
        """Append one serialised message, received at `now_ns`, of channel `number`.

        The stamp of the message is its publish time. The log time is never earlier, although the
        clock may arrive after messages of its time; 0 means that no clock has arrived.
        """
        stamp = now_ns
        if self._stamped[number] and len(data) >= _CDR_PREFIX_SIZE + _STAMP_SIZE:
            stamp = stamp_ns(data) or now_ns
        runs_ahead = not now_ns or 0 < stamp - now_ns <= STAMP_LEAD_LIMIT_NS
        self._writer.mcap.add_message(
            channel_id=number,
            log_time=stamp if runs_ahead else now_ns,
            data=data,
            publish_time=max(stamp, 0),
        )
        self.message_count += 1

    def flush(self) -> None:
        """Hand all data to the kernel, so that they survive the end of this process."""
        self._stream.flush()

    def close(self) -> None:
        """Finish and close the segment."""
        self._writer.mcap.finish()
        self._stream.close()


def segments(directory: Path) -> list[Path]:
    """Return the segments in `directory` in order."""
    return sorted(directory.glob(SEGMENT_PATTERN), key=_number_of)


def _number_of(path: Path) -> int:
    digits = path.stem.rpartition('-')[2]
    return int(digits) if digits.isdigit() else -1


def open_next_segment(directory: Path) -> tuple[Path, BinaryIO]:
    """Create the segment after the last one; two recorders never share a file."""
    number = max((_number_of(path) for path in segments(directory)), default=-1) + 1
    while True:
        path = directory / f'mission.part-{number}.mcap'
        try:
            return path, path.open('xb')
        except FileExistsError:
            number += 1
