# SPDX-License-Identifier: Apache-2.0
"""Fields and bytes agree with pymavlink's own codec for every message."""

import pytest
from pymavlink.dialects.v20 import ardupilotmega as library

from rocsafe_mavlink.wire.dialect import Message, clean_text, decode, encode
from rocsafe_mavlink.wire.framing import pack_frame, scan


class Wire(list):
    """What a library object writes to."""

    def write(self, data):
        """Keep one packet."""
        self.append(data)


def by_library(name, fields):
    """Return the bytes of the library for a message from 1/1."""
    kind = next(kind for kind in library.mavlink_map.values() if kind.msgname == name)
    filled = {
        field: value.encode() if isinstance(value, str) else value
        for field, value in fields.items()
    }
    return kind(**filled).pack(library.MAVLink(Wire(), srcSystem=1, srcComponent=1))


def sample(name):
    """Return fields with a different value each."""
    number = next(key for key, kind in library.mavlink_map.items() if kind.msgname == name)
    blank = decode(number, b'', 1, 1).fields
    fields = {}
    for count, (field, value) in enumerate(blank.items(), start=1):
        if isinstance(value, str):
            fields[field] = 'ab'
        elif isinstance(value, list):
            fields[field] = [(count + place) % 100 for place in range(len(value))]
        else:
            fields[field] = count % 100
    return fields


def test_codec_agrees_with_the_library():
    """Every message has the library's bytes, and comes back from them."""
    for name in sorted(kind.msgname for kind in library.mavlink_map.values()):
        fields = sample(name)
        number, payload = encode(Message(name, fields))
        ours = pack_frame(number, payload, 1, 1, 0, sign=False)
        assert ours == by_library(name, fields), name
        found = scan(ours, is_whole=True).frames[0]
        back = decode(found.message_id, found.payload, 1, 1).fields
        texts = {field for field, value in fields.items() if isinstance(value, str)}
        numbers = fields.keys() - texts
        assert {key: back[key] for key in numbers} == {key: fields[key] for key in numbers}, name
        assert set(back) == set(fields), name


def test_text_is_cleaned():
    """A text ends at its first zero and keeps nothing that could move a terminal."""
    assert clean_text(b'Arm: \x1b[2Jno\nGPS\xff\0rest') == 'Arm: [2JnoGPS\N{REPLACEMENT CHARACTER}'


@pytest.mark.parametrize(
    ('message', 'words'),
    [
        (Message('NONSENSE', {}), "message 'NONSENSE' is not known"),
        (Message('HEARTBEAT', {'speed': 1}), "HEARTBEAT has no field 'speed'"),
        (Message('HEARTBEAT', {'type': 300}), 'HEARTBEAT: '),
        (Message('GLOBAL_POSITION_INT', {'lat': 0.5}), 'GLOBAL_POSITION_INT: '),
    ],
)
def test_wrong_message_is_refused(message, words):
    """What cannot be encoded is refused by name."""
    with pytest.raises(ValueError, match=words):
        encode(message)
