# SPDX-License-Identifier: Apache-2.0
"""Records of complete stages and of the content that they were made from."""

import hashlib
import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

# Part of every fingerprint: raise it when set-up itself changes what it makes.
FORMAT = 1
# What colcon reads of a package; with --symlink-install the Python sources are used in place.
BUILD_PATTERNS = (
    '*/package.xml',
    '*/setup.py',
    '*/setup.cfg',
    '*/CMakeLists.txt',
    '*/cmake/*.cmake',
    '*/msg/*.msg',
    '*/srv/*.srv',
    '*/action/*.action',
    '*/resource/*',
)


def fingerprint(*parts: object) -> str:
    """Return a digest of `parts`; for a Path, of the content of its file."""
    digest = hashlib.sha256(f'format {FORMAT}'.encode())
    for part in parts:
        content = part.read_bytes() if isinstance(part, Path) else str(part).encode()
        digest.update(b'%d:' % len(content) + content)
    return digest.hexdigest()[:16]


def build_inputs(sources: Path) -> list[Path]:
    """Return the files that make a new build necessary when they change."""
    return sorted(path for pattern in BUILD_PATTERNS for path in sources.glob(pattern))


def read(path: Path) -> dict[str, Any]:
    """Return the record at `path`, empty if there is none that can be read."""
    try:
        record = json.loads(path.read_text())
    except (OSError, ValueError):
        return {}
    return record if isinstance(record, dict) else {}


def write(path: Path, record: dict[str, Any]) -> None:
    """Write `record` whole or not at all."""
    write_text(path, json.dumps(record, indent=1))


def write_text(path: Path, text: str, mode: int = 0o644) -> None:
    """Write `text` to `path` whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    draft = path.with_name(f'{path.name}.draft')
    draft.write_text(text)
    draft.chmod(mode)
    draft.replace(path)


def forget(paths: Iterable[Path]) -> None:
    """Remove records, before what they stand for is touched."""
    for path in paths:
        path.unlink(missing_ok=True)
