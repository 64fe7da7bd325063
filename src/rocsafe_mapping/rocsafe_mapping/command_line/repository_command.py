# SPDX-License-Identifier: Apache-2.0
"""`repository`: keeps photographs that are sent over HTTP."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rocsafe_mapping.command_line.notes import note
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.repository.server import Repository
from rocsafe_mapping.repository.sink import token_of_file

EXIT_OK, EXIT_REFUSED = 0, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Serve until interrupted and return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        token = token_of_file(options.token_file)
        server = Repository(options.folder, (options.host, options.port), token)
    except (MappingError, ValueError, OSError) as error:
        note(f'error: {error}')
        return EXIT_REFUSED
    host, port = server.server_address[:2]
    sys.stdout.write(f'serving {options.folder} at http://{host!s}:{port}\n')
    sys.stdout.flush()
    try:
        server.serve_forever()
    except KeyboardInterrupt:
        pass
    finally:
        server.server_close()
    return EXIT_OK


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe repository', description='Keep photographs that are sent over HTTP.'
    )
    parser.add_argument('folder', type=Path, metavar='FOLDER', help='image store; made if missing')
    parser.add_argument(
        '--host', default='127.0.0.1', help='address to listen at (default: 127.0.0.1)'
    )
    parser.add_argument(
        '--port', type=int, default=8730, help='TCP port; 0: any that is free (default: 8730)'
    )
    parser.add_argument(
        '--token-file', default='', metavar='FILE',
        help='holds the token that senders must bring, mode 0600; needed beyond loopback',
    )  # fmt: skip
    return parser


if __name__ == '__main__':
    sys.exit(main())
