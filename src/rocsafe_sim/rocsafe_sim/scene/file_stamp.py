# SPDX-License-Identifier: Apache-2.0
"""What tells a changed file, for the names of what is kept of it."""

from pathlib import Path


def stamp(path: str | None) -> str:
    """Return what tells a changed file without reading it; empty for none."""
    if path is None:
        return ''
    try:
        state = Path(path).stat()
    except OSError:
        return f'{path} missing'
    return f'{path} {state.st_size} {state.st_mtime_ns}'
