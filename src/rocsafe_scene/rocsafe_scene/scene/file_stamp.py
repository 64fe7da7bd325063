# SPDX-License-Identifier: Apache-2.0
"""Stamps of files, from which names of cache files are made."""

from functools import lru_cache
from hashlib import sha256
from pathlib import Path

_PACKAGE = Path(__file__).resolve().parents[1]
_MAKERS = ('mesh', 'parts', 'ground', 'scene', 'painting')


def stamp(path: str | None) -> str:
    """Return path, size and time of change of a file; empty for no file."""
    if path is None:
        return ''
    try:
        state = Path(path).stat()
    except OSError:
        return f'{path} missing'
    return f'{path} {state.st_size} {state.st_mtime_ns}'


@lru_cache(maxsize=1)
def source_digest() -> str:
    """Return a checksum of the source code that builds and paints scenes."""
    content = sha256()
    for folder in _MAKERS:
        for path in sorted((_PACKAGE / folder).rglob('*.py')):
            content.update(path.read_bytes())
    return content.hexdigest()
