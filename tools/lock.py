# SPDX-License-Identifier: Apache-2.0
"""Pin every package that the wheels set-up installs, also those that nobody names.

``python3.10 tools/lock.py`` rewrites ``requirements/constraints.txt`` after a change of another
file there. The oldest Python is used because what it can install, the newer ones can too.
"""

import json
import subprocess
import sys
from pathlib import Path

OLDEST = (3, 10)
FOLDER = Path(__file__).resolve().parents[1] / 'requirements'
HEAD = '# Made by tools/lock.py: every package of the wheels set-up, the same for all Pythons.\n'


def resolve() -> dict[str, str]:
    """Ask pip which versions the requirement files lead to."""
    files = [part for name in ('ros', 'python', 'dev') for part in ('-r', FOLDER / f'{name}.txt')]
    options = ['--dry-run', '--ignore-installed', '--prefer-binary', '--quiet', '--report', '-']
    answer = subprocess.run(
        [sys.executable, '-m', 'pip', 'install', *options, *files],
        stdout=subprocess.PIPE,
        check=True,
    )
    packages = [item['metadata'] for item in json.loads(answer.stdout)['install']]
    return {item['name'].lower().replace('_', '-'): item['version'] for item in packages}


def main() -> int:
    """Write the file."""
    if sys.version_info[:2] != OLDEST:
        print(f'lock: run me with Python {OLDEST[0]}.{OLDEST[1]}', file=sys.stderr)
        return 2
    lines = [f'{name}=={version}\n' for name, version in sorted(resolve().items())]
    (FOLDER / 'constraints.txt').write_text(HEAD + ''.join(lines))
    return 0


if __name__ == '__main__':
    sys.exit(main())
