# SPDX-License-Identifier: Apache-2.0
"""Compact numbers and byte strings: LEB128, as in protocol buffers."""

from rocsafe_fleet.errors import PacketError

_MOST_BITS = 64


def put_number(into: bytearray, value: int) -> None:
    """Append a number from 0 to below 2**64."""
    if not 0 <= value < 2**_MOST_BITS:
        raise ValueError(f'number is {value}: must be from 0 to below 2**{_MOST_BITS}')
    while value >= 0x80:
        into.append(value & 0x7F | 0x80)
        value >>= 7
    into.append(value)


def put_signed(into: bytearray, value: int) -> None:
    """Append a number of either sign: zigzag, so that small ones are short."""
    put_number(into, value * 2 if value >= 0 else -value * 2 - 1)


def put_bytes(into: bytearray, value: bytes) -> None:
    """Append the length of a byte string, and the string."""
    put_number(into, len(value))
    into += value


class Reader:
    """Reads what the functions above have written.

    Raises
    ------
    PacketError
        In all methods: if the data end too early or a number is too large.
    """

    def __init__(self, data: bytes) -> None:
        self._data = data
        self._at = 0

    @property
    def is_at_end(self) -> bool:
        """Whether all is read."""
        return self._at >= len(self._data)

    def number(self) -> int:
        """Return the next number."""
        value = shift = 0
        while shift < _MOST_BITS:
            byte = self.take(1)[0]
            value |= (byte & 0x7F) << shift
            if byte < 0x80:
                if value >= 2**_MOST_BITS:
                    break
                return value
            shift += 7
        raise PacketError(f'a number has more than {_MOST_BITS} bits')

    def signed(self) -> int:
        """Return the next number of either sign."""
        value = self.number()
        return -(value + 1) // 2 if value & 1 else value // 2

    def text(self) -> bytes:
        """Return the next byte string."""
        return self.take(self.number())

    def take(self, count: int) -> bytes:
        """Return the next `count` bytes."""
        end = self._at + count
        if end > len(self._data):
            raise PacketError(f'data end after {len(self._data)} bytes: {end} are needed')
        found = self._data[self._at : end]
        self._at = end
        return found
