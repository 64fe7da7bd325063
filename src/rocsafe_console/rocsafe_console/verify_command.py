# SPDX-License-Identifier: Apache-2.0
"""`rocsafe verify`: finds every byte of a sealed run that has been changed."""

import argparse
import sys
from collections.abc import Sequence
from pathlib import Path

from rocsafe_console.evidence.seal import notes_of, seals_of, signer_of, verify_run

EXIT_OK, EXIT_FAILED, EXIT_USAGE = 0, 1, 2


def main(arguments: Sequence[str] | None = None) -> int:
    """Verify a run; the exit code is 1 if something has been changed."""
    given = _parser().parse_args(arguments)
    if not given.run.is_dir():
        sys.stderr.write(f'error: {given.run} is no run directory\n')
        return EXIT_USAGE
    try:
        faults = verify_run(given.run, given.public_key)
    except OSError as error:
        faults = [f'{error.filename}: {error.strerror}']
    for line in faults:
        sys.stdout.write(f'{line}\n')
    if faults:
        return EXIT_FAILED
    seal = seals_of(given.run)[-1]
    signer = signer_of(seal)
    by = f'signed with {signer}' if signer else 'not signed: whoever changed all could seal again'
    notes = ''.join(f'; {note}' for note in notes_of(given.run))
    sys.stdout.write(f'{given.run}: every byte is as sealed in {seal.name}, {by}{notes}\n')
    return EXIT_OK


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe verify',
        description='Find every byte of a sealed run that has been changed.',
    )
    parser.add_argument('run', type=Path, metavar='RUN', help='directory of a run')
    parser.add_argument(
        '--public-key',
        default='',
        metavar='KEY',
        help='public key that must have signed it, as `rocsafe seal` tells it',
    )
    return parser


if __name__ == '__main__':
    sys.exit(main())
