# SPDX-License-Identifier: Apache-2.0
"""Write README.md of each package: its use, executables, launch files, topics and documents.

    python tools/package_readmes.py

What it says comes from package.xml, setup.py and the tables of topics and calls; a test keeps it
current.
"""

import ast
import re
import sys
import xml.etree.ElementTree as ElementTree
from pathlib import Path

from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import CallSpec, Scope, TopicSpec

ROOT = Path(__file__).resolve().parents[1]
# Documents of each package in docs/.
DOCUMENTS = {
    'rocsafe_bringup': ('ros',), 'rocsafe_console': ('console',), 'rocsafe_dataset': ('datasets',),
    'rocsafe_dispersion': ('dispersion',), 'rocsafe_ground': ('ground',),
    'rocsafe_interfaces': ('interfaces',), 'rocsafe_learning': ('learning',),
    'rocsafe_mapping': ('mapping',), 'rocsafe_mavlink': ('bridge', 'real-drones', 'emergency'),
    'rocsafe_orchestrator': ('commands', 'losses'),
    'rocsafe_planner': ('planning', 'flight-model'),
    'rocsafe_radiation': ('radiation',), 'rocsafe_ros': ('interfaces', 'ros'),
    'rocsafe_ros2cli': ('ros',), 'rocsafe_scenario': ('scenarios',), 'rocsafe_scene': ('scenes',),
    'rocsafe_sim': ('cameras', 'scenes'),
}  # fmt: skip
_NAME = re.compile(r'\b(?:topics|calls)\.([A-Z][A-Z_]+)\b|\b([A-Z][A-Z_]+)\b')


def readmes() -> dict[Path, str]:
    """Return the texts by their paths."""
    packages = sorted((ROOT / 'src').glob('rocsafe_*/package.xml'))
    return {manifest.with_name('README.md'): _readme(manifest) for manifest in packages}


def _readme(manifest: Path) -> str:
    package = manifest.parent
    root = ElementTree.parse(manifest).getroot()  # noqa: S314 - our own file
    text = f'# {package.name}\n\n{str(root.findtext("description")).strip()}\n'
    programs = _executables(package / 'setup.py')
    if programs:
        names = ', '.join(f'`{name}`' for name in programs)
        text += f'\nExecutables of `ros2 run {package.name}`: {names}.\n'
    launches = sorted(package.glob('launch/*.py'))
    if launches:
        rows = ''.join(f'| `{path.name}` | {_first_line(path)} |\n' for path in launches)
        text += f'\nFiles of `ros2 launch {package.name}`:\n\n| file | starts |\n|---|---|\n{rows}'
    used = _topics(package)
    if used:
        rows = ''.join(f'| `{name}` | {note} |\n' for name, note in used)
        text += '\nTopics, services and actions that its nodes use:\n\n'
        text += f'| name | meaning |\n|---|---|\n{rows}'
    links = [f'[{name}.md](../../docs/{name}.md)' for name in DOCUMENTS.get(package.name, ())]
    links.append('[architecture.md](../../docs/architecture.md)')
    return text + f'\nMore: {", ".join(links)}.\n'


def _executables(setup: Path) -> list[str]:
    if not setup.exists():
        return []
    texts = [
        n.value for n in ast.walk(ast.parse(setup.read_text())) if isinstance(n, ast.Constant)
    ]
    points = [text for text in texts if isinstance(text, str) and ' = rocsafe_' in text]
    return sorted(point.partition(' = ')[0] for point in points)


def _first_line(module: Path) -> str:
    return str(ast.get_docstring(ast.parse(module.read_text()))).partition('\n')[0].rstrip('.')


def _topics(package: Path) -> list[tuple[str, str]]:
    """Return the endpoints that the nodes of a package name, with their meaning."""
    if package.name == 'rocsafe_ros':
        return []
    names = {
        part
        for path in package.rglob('*_node.py')
        for match in _NAME.findall(path.read_text())
        for part in match
    }
    table = vars(topics) | vars(calls)
    specs = [table[name] for name in sorted(names) if name in table]
    known = [spec for spec in specs if isinstance(spec, TopicSpec | CallSpec)]
    return [(_full(spec), spec.note) for spec in known]


def _full(spec: TopicSpec | CallSpec) -> str:
    return f'ravN/{spec.name}' if spec.scope is Scope.VEHICLE else spec.name


def main() -> int:
    """Write all."""
    for path, text in readmes().items():
        path.write_text(text)
    return 0


if __name__ == '__main__':
    sys.exit(main())
