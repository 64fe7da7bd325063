# SPDX-License-Identifier: Apache-2.0
"""MAVLink's message definitions: payload bytes <-> named fields, and the checksum.

The only module that imports pymavlink, and only the tables that are generated from the XML
definitions: the state of its parser can be spoiled by anybody who reaches the socket.
"""

import struct
from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

from pymavlink.dialects.v20 import ardupilotmega as _tables


@dataclass(frozen=True, slots=True)
class Message:
    """One message, in the units of MAVLink.

    Attributes
    ----------
    name
        For instance ``HEARTBEAT``.
    fields
        Values by name: numbers, texts, and lists of numbers.
    system
        System of the sender, 1 to 255.
    component
        Component of the sender, 1 to 255.
    """

    name: str
    fields: Mapping[str, Any]
    system: int = 0
    component: int = 0

    def __getitem__(self, name: str) -> Any:
        return self.fields[name]


def addressed(name: str, target: tuple[int, int], **fields: Any) -> Message:
    """Return a message for `target` (system, component)."""
    return Message(name, {'target_system': target[0], 'target_component': target[1], **fields})


class _Layout:
    """Layout of the fields of one message in its payload."""

    def __init__(self, table: Any) -> None:
        self.name = str(table.msgname)
        self.message_id = int(table.id)
        self.crc_extra = bytes([table.crc_extra])
        self.pack = table.unpacker.pack
        self.unpack = table.unpacker.unpack
        self.size = int(table.unpacker.size)
        self.names = tuple(table.ordered_fieldnames)
        # For struct, a text is one value; an array has as many values as numbers.
        self.counts = tuple(table.lengths)
        self.is_flat = all(count == 1 for count in self.counts)

    @cached_property
    def blank(self) -> dict[str, Any]:
        """The fields of a payload of zeros."""
        return self.fields(b'')

    def fields(self, payload: bytes) -> dict[str, Any]:
        """Return the fields of a payload; zeros at its end may have been cut off."""
        values = self.unpack(payload[: self.size].ljust(self.size, b'\0'))
        if not self.is_flat:
            values = self._grouped(values)
        return {
            name: clean_text(value) if isinstance(value, bytes) else value
            for name, value in zip(self.names, values, strict=True)
        }

    def payload(self, fields: Mapping[str, Any]) -> bytes:
        """Return the payload of `fields`; those not given are zero or empty."""
        values: list[Any] = []
        for name in self.names:
            value = fields.get(name, self.blank[name])
            if isinstance(value, str):
                value = value.encode()
            values.extend(value if isinstance(value, (list, tuple)) else [value])
        return bytes(self.pack(*values))

    def _grouped(self, values: tuple[Any, ...]) -> list[Any]:
        grouped: list[Any] = []
        place = 0
        for count in self.counts:
            one = values[place]
            grouped.append(one if count == 1 else list(values[place : place + count]))
            place += count
        return grouped


class _Event:
    """EVENT of MAVLink's development set, which PX4 sends and the tables do not have."""

    msgname, id, crc_extra = 'EVENT', 410, 160
    unpacker = struct.Struct('<IIHBBB40B')
    ordered_fieldnames = (
        'id',
        'event_time_boot_ms',
        'sequence',
        'destination_component',
        'destination_system',
        'log_levels',
        'arguments',
    )
    lengths = (1, 1, 1, 1, 1, 1, 40)


_BY_ID = {
    number: _Layout(table) for number, table in {_Event.id: _Event, **_tables.mavlink_map}.items()
}
_BY_NAME = {layout.name: layout for layout in _BY_ID.values()}
# Byte added to the checksum of each message, so that both ends use the same definition.
CRC_EXTRAS: Mapping[int, bytes] = {number: layout.crc_extra for number, layout in _BY_ID.items()}


def clean_text(raw: bytes) -> str:
    """Return a text without control codes; what is not UTF-8 is replaced."""
    text = raw.split(b'\0', 1)[0].decode('utf-8', 'replace')
    return ''.join(letter for letter in text if letter.isprintable())


def checksum(data: bytes) -> int:
    """Return CRC-16/MCRF4XX of `data`, which MAVLink calls X.25."""
    return int(_tables.x25crc(data).crc)


def decode(message_id: int, payload: bytes, system: int, component: int) -> Message:
    """Return the message of a payload.

    Raises
    ------
    KeyError
        If no message has this id.
    """
    layout = _BY_ID[message_id]
    return Message(layout.name, layout.fields(payload), system, component)


def encode(message: Message) -> tuple[int, bytes]:
    """Return id and payload; zeros at the end of the payload are not cut off.

    Raises
    ------
    ValueError
        If there is no such message or field, or a value does not fit into its field.
    """
    layout = _BY_NAME.get(message.name)
    if layout is None:
        raise ValueError(f'message {message.name!r} is not known')
    unknown = set(message.fields).difference(layout.names)
    if unknown:
        raise ValueError(f'{message.name} has no field {min(unknown)!r}')
    try:
        return layout.message_id, layout.payload(message.fields)
    except Exception as error:
        # The class of the error depends on the field: struct.error or OverflowError.
        raise ValueError(f'{message.name}: {error}') from error
