# SPDX-License-Identifier: Apache-2.0
"""Arguments of `rocsafe console`."""

import argparse
import getpass
import os
import secrets
import time
from collections.abc import Sequence
from pathlib import Path

from rocsafe_console.errors import ConsoleError
from rocsafe_console.evidence.desk import Desk
from rocsafe_console.outward.event_target import EventTarget, target_of
from rocsafe_console.people.missions import Missions
from rocsafe_console.people.roles import Role
from rocsafe_console.people.session_file import load_sessions
from rocsafe_console.people.sessions import Sessions
from rocsafe_console.people.users import Users, read_users
from rocsafe_console.picture.live import Live
from rocsafe_console.picture.picture import Picture
from rocsafe_console.runs.base_map import open_base_map
from rocsafe_console.web.context import Context, WebOptions
from rocsafe_console.web.server import require_safe

# Fewer bits of the time would repeat too soon, more do not fit JavaScript's numbers.
_REVISION_BITS = 50
DESCRIPTION = """\
Serve the operator's page: the mission that runs in this ROS domain, and all runs in a folder.
Without users, the page is open on this machine to whoever has the printed address.
"""


def context_of(arguments: Sequence[str] | None = None) -> Context:
    """Return the parts of the server by the arguments of the command.

    Raises
    ------
    ConsoleError
        If the arguments do not fit each other, or a file is wrong.
    """
    given = _parser().parse_args(arguments)
    users = read_users(given.users) if given.users else {}
    roles = {name: user.role for name, user in users.items()}
    options = WebOptions(
        host=given.host,
        port=given.port,
        certificate=given.certificate,
        key=given.key,
        names=tuple(given.name),
        cursor_on_target=_target(given),
        runs=given.runs.resolve(),
        scenarios=given.scenarios.resolve(),
        token='' if users else secrets.token_urlsafe(24),
        token_user=getpass.getuser(),
    )
    require_safe(options, len(users))
    options.runs.mkdir(parents=True, exist_ok=True)
    sessions = Sessions()
    load_sessions(options.runs, sessions, roles or {options.token_user: Role.COMMANDER})
    first_revision = time.time_ns() // 1_000_000 % 2**_REVISION_BITS
    return Context(
        options=options,
        live=Live(Picture(first_revision)),
        desk=Desk(options.runs),
        users=Users(users, given.users),
        missions=Missions(options.runs),
        sessions=sessions,
        clock=time.time,
        base_map=open_base_map(given.base_map) if given.base_map else None,
        environment=dict(os.environ),
    )


def _target(given: argparse.Namespace) -> EventTarget | None:
    if given.cursor_on_target is None:
        if given.tak_identity or given.tak_authority or given.tak_name:
            raise ConsoleError('--tak-...: needs --cursor-on-target')
        return None
    return target_of(
        given.cursor_on_target, given.tak_identity, given.tak_authority, given.tak_name
    )


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='rocsafe console', description=DESCRIPTION)
    parser.add_argument(
        '--runs', type=Path, default=Path('runs'), metavar='DIR', help='folder of the runs [runs]'
    )
    parser.add_argument(
        '--scenarios', type=Path, default=Path('config/scenarios'), metavar='DIR',
        help='scenarios to begin a new mission with [config/scenarios]',
    )  # fmt: skip
    parser.add_argument(
        '--base-map',
        type=Path,
        metavar='FILE',
        help='MBTiles, PMTiles or GeoTIFF file to show below',
    )
    parser.add_argument(
        '--host', default='127.0.0.1', help='address to listen at (default: 127.0.0.1)'
    )
    parser.add_argument(
        '--port', type=int, default=8600, help='TCP port; 0: any that is free (default: 8600)'
    )
    parser.add_argument(
        '--cursor-on-target', metavar='[tls://]HOST:PORT',
        help='send Cursor on Target events there: datagrams, such as 239.2.3.1:6969, which ATAK '
        'hears, or to a TAK server, such as tls://tak.local:8089',
    )  # fmt: skip
    parser.add_argument(
        '--tak-identity', type=Path, metavar='FILE',
        help='certificate and key for the TAK server, PEM',
    )  # fmt: skip
    parser.add_argument(
        '--tak-authority', type=Path, metavar='FILE',
        help='who has signed the certificate of the TAK server, PEM',
    )  # fmt: skip
    parser.add_argument(
        '--tak-name', default='', metavar='NAME',
        help='name in the certificate of the TAK server [its host]',
    )  # fmt: skip
    parser.add_argument(
        '--users', type=Path, metavar='FILE', help='who may log in; made by `rocsafe users`'
    )
    parser.add_argument('--certificate', type=Path, metavar='FILE', help='certificate of TLS, PEM')
    parser.add_argument('--key', type=Path, metavar='FILE', help='private key of TLS, PEM')
    parser.add_argument(
        '--name', action='append', default=[], metavar='HOST',
        help='further name under which the page is reached; may be given several times',
    )  # fmt: skip
    return parser
