# SPDX-License-Identifier: Apache-2.0
"""Sessions on disk, so that a page goes on by itself after the server was killed.

Only hashes of the secrets are written, readable by their owner; a file that cannot be read is as
none: users log in again.
"""

import json
from collections.abc import Mapping
from pathlib import Path

from rocsafe_console.people.roles import Role
from rocsafe_console.people.sessions import Sessions
from rocsafe_geo.storage.durable import part_of, replace_whole
from rocsafe_geo.storage.secret_file import SecretFileError, read_secret

NAME = 'console-sessions.json'
# Some hundred bytes a session.
LARGEST = 2**20


def save_sessions(folder: Path, sessions: Sessions) -> None:
    """Write the sessions to a folder; raises `OSError`."""
    path = folder / NAME
    part_of(path).touch(mode=0o600)
    replace_whole(path, json.dumps(sessions.to_plain()).encode())


def load_sessions(folder: Path, sessions: Sessions, roles: Mapping[str, Role]) -> None:
    """Take over the sessions in a folder, of users who still have their role."""
    try:
        sessions.restore(json.loads(read_secret(folder / NAME, LARGEST)), roles)
    except (SecretFileError, ValueError, KeyError, TypeError, AttributeError):
        return
