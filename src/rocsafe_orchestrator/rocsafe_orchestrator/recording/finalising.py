# SPDX-License-Identifier: Apache-2.0
"""Merges the segments of the recorder into one indexed recording.

Segments may be torn at the end (their recorder was killed) and may repeat messages (a restarted
node publishes again what it had published). Both are corrected and counted here. Only positions
are held in memory, so a recording may be larger than the memory.
"""

import hashlib
import mmap
import os
import struct
from collections import Counter
from collections.abc import Collection, Iterable, Iterator, Sequence
from dataclasses import dataclass
from io import BytesIO
from pathlib import Path

from mcap.data_stream import ReadDataStream
from mcap.exceptions import McapError
from mcap.opcode import Opcode
from mcap.reader import McapReader, make_reader
from mcap.records import Channel as ChannelRecord
from mcap.records import Schema as SchemaRecord
from mcap.writer import MCAP0_MAGIC, Writer

from rocsafe_geo.storage.durable import finish_part, part_of
from rocsafe_orchestrator.recording import segments as recording
from rocsafe_orchestrator.recording.message_definitions import starts_with_header
from rocsafe_orchestrator.recording.segments import MISSION_FILE, RosWriter

_FRAME = struct.Struct('<BQ')
_MESSAGE_HEAD = struct.Struct('<HIQQ')
_DIGEST_SIZE = 16
_LATCHED_MARK = 'durability: 1\n'


@dataclass(frozen=True, slots=True, kw_only=True)
class FinalisedRecording:
    """The merged recording.

    Attributes
    ----------
    path
        Path of the recording.
    segment_count
        Number of segments merged; 0 if the recording existed.
    message_count
        Number of messages.
    duplicate_count
        Number of repeated messages left out.
    torn_bytes
        Bytes of incomplete records at the ends of segments.
    """

    path: Path
    segment_count: int
    message_count: int
    duplicate_count: int
    torn_bytes: int


@dataclass(frozen=True, slots=True, kw_only=True)
class _Source:
    """A channel as one segment knows it."""

    topic: str
    schema_name: str
    schema_text: bytes
    metadata: tuple[tuple[str, str], ...]

    @property
    def drops_repeats(self) -> bool:
        """Whether equal bytes are the same message: they hold a stamp, or are latched."""
        latched = _LATCHED_MARK in dict(self.metadata).get('offered_qos_profiles', '')
        return latched or starts_with_header(self.schema_text.decode())


@dataclass(frozen=True, slots=True, order=True)
class _Position:
    """Where a message lies; sorts by time, then topic, then order of arrival."""

    log_time_ns: int
    topic: str
    segment: int
    offset: int
    length: int
    publish_time_ns: int
    channel: int


class _Segment:
    """A segment mapped into memory, and its channels."""

    def __init__(self, path: Path, number: int) -> None:
        self._number = number
        self._data: bytes | mmap.mmap = b''
        if path.stat().st_size:
            with path.open('rb') as stream:
                self._data = mmap.mmap(stream.fileno(), 0, access=mmap.ACCESS_READ)
        self._schemas: dict[int, SchemaRecord] = {}
        self.channels: dict[int, _Source] = {}
        self.torn_bytes = 0

    def positions(self) -> Iterator[_Position]:
        """Yield the position of each whole message; afterwards `torn_bytes` is known."""
        for opcode, start, length in self._records():
            if opcode == Opcode.MESSAGE and length >= _MESSAGE_HEAD.size:
                yield self._position(start, length)
            elif opcode == Opcode.SCHEMA:
                schema = SchemaRecord.read(self._content(start, length))
                self._schemas[schema.id] = schema
            elif opcode == Opcode.CHANNEL:
                self._add_channel(ChannelRecord.read(self._content(start, length)))
            elif opcode == Opcode.DATA_END:
                return

    def message(self, position: _Position) -> bytes:
        """Return the serialised message at `position`."""
        return self._data[position.offset : position.offset + position.length]

    def _records(self) -> Iterator[tuple[int, int, int]]:
        offset, size = len(MCAP0_MAGIC), len(self._data)
        while offset + _FRAME.size <= size:
            opcode, length = _FRAME.unpack_from(self._data, offset)
            start = offset + _FRAME.size
            if start + length > size:
                break
            yield opcode, start, length
            offset = start + length
        self.torn_bytes = max(size - offset, 0)

    def _content(self, start: int, length: int) -> ReadDataStream:
        return ReadDataStream(BytesIO(self._data[start : start + length]))

    def _add_channel(self, channel: ChannelRecord) -> None:
        schema = self._schemas[channel.schema_id]
        self.channels[channel.id] = _Source(
            topic=channel.topic,
            schema_name=schema.name,
            schema_text=schema.data,
            metadata=tuple(sorted(channel.metadata.items())),
        )

    def _position(self, start: int, length: int) -> _Position:
        channel, _, log_time, publish_time = _MESSAGE_HEAD.unpack_from(self._data, start)
        return _Position(
            log_time_ns=log_time,
            topic=self.channels[channel].topic,
            segment=self._number,
            offset=start + _MESSAGE_HEAD.size,
            length=length - _MESSAGE_HEAD.size,
            publish_time_ns=publish_time,
            channel=channel,
        )


def finalise(directory: Path, attachments: Iterable[Path] = ()) -> FinalisedRecording | None:
    """Write ``mission.mcap`` from the segments in `directory`, then remove them.

    May be repeated, also after an interruption: no message is lost or doubled.

    Parameters
    ----------
    directory
        The run directory.
    attachments
        Small files to store in the recording; missing ones are left out.

    Returns
    -------
    FinalisedRecording or None
        None if there are no segments.
    """
    path = directory / MISSION_FILE
    if not recording.segments(directory):
        return None
    if path.is_file():
        _reopen(path, directory)
    paths = recording.segments(directory)
    merged = merge(paths, path, attachments)
    for part in paths:
        part.unlink()
    return merged


def merge(
    paths: Sequence[Path],
    path: Path,
    attachments: Iterable[Path] = (),
    kinds: Collection[str] = (),
) -> FinalisedRecording:
    """Write the recording at `path` from segments, whose recorder may still be at work.

    `kinds` are the types of messages that are wanted; none: all.
    """
    opened = [_Segment(part, number) for number, part in enumerate(paths)]
    positions = sorted(
        position
        for segment in opened
        for position in segment.positions()
        if not kinds or segment.channels[position.channel].schema_name in kinds
    )
    kept = list(_without_repeats(opened, positions))
    with part_of(path).open('wb') as stream:
        writer = RosWriter(stream, is_indexed=True)
        _write_messages(writer, opened, kept)
        _write_attachments(writer.mcap, attachments, kept)
        writer.mcap.finish()
        stream.flush()
        os.fsync(stream.fileno())
    finish_part(path)
    return FinalisedRecording(
        path=path,
        segment_count=len(paths),
        message_count=len(kept),
        duplicate_count=len(positions) - len(kept),
        torn_bytes=sum(segment.torn_bytes for segment in opened),
    )


def _without_repeats(
    opened: list[_Segment], positions: Iterable[_Position]
) -> Iterator[_Position]:
    """Leave out messages that repeat an earlier one of the same topic, stamp included."""
    seen: set[bytes] = set()
    drops = {
        (number, channel): source.drops_repeats
        for number, segment in enumerate(opened)
        for channel, source in segment.channels.items()
    }
    for position in positions:
        if drops[position.segment, position.channel]:
            digest = hashlib.blake2b(position.topic.encode(), digest_size=_DIGEST_SIZE)
            digest.update(opened[position.segment].message(position))
            if digest.digest() in seen:
                continue
            seen.add(digest.digest())
        yield position


def _write_messages(writer: RosWriter, opened: list[_Segment], positions: list[_Position]) -> None:
    numbers: dict[_Source, int] = {}
    sequences: Counter[int] = Counter()
    used = {opened[position.segment].channels[position.channel] for position in positions}
    for source in sorted(used, key=lambda source: source.topic):
        numbers[source] = writer.add_channel(
            source.topic, (source.schema_name, source.schema_text), dict(source.metadata)
        )
    for position in positions:
        segment = opened[position.segment]
        number = numbers[segment.channels[position.channel]]
        sequences[number] += 1
        writer.mcap.add_message(
            channel_id=number,
            log_time=position.log_time_ns,
            data=segment.message(position),
            publish_time=position.publish_time_ns,
            sequence=sequences[number],
        )


def _write_attachments(
    writer: Writer, attachments: Iterable[Path], positions: list[_Position]
) -> None:
    time_ns = positions[-1].log_time_ns if positions else 0
    for path in attachments:
        if path.is_file():
            writer.add_attachment(
                create_time=time_ns,
                log_time=time_ns,
                name=path.name,
                media_type='application/octet-stream',
                data=path.read_bytes(),
            )


def _reopen(path: Path, directory: Path) -> None:
    """Turn a recording back into a segment after an interrupted merge.

    Raises
    ------
    ValueError
        If the file is no recording.
    """
    try:
        with path.open('rb') as source:
            _, stream = recording.open_next_segment(directory)
            with stream:
                _copy(make_reader(source), RosWriter(stream, is_indexed=False))
    except McapError as error:
        raise ValueError(f'{path} is no recording: {error}') from error


def _copy(reader: McapReader, writer: RosWriter) -> None:
    numbers: dict[int, int] = {}
    for schema, channel, message in reader.iter_messages():
        if channel.id not in numbers:
            numbers[channel.id] = writer.add_channel(
                channel.topic, (schema.name, schema.data), channel.metadata
            )
        writer.mcap.add_message(
            channel_id=numbers[channel.id],
            log_time=message.log_time,
            data=message.data,
            publish_time=message.publish_time,
        )
