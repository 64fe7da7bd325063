# SPDX-License-Identifier: Apache-2.0
"""`rocsafe seal`: seals a run, or makes the key that signs seals."""

import argparse
import getpass
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from rocsafe_console.evidence.seal import make_key, public_key_of, read_key, seal_run
from rocsafe_console.evidence.signing import key_path, usual_key
from rocsafe_geo.evidence.code_version import version_text
from rocsafe_geo.evidence.evidence_log import EvidenceError

EXIT_OK, EXIT_FAILED, EXIT_USAGE = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Do what the arguments say, and return the exit code."""
    given = _parser().parse_args(arguments)
    path = given.key or key_path(os.environ)
    try:
        if given.make_key:
            make_key(path)
        if given.make_key or given.run is None:
            sys.stdout.write(f'{path}: public key {public_key_of(path)}\n')
            return EXIT_OK
        if not given.run.is_dir():
            sys.stderr.write(f'error: {given.run} is no run directory\n')
            return EXIT_USAGE
        # A key that was named must be there; the usual one may not have been made.
        key = read_key(path) if given.key else usual_key(os.environ)
        seal = seal_run(given.run, time.time(), getpass.getuser(), version_text(), key)
    except (EvidenceError, OSError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_FAILED
    signed = 'signed' if key is not None else 'not signed: there is no key, see seal --make-key'
    sys.stdout.write(f'{seal}: {signed}\n')
    return EXIT_OK


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe seal',
        description='Seal a run: hashes of all its files and of its log, signed with Ed25519. '
        'Without a run, print the public key.',
    )
    parser.add_argument('run', type=Path, nargs='?', metavar='RUN', help='directory of a run')
    parser.add_argument(
        '--key',
        type=Path,
        metavar='FILE',
        help='signing key (default: ~/.config/rocsafe/signing.key)',
    )
    parser.add_argument('--make-key', action='store_true', help='make a new signing key')
    return parser


if __name__ == '__main__':
    sys.exit(main())
