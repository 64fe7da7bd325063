# SPDX-License-Identifier: Apache-2.0
"""Pin every package that the wheels set-up installs, with the hashes of its files.

``python3 tools/lock.py`` rewrites ``requirements/lock.txt`` (from ros.txt and python.txt) and
``requirements/lock-dev.txt`` (what dev.txt needs beyond) after a change of another file there.
It asks pip of each supported Python, which all must be on the PATH. Versions that are locked stay,
unless a file demands others; ``--upgrade`` takes the newest. Python 3.10 chooses the versions:
what it can install, the newer ones can too.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path

PYTHONS = ('3.10', '3.11', '3.12')
FOLDER = Path(__file__).resolve().parents[1] / 'requirements'
LOCK, LOCK_DEV = FOLDER / 'lock.txt', FOLDER / 'lock-dev.txt'
HEAD = '# Made by tools/lock.py: every package of the wheels set-up, the hashes of its files.\n'


@dataclass(slots=True)
class LockedPackage:
    """A package with its version, and for each Python that needs it the hash of its file."""

    version: str
    hashes: dict[str, str] = field(default_factory=dict)

    def line(self, name: str) -> str:
        """Return the requirement of `name`; it names its Pythons if not all need it."""
        line = f'{name}=={self.version}'
        if len(self.hashes) < len(PYTHONS):
            line += ' ; ' + ' or '.join(f"python_version == '{python}'" for python in self.hashes)
        return ' '.join([line, *sorted(f'--hash={value}' for value in set(self.hashes.values()))])


def resolve(python: str, names: Iterable[str], pins: Mapping[str, str]) -> list[dict[str, object]]:
    """Return what pip of a Python would install for requirement files, as its report says."""
    with tempfile.TemporaryDirectory() as folder:
        constraints = Path(folder) / 'constraints.txt'
        constraints.write_text(''.join(f'{name}=={pins[name]}\n' for name in pins))
        files = [part for name in names for part in ('-r', FOLDER / f'{name}.txt')]
        options = ['--dry-run', '--ignore-installed', '--prefer-binary', '--quiet']
        answer = subprocess.run(
            [
                *(f'python{python}', '-m', 'pip', 'install', *options, '--report', '-'),
                *('-c', constraints, *files),
            ],
            stdout=subprocess.PIPE,
            check=True,
        )
    found: list[dict[str, object]] = json.loads(answer.stdout)['install']
    return found


def locked(names: Iterable[str], pins: Mapping[str, str]) -> dict[str, LockedPackage]:
    """Return what all Pythons would install, by name; the first one chooses the versions."""
    packages: dict[str, LockedPackage] = {}
    chosen = dict(pins)
    for python in PYTHONS:
        for item in resolve(python, names, chosen):
            name, version, digest = _parts(item)
            package = packages.setdefault(name, LockedPackage(version))
            if package.version != version:
                raise SystemExit(f'lock: {name} is {package.version} and, for {python}, {version}')
            package.hashes[python] = digest
            chosen[name] = version
    return packages


def present(path: Path) -> dict[str, str]:
    """Return the versions in a lock file, by name."""
    lines = path.read_text().splitlines() if path.exists() else []
    pairs = (line.split(' ')[0].partition('==') for line in lines if '==' in line)
    return {name: version for name, _, version in pairs}


def main() -> int:
    """Write both files."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--upgrade', action='store_true', help='take the newest versions')
    pins = {} if parser.parse_args().upgrade else present(LOCK) | present(LOCK_DEV)
    for name in ('ros', 'python', 'dev'):
        for package in present(FOLDER / f'{name}.txt'):
            pins.pop(package.lower().replace('_', '-'), None)
    everything = locked(('ros', 'python', 'dev'), pins)
    versions = {name: package.version for name, package in everything.items()}
    base = locked(('ros', 'python'), versions)
    _write(LOCK, base)
    _write(LOCK_DEV, {name: everything[name] for name in everything.keys() - base.keys()})
    return 0


def _parts(item: dict[str, object]) -> tuple[str, str, str]:
    """Return name, version and hash of an entry of a report."""
    content = json.loads(json.dumps(item))
    hashes = content['download_info']['archive_info']['hashes']
    name = content['metadata']['name'].lower().replace('_', '-')
    return name, content['metadata']['version'], f'sha256:{hashes["sha256"]}'


def _write(path: Path, packages: Mapping[str, LockedPackage]) -> None:
    lines = [packages[name].line(name) + '\n' for name in sorted(packages)]
    path.write_text(HEAD + ''.join(lines))


if __name__ == '__main__':
    sys.exit(main())
