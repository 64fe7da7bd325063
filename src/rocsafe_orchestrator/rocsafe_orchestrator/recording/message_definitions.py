# SPDX-License-Identifier: Apache-2.0
"""Definitions of message types as recordings embed them: the ``ros2msg`` schema encoding.

A recording with its definitions can be read without the packages that made it. The files are
those of the ament index, ``<prefix>/share/<package>/msg/<Name>.msg``, of wheels and of
distributions.
"""

import json
import os
import re
import sys
from collections.abc import Iterable, Iterator
from pathlib import Path

_SEPARATOR = '=' * 80
_HEADER_TYPE = 'std_msgs/Header'
_PRIMITIVES = frozenset(
    {'bool', 'byte', 'char', 'float32', 'float64', 'int8', 'uint8', 'int16', 'uint16', 'int32',
     'uint32', 'int64', 'uint64', 'string', 'wstring'}
)  # fmt: skip
# A field, not a constant: package and name, then the limit of a string or array bounds.
_FIELD = re.compile(r'^(?P<type>[A-Za-z][\w/]*)(?:<=\d+)?(?:\[[^\]]*\])?\s+[A-Za-z]\w*(?!\w|\s*=)')


class DefinitionError(LookupError):
    """A message type has no definition below any prefix."""


class MessageDefinitions:
    """The message definitions found below the prefixes of the ament index.

    Parameters
    ----------
    prefixes
        Folders that hold ``share/<package>``; the first that has a type wins.
    """

    def __init__(self, prefixes: Iterable[Path]) -> None:
        self._prefixes = tuple(prefixes)
        self._texts: dict[str, str] = {}

    @classmethod
    def of_environment(cls) -> 'MessageDefinitions':
        """Look below ``AMENT_PREFIX_PATH`` and, for wheels, the prefix of this Python."""
        listed = os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep)
        return cls([Path(prefix) for prefix in listed if prefix] + [Path(sys.prefix)])

    def text(self, message_type: str) -> str:
        """Return the definition of `message_type` with those of all types it is made of.

        Raises
        ------
        DefinitionError
            If a definition is not found.
        """
        parts = [self._own_text(message_type)]
        for dependency in self._dependencies(message_type):
            short = dependency.replace('/msg/', '/')
            parts.append(f'{_SEPARATOR}\nMSG: {short}\n{self._own_text(dependency)}')
        return '\n'.join(parts)

    def type_hash(self, message_type: str) -> str:
        """Return the REP-2016 hash of `message_type`, empty where its package has none."""
        path = self._find(message_type, '.json')
        if path is None:
            return ''
        for entry in json.loads(path.read_text(encoding='utf-8')).get('type_hashes', []):
            if entry['type_name'] == message_type:
                return str(entry['hash_string'])
        return ''

    def starts_with_header(self, message_type: str) -> bool:
        """Whether the first field is a header, so that serialised messages start with a stamp."""
        return starts_with_header(self._own_text(message_type))

    def _own_text(self, message_type: str) -> str:
        if message_type not in self._texts:
            path = self._find(message_type, '.msg')
            if path is None:
                searched = ', '.join(str(prefix) for prefix in self._prefixes)
                raise DefinitionError(f'no definition of {message_type!r} below {searched}')
            self._texts[message_type] = path.read_text(encoding='utf-8').rstrip('\n') + '\n'
        return self._texts[message_type]

    def _find(self, message_type: str, suffix: str) -> Path | None:
        package, _, name = message_type.split('/')
        relative = Path('share', package, 'msg', name + suffix)
        paths = (prefix / relative for prefix in self._prefixes)
        return next((path for path in paths if path.is_file()), None)

    def _dependencies(self, message_type: str) -> list[str]:
        """Return the types that `message_type` is made of, each once, in order of first use."""
        found: dict[str, None] = {}
        waiting = [message_type]
        while waiting:
            current = waiting.pop(0)
            package = current.split('/')[0]
            for used in _field_types(self._own_text(current)):
                if used in _PRIMITIVES:
                    continue
                full = _full_name(used, package)
                if full not in found and full != message_type:
                    found[full] = None
                    waiting.append(full)
        return list(found)


def starts_with_header(text: str) -> bool:
    """Whether the first field of the definition `text` is a header."""
    return next(_field_types(text), '') == _HEADER_TYPE


def _field_types(text: str) -> Iterator[str]:
    """Yield the type of each field of a definition, without array bounds."""
    for line in text.splitlines():
        match = _FIELD.match(line.split('#')[0].strip())
        if match:
            yield match['type']


def _full_name(field_type: str, package: str) -> str:
    owner, _, name = field_type.rpartition('/')
    return f'{owner or package}/msg/{name}'
