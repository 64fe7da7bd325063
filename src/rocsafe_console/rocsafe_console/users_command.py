# SPDX-License-Identifier: Apache-2.0
"""`rocsafe users`: adds and removes users of the console, and lists them."""

import argparse
import getpass
import sys
from collections.abc import Sequence
from pathlib import Path

from rocsafe_console.errors import ConsoleError
from rocsafe_console.people.passwords import hash_of
from rocsafe_console.people.roles import Role
from rocsafe_console.people.users import User, read_users, write_users

EXIT_OK, EXIT_USAGE = 0, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the arguments say, and return the exit code."""
    given = _parser().parse_args(arguments)
    try:
        users = read_users(given.file) if given.file.exists() else {}
        if given.verb == 'list':
            for user in users.values():
                sys.stdout.write(f'{user.name}: {user.role.value}\n')
        elif given.verb == 'add':
            password = _password(given.name)
            users[given.name] = User(
                name=given.name, role=Role(given.role), password_hash=hash_of(password)
            )
            write_users(given.file, users)
        else:
            _remove(users, given.name)
            write_users(given.file, users)
    except (ConsoleError, ValueError, OSError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_USAGE
    return EXIT_OK


def _remove(users: dict[str, User], name: str) -> None:
    if users.pop(name, None) is None:
        raise ConsoleError(f'there is no user {name}')


def _password(name: str) -> str:
    """Return the password from the terminal, twice the same, or the first line of a pipe."""
    if not sys.stdin.isatty():
        return sys.stdin.readline().rstrip('\n')
    password = getpass.getpass(f'password of {name}: ')
    if getpass.getpass('again: ') != password:
        raise ConsoleError('the two passwords differ')
    return password


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe users', description='Add and remove users of the console, and list them.'
    )
    parser.add_argument(
        'file', type=Path, metavar='FILE', help='file of the users; it has mode 0600'
    )
    verbs = parser.add_subparsers(dest='verb', required=True, metavar='VERB')
    add = verbs.add_parser('add', help='add a user, or give another password or role')
    add.add_argument('name', metavar='NAME', help='name to log in with')
    roles = [role.value for role in Role]
    add.add_argument('role', choices=roles, metavar='ROLE', help=', '.join(roles))
    removing = verbs.add_parser('remove', help='remove a user')
    removing.add_argument('name', metavar='NAME', help='name of the user')
    verbs.add_parser('list', help='list the users')
    return parser


if __name__ == '__main__':
    sys.exit(main())
