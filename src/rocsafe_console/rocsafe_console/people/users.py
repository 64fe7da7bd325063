# SPDX-License-Identifier: Apache-2.0
"""The users and their file: YAML, one user a name, readable by its owner only."""

import re
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path

import yaml

from rocsafe_console.errors import ConsoleError
from rocsafe_console.people.passwords import NOBODY, is_right
from rocsafe_console.people.roles import Role
from rocsafe_geo.storage.durable import write_whole
from rocsafe_geo.storage.secret_file import SecretFileError, read_secret
from rocsafe_geo.storage.yaml_source import YamlError, parse_yaml

_NAME = re.compile(r'[A-Za-z0-9][A-Za-z0-9._-]{0,31}')
_HASH = re.compile(r'\$argon2id\$v=19\$m=\d+,t=\d+,p=\d+\$[A-Za-z0-9+/]+\$[A-Za-z0-9+/]+')

# Some thousand users.
LARGEST = 2**20


@dataclass(frozen=True, slots=True, kw_only=True)
class User:
    """Somebody who may log in."""

    name: str
    role: Role
    password_hash: str

    def __post_init__(self) -> None:
        if not _NAME.fullmatch(self.name):
            raise ValueError(
                f'user {self.name!r}: a name must be up to 32 letters, digits, ".", "_" and "-"'
            )
        if not _HASH.fullmatch(self.password_hash):
            raise ValueError(f'user {self.name}: password_hash is no Argon2id hash')


class Users:
    """The users by name.

    Parameters
    ----------
    path
        Their file; None: they never change.
    """

    def __init__(self, users: Mapping[str, User], path: Path | None = None) -> None:
        self._users = dict(users)
        self._path = path
        self._read_ns = _changed_ns(path)

    def changed(self) -> list[str]:
        """Read the file again if it is another one; return the users who are not as before.

        A file that cannot be read, or has no user, changes nothing.
        """
        now_ns = _changed_ns(self._path)
        if self._path is None or now_ns == self._read_ns:
            return []
        self._read_ns = now_ns
        try:
            after = read_users(self._path)
        except ConsoleError:
            return []
        before, self._users = self._users, after or self._users
        return [name for name, user in before.items() if self._users.get(name) != user]

    def __len__(self) -> int:
        return len(self._users)

    def unknown(self, names: Iterable[str]) -> list[str]:
        """Return those of some names that no user has; none where nobody logs in by name."""
        return [name for name in names if name and self._users and name not in self._users]

    def log_in(self, name: str, password: str) -> User | None:
        """Return the user if the password is right; takes as long for a name that is not there."""
        user = self._users.get(name)
        right = is_right(password, user.password_hash if user else NOBODY)
        return user if right else None


def _changed_ns(path: Path | None) -> int:
    try:
        return path.stat().st_mtime_ns if path is not None else 0
    except OSError:
        return 0


def read_users(path: Path) -> dict[str, User]:
    """Return the users in a file.

    Raises
    ------
    ConsoleError
        Naming the file, and what is wrong with it or with its mode.
    """
    try:
        content = parse_yaml(read_secret(path, LARGEST).decode(), str(path)) or {}
        entries = content['users']
        return {
            name: User(name=name, role=Role(entry['role']), password_hash=entry['password_hash'])
            for name, entry in entries.items()
        }
    except SecretFileError as error:
        raise ConsoleError(str(error)) from error
    except (YamlError, ValueError) as error:
        raise ConsoleError(f'{path}: {error}') from error
    except (KeyError, TypeError, AttributeError) as error:
        raise ConsoleError(
            f'{path}: must have the key users, with role and password_hash of each: {error}'
        ) from error


def write_users(path: Path, users: Mapping[str, User]) -> None:
    """Write the file, readable by its owner only."""
    content = {
        'users': {
            user.name: {'role': user.role.value, 'password_hash': user.password_hash}
            for user in users.values()
        }
    }
    if not path.exists():
        path.touch(mode=0o600)
    write_whole(path, yaml.safe_dump(content, sort_keys=True).encode())
    path.chmod(0o600)
