# SPDX-License-Identifier: Apache-2.0
"""Make the wheels of all packages: ``python -m distribution.command`` in the built workspace."""

import shutil
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from distribution.install_list import install_list
from distribution.interface_wheel import make_interface_wheel
from distribution.libraries import LibrariesError, closure, gather
from distribution.python_wheel import make_python_wheel
from distribution.requirement_names import read_lock, requirements
from distribution.suite_wheel import make_suite_wheel

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / 'dist'
# Libraries that no manifest names, as rosdep has no key for them: cordons and threat zones are
# drawn with contourpy, procedures are ranked with bm25s.
WITHOUT_KEY = ('bm25s', 'contourpy')


def main() -> int:
    """Write the wheels, those of the libraries, and the list of all to ``dist/``."""
    if not (ROOT / 'install/tf2_msgs').is_dir():
        print(
            'wheels: a ROS of the system is sourced; the wheels stand on those of ROS: run '
            'make wheels in a shell without it',
            file=sys.stderr,
        )
        return 1
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir()
    lock = read_lock(ROOT / 'requirements/lock.txt')
    foreign = make_own(lock)
    own = len(list(OUT.glob('*.whl')))
    print(f'{own} wheels of this repository; libraries of the package index follow', flush=True)
    try:
        gather([lock[name] for name in sorted(closure(foreign))], OUT)
    except LibrariesError as error:
        print(f'wheels: {error}', file=sys.stderr)
        return 1
    wheels = sorted(OUT.glob('*.whl'))
    (OUT / 'install.txt').write_text(install_list(wheels))
    megabytes = sum(path.stat().st_size for path in wheels) / 1e6
    print(f'{len(wheels)} wheels, {megabytes:.0f} MB, and install.txt written to {OUT}')
    return 0


def make_own(lock: dict[str, str]) -> set[str]:
    """Write the wheels of this repository; return what they need of the package index."""
    manifests = sorted((ROOT / 'src').glob('*/package.xml'))
    own = {path.parent.name: _version(path) for path in manifests}
    needs = {path.parent.name: requirements(path, own, lock) for path in manifests}
    for path in manifests:
        _make(path.parent, own[path.parent.name], needs[path.parent.name])
    every = [f'{name}=={version}' for name, version in own.items()]
    further = {lock[name].split(' ')[0] for name in WITHOUT_KEY}
    make_suite_wheel(own['rocsafe_orchestrator'], [*every, *sorted(further)], ROOT / 'config', OUT)
    return {line for lines in needs.values() for line in lines} - set(every) | further


def _make(package: Path, version: str, needs: list[str]) -> None:
    if (package / 'setup.py').exists():
        make_python_wheel(package, needs, OUT)
    else:
        make_interface_wheel(ROOT / 'install' / package.name, package.name, version, needs, OUT)


def _version(manifest: Path) -> str:
    root = ElementTree.parse(manifest).getroot()  # noqa: S314 - our own file
    return str(root.findtext('version')).strip()


if __name__ == '__main__':
    sys.exit(main())
