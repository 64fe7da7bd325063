# SPDX-License-Identifier: Apache-2.0
"""Wheel files as mappings of their members (the binary distribution format of PyPA)."""

import base64
import hashlib
import zipfile
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

# The earliest time that a zip file can hold: same content, same bytes.
_EPOCH = (1980, 1, 1, 0, 0, 0)
_REGULAR_FILE = 0o100000


@dataclass(frozen=True, slots=True, kw_only=True)
class Member:
    """A file of a wheel."""

    content: bytes
    mode: int = 0o644


def read_wheel(path: Path) -> dict[str, Member]:
    """Return the members of a wheel but its RECORD."""
    with zipfile.ZipFile(path) as archive:
        return {
            item.filename: Member(
                content=archive.read(item), mode=(item.external_attr >> 16) & 0o777 or 0o644
            )
            for item in archive.infolist()
            if not item.is_dir() and not item.filename.endswith('.dist-info/RECORD')
        }


def write_wheel(path: Path, info: str, members: Mapping[str, Member]) -> None:
    """Write a wheel with its RECORD.

    Parameters
    ----------
    path
        Its name, which tells the installer package, version and machine.
    info
        Name of its folder of metadata, ``<package>-<version>.dist-info``.
    members
        By their names inside the wheel, without RECORD.
    """
    record = f'{info}/RECORD'
    lines = [_record_line(name, member.content) for name, member in sorted(members.items())]
    text = ''.join([*lines, f'{record},,\n'])
    written = {**members, record: Member(content=text.encode())}
    with zipfile.ZipFile(path, 'w', zipfile.ZIP_DEFLATED) as archive:
        for name, member in sorted(written.items()):
            item = zipfile.ZipInfo(name, _EPOCH)
            item.external_attr = (_REGULAR_FILE | member.mode) << 16
            item.compress_type = zipfile.ZIP_DEFLATED
            archive.writestr(item, member.content)


def _record_line(name: str, content: bytes) -> str:
    digest = base64.urlsafe_b64encode(hashlib.sha256(content).digest()).rstrip(b'=').decode()
    return f'{name},sha256={digest},{len(content)}\n'
