# SPDX-License-Identifier: Apache-2.0
"""MessagePack-RPC as AirSim's clients speak it: requests out of bytes, answers into bytes.

A request is ``[0, id, method, parameters]`` and its answer ``[1, id, error, result]``; a
notification is ``[2, method, parameters]``.
"""

from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import msgpack
import numpy as np
from numpy.typing import NDArray

from rocsafe_airsim.errors import ProtocolError

REQUEST, ANSWER, NOTIFICATION = 0, 1, 2
LARGEST_BYTES = 16 * 1024 * 1024
# An array or map is allocated when its length is read, before its elements arrive.
MOST_ELEMENTS = 20_000
DEEPEST = 32
LONGEST_NAME = 100
_LAST_ID = 2**32 - 1


@dataclass(frozen=True, slots=True, kw_only=True)
class Call:
    """A call of a method; `call_id` is None for a notification, which has no answer."""

    call_id: int | None
    method: str
    arguments: tuple[Any, ...]


class CallReader:
    """Turns the bytes of one connection into calls, whatever the pieces in which they come."""

    def __init__(self) -> None:
        self._unpacker = msgpack.Unpacker(
            raw=False,
            strict_map_key=False,
            max_buffer_size=LARGEST_BYTES,
            max_array_len=MOST_ELEMENTS,
            max_map_len=MOST_ELEMENTS,
            max_bin_len=LARGEST_BYTES,
            max_str_len=LARGEST_BYTES,
            unicode_errors='replace',
        )

    def feed(self, data: bytes) -> Iterator[Call]:
        """Yield the calls that are complete with `data`.

        Raises
        ------
        ProtocolError
            If the bytes are no calls, or a message exceeds a limit. Nothing can be read after it.
        """
        try:
            self._unpacker.feed(data)
            for message in self._unpacker:
                yield _call(message)
        except ProtocolError:
            raise
        except (ValueError, TypeError, msgpack.UnpackException, RecursionError) as error:
            # TypeError: a map whose key is a map or an array.
            text = str(error) or type(error).__name__
            raise ProtocolError(f'no MessagePack-RPC: {text}') from error


def answer(call_id: int, result: Any) -> bytes:
    """Return the answer to a call."""
    return _packed([ANSWER, call_id, None, result])


def refusal(call_id: int, text: str) -> bytes:
    """Return the answer to a call that is not carried out."""
    return _packed([ANSWER, call_id, text, None])


def _packed(message: list[Any]) -> bytes:
    try:
        return bytes(msgpack.packb(message, use_bin_type=True))
    except TypeError:
        # It holds an array of floats.
        return b''.join(_parts(message))


def _parts(value: Any) -> Iterator[bytes]:
    """Yield the bytes of a value with arrays in it; an array becomes a list of its floats."""
    packer = msgpack.Packer()
    if isinstance(value, np.ndarray):
        yield packer.pack_array_header(value.size)
        yield _floats(value)
    elif isinstance(value, list):
        yield packer.pack_array_header(len(value))
        for each in value:
            yield from _parts(each)
    elif isinstance(value, dict):
        yield packer.pack_map_header(len(value))
        for key, each in value.items():
            yield from _parts(key)
            yield from _parts(each)
    else:
        yield bytes(msgpack.packb(value, use_bin_type=True))


def _floats(values: NDArray[np.floating[Any]]) -> bytes:
    """Return numbers as MessagePack has floats of 32 bits, without a Python object for each."""
    packed = np.empty(values.size, np.dtype([('head', 'u1'), ('value', '>f4')]))
    packed['head'], packed['value'] = 0xCA, values.ravel()
    return packed.tobytes()


def _call(message: Any) -> Call:
    if not isinstance(message, list) or not message:
        raise ProtocolError(f'a message is {_short(message)}: must be an array')
    kind, *rest = message
    if kind == REQUEST and len(rest) == 3:
        call_id, method, arguments = rest
        if isinstance(call_id, bool) or not isinstance(call_id, int):
            raise ProtocolError(f'the id of a call is {_short(call_id)}: must be a number')
        if not 0 <= call_id <= _LAST_ID:
            raise ProtocolError(f'the id of a call is {call_id}: must be within 0 and {_LAST_ID}')
    elif kind == NOTIFICATION and len(rest) == 2:
        call_id = None
        method, arguments = rest
    else:
        raise ProtocolError(f'a message is {_short(message)}: must be a call')
    if not isinstance(method, str) or len(method) > LONGEST_NAME:
        raise ProtocolError(f'the method of a call is {_short(method)}: must be a name')
    if not isinstance(arguments, list):
        raise ProtocolError(
            f'the parameters of {method} are {_short(arguments)}: must be an array'
        )
    _require_shallow(arguments, DEEPEST)
    return Call(call_id=call_id, method=method, arguments=tuple(arguments))


def _require_shallow(value: Any, left: int) -> None:
    if not left:
        raise ProtocolError(f'a message is nested more than {DEEPEST} levels deep')
    if isinstance(value, list):
        for each in value:
            _require_shallow(each, left - 1)
    elif isinstance(value, dict):
        for each in value.values():
            _require_shallow(each, left - 1)


def _short(value: Any) -> str:
    text = repr(value)
    return text if len(text) <= 80 else f'{text[:77]}...'
