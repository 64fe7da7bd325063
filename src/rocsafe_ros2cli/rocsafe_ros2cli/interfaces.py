# SPDX-License-Identifier: Apache-2.0
"""Interface types by name: their Python classes, their names in the index, their files."""

import importlib
from pathlib import Path
from typing import Any

from ament_index_python import get_resource, get_resources, has_resource

from rocsafe_ros2cli.command import CommandError

PARTS = {
    'msg': ('SLOT_TYPES',),
    'srv': ('Request', 'Response'),
    'action': ('Goal', 'Result', 'Feedback'),
}
"""What the classes of each kind of interface have."""


def interface_class(name: str, kind: str, complaint: str, other_kind: str = '') -> Any:
    """Return the class of an interface.

    Parameters
    ----------
    name : str
        `package/Name` or `package/kind/Name`.
    kind : str
        `msg`, `srv` or `action`.
    complaint : str
        What to say if there is no such interface.
    other_kind : str
        What to say if it is an interface of another kind; empty: the same.

    Raises
    ------
    CommandError
        With `complaint` or `other_kind`.
    """
    *folders, last = name.split('/')
    if len(folders) == 1:
        folders.append(kind)
    try:
        found = getattr(importlib.import_module('.'.join(folders)), last)
    except (AttributeError, ModuleNotFoundError, ValueError) as error:
        raise CommandError(complaint) from error
    if not all(hasattr(found, part) for part in PARTS[kind]):
        raise CommandError(other_kind or complaint)
    return found


def message_class(name: str) -> Any:
    """Return the class of a message."""
    return interface_class(name, 'msg', 'The passed message type is invalid')


def interface_names(kind: str) -> list[str]:
    """Return `package/kind/Name` of every interface of one kind in the index, in order."""
    names = set()
    for package in get_resources('rosidl_interfaces'):
        content, _ = get_resource('rosidl_interfaces', package)
        for line in content.splitlines():
            stem, _, suffix = line.rpartition('.')
            # Parts of services and actions, such as Name_Request, are not for users.
            if stem.startswith(f'{kind}/') and '_' not in line and suffix in ('idl', kind):
                names.add((package, stem))
    return [f'{package}/{stem}' for package, stem in sorted(names)]


def interface_file(name: str) -> Path:
    """Return the file that defines the interface `package/kind/Name`.

    Raises
    ------
    CommandError
        If the name is malformed, or the package or the interface is not there.
    """
    parts = name.split('/')
    if len(parts) != 3:
        raise CommandError(f"Invalid name '{name}'. Expected three parts separated by '/'")
    if not all(parts):
        raise CommandError(f"Invalid name '{name}'. Must not contain empty parts")
    if '..' in parts:
        raise CommandError(f"Invalid name '{name}'. Must not contain '..'")
    package, kind, _ = parts
    prefix = has_resource('packages', package)
    if not prefix:
        raise CommandError(f"Unknown package '{package}'")
    stem = Path(prefix) / 'share' / name
    suffixes = ('',) if '.' in stem.name else (f'.{kind}', '.idl')
    candidates = [stem.with_name(stem.name + suffix) for suffix in suffixes]
    for candidate in candidates:
        if candidate.exists():
            return candidate
    raise CommandError(f"Could not find the interface '{candidates[-1]}'")
