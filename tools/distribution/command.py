# SPDX-License-Identifier: Apache-2.0
"""Make the wheels of all packages: ``python -m distribution.command`` in the built workspace."""

import shutil
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from distribution.install_list import install_list
from distribution.interface_wheel import make_interface_wheel
from distribution.python_wheel import make_python_wheel
from distribution.requirement_names import read_lock, requirements
from distribution.suite_wheel import make_suite_wheel

ROOT = Path(__file__).resolve().parents[2]
OUT = ROOT / 'dist'


def main() -> int:
    """Write the wheels and the list of what to install to ``dist/``."""
    if not (ROOT / 'install/tf2_msgs').is_dir():
        print(
            'wheels: a ROS of the system is sourced; the wheels stand on those of ROS: run '
            'make wheels in a shell without it',
            file=sys.stderr,
        )
        return 1
    shutil.rmtree(OUT, ignore_errors=True)
    OUT.mkdir()
    manifests = sorted((ROOT / 'src').glob('*/package.xml'))
    own = {path.parent.name: _version(path) for path in manifests}
    lock = read_lock(ROOT / 'requirements/lock.txt')
    needs = {path.parent.name: requirements(path, own, lock) for path in manifests}
    wheels = [_make(path.parent, own[path.parent.name], needs[path.parent.name])
              for path in manifests]  # fmt: skip
    every = [f'{name}=={version}' for name, version in own.items()]
    wheels.append(make_suite_wheel(own['rocsafe_orchestrator'], every, ROOT / 'config', OUT))
    foreign = {line for lines in needs.values() for line in lines} - set(every)
    (OUT / 'install.txt').write_text(install_list(wheels, foreign, lock))
    print(f'{len(wheels)} wheels and install.txt written to {OUT}')
    return 0


def _make(package: Path, version: str, needs: list[str]) -> Path:
    if (package / 'setup.py').exists():
        return make_python_wheel(package, needs, OUT)
    prefix = ROOT / 'install' / package.name
    return make_interface_wheel(prefix, package.name, version, needs, OUT)


def _version(manifest: Path) -> str:
    root = ElementTree.parse(manifest).getroot()  # noqa: S314 - our own file
    return str(root.findtext('version')).strip()


if __name__ == '__main__':
    sys.exit(main())
