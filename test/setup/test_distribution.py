# SPDX-License-Identifier: Apache-2.0
"""The wheels: complete, startable, and installed without compiler, index or checkout."""

import ast
import base64
import hashlib
import os
import subprocess
import sys
import zipfile
from pathlib import Path, PurePath

import pytest
from test.test_architecture import OPTIONAL

from distribution import command
from distribution.archive import Member, read_wheel, write_wheel
from distribution.install_list import install_list
from distribution.libraries import LibrariesError, closure, gather
from distribution.python_wheel import make_python_wheel
from distribution.requirement_names import UnknownRequirementError, read_lock, requirements
from rocsafe_planner.solver.model.compiled import cache_directory

ROOT = Path(__file__).resolve().parents[2]
MANIFESTS = sorted((ROOT / 'src').glob('*/package.xml'))
LOCK = read_lock(ROOT / 'requirements/lock.txt')
LIMIT_S = 240.0


def test_every_dependency_of_every_package_is_pinned():
    """Each manifest gives requirements with a version; none is left out."""
    own = {path.parent.name: '1.0' for path in MANIFESTS}
    for manifest in MANIFESTS:
        assert all('==' in line for line in requirements(manifest, own, LOCK))


def test_libraries_that_no_manifest_can_name_come_with_the_suite():
    """Without them a module of a mission could not be loaded: rosdep has no key for them.

    Learning and the engine say themselves what to install.
    """
    said = ('rocsafe_learning', 'rocsafe_scene')
    trees = [
        ast.parse(path.read_text())
        for manifest in MANIFESTS
        for path in manifest.parent.rglob('*.py')
        if manifest.parent.name not in said
    ]
    loaded = {
        name.partition('.')[0] for tree in trees for node in tree.body for name in _imported(node)
    }
    assert loaded & OPTIONAL <= set(command.WITHOUT_KEY)


def _imported(node: ast.stmt) -> list[str]:
    if isinstance(node, ast.Import):
        return [alias.name for alias in node.names]
    return [str(node.module)] if isinstance(node, ast.ImportFrom) else []


def test_a_dependency_that_is_not_locked_is_refused():
    """The wheel would fail on another machine, so it is not made."""
    with pytest.raises(UnknownRequirementError, match='is not in requirements/lock'):
        requirements(ROOT / 'src/rocsafe_sim/package.xml', {}, LOCK)


def test_a_wheel_that_was_written_is_read_back(tmp_path):
    """Members, modes, and a RECORD whose hashes are right."""
    members = {'a/b.py': Member(content=b'x = 1\n'), 'a/run': Member(content=b'#!', mode=0o755)}
    write_wheel(tmp_path / 'a.whl', 'a-1.dist-info', members)
    assert read_wheel(tmp_path / 'a.whl') == members
    with zipfile.ZipFile(tmp_path / 'a.whl') as archive:
        lines = archive.read('a-1.dist-info/RECORD').decode().splitlines()
    digest = base64.urlsafe_b64encode(hashlib.sha256(b'x = 1\n').digest()).decode().rstrip('=')
    assert f'a/b.py,sha256={digest},6' in lines


def test_a_python_wheel_holds_what_its_folder_holds(tmp_path):
    """Every source and data file but bytecode, and an executable for each entry point."""
    package = ROOT / 'src/rocsafe_dispersion'
    members = read_wheel(make_python_wheel(package, ['numpy==1'], tmp_path))
    files = (path for path in (package / package.name).rglob('*') if path.is_file())
    wanted = {str(path.relative_to(package)) for path in files if '__pycache__' not in path.parts}
    assert wanted <= members.keys()
    launchers = [name for name in members if '/data/lib/rocsafe_dispersion/' in name]
    assert launchers
    assert all(members[name].mode == 0o755 for name in launchers)
    assert not any('console_scripts' in str(member.content) for member in members.values())


def test_the_wheel_of_the_planner_brings_its_machine_code(tmp_path):
    """Nobody waits for the compiler before the first plan."""
    members = read_wheel(make_python_wheel(ROOT / 'src/rocsafe_planner', [], tmp_path))
    kept = {PurePath(name).parent for name in members if name.endswith('.nbi')}
    assert [path.name for path in kept] == [cache_directory().name]


def test_the_same_sources_make_the_same_bytes(tmp_path):
    """A wheel can be compared with one that somebody else made."""
    (tmp_path / 'a').mkdir()
    (tmp_path / 'b').mkdir()
    package = ROOT / 'src/rocsafe_hazard'
    first = make_python_wheel(package, [], tmp_path / 'a').read_bytes()
    assert make_python_wheel(package, [], tmp_path / 'b').read_bytes() == first


def test_what_is_needed_indirectly_is_found():
    """Numba needs llvmlite, which no manifest names."""
    found = closure([LOCK['numba'].split(' ')[0]])
    assert 'llvmlite' in found
    assert 'colcon' not in ' '.join(found)


def test_the_list_needs_no_index_and_names_every_file_by_its_hash(tmp_path):
    """Nothing but the files of the folder can be installed by it."""
    wheel = tmp_path / 'a-1.0-py3-none-any.whl'
    wheel.write_bytes(b'x')
    lines = install_list([wheel]).splitlines()
    assert {'--no-index', '--find-links .', '--require-hashes'} <= set(lines)
    assert lines[-1] == f'a==1.0 --hash=sha256:{hashlib.sha256(b"x").hexdigest()}'


def test_a_library_with_another_hash_is_refused_in_one_line(tmp_path, monkeypatch):
    """As somebody who changed a file on the index would have it."""
    monkeypatch.setenv('PIP_NO_INDEX', '1')
    monkeypatch.setenv('PIP_FIND_LINKS', str(tmp_path / 'index'))
    (tmp_path / 'index').mkdir()
    info = 'rocsafe_try-1.0.dist-info'
    members = {f'{info}/METADATA': Member(content=b'Name: rocsafe_try\nVersion: 1.0\n')}
    write_wheel(tmp_path / 'index/rocsafe_try-1.0-py3-none-any.whl', info, members)
    with pytest.raises(LibrariesError, match=r'^ERROR: .*HASHES') as error:
        gather(['rocsafe_try==1.0 --hash=sha256:' + '0' * 64], tmp_path)
    assert '\n' not in str(error.value)


@pytest.mark.all
@pytest.mark.system
@pytest.mark.timeout(600)
def test_the_folder_alone_flies_the_derailment(tmp_path, monkeypatch, own_domain):
    """In a fresh environment, with no compiler, no index, no checkout and an empty home."""
    monkeypatch.setattr(command, 'OUT', tmp_path / 'dist')
    if command.main() != 0:
        pytest.skip('the package index cannot be reached')
    (tmp_path / 'bin').mkdir()
    for name in ('sh', 'env'):
        (tmp_path / 'bin' / name).symlink_to(f'/bin/{name}')
    environment = {
        'PATH': str(tmp_path / 'bin'),
        'HOME': str(tmp_path),
        'ROS_DOMAIN_ID': os.environ['ROS_DOMAIN_ID'],
        'PIP_CONFIG_FILE': os.devnull,
    }

    def run(*arguments: str) -> str:
        done = subprocess.run(
            arguments, env=environment, cwd=tmp_path, capture_output=True, text=True,
            timeout=LIMIT_S, check=False,
        )  # fmt: skip
        assert done.returncode == 0, done.stdout + done.stderr
        return done.stdout

    base = Path(sys.base_prefix, 'bin', f'python3.{sys.version_info.minor}')
    run(str(base), '-m', 'venv', 'rocsafe')
    run('rocsafe/bin/pip', 'install', '-q', '--no-compile', '-r', 'dist/install.txt')
    scenario = 'rocsafe/share/rocsafe/config/scenarios/derailment.yaml'
    assert 'mission complete' in run('rocsafe/bin/rocsafe', 'run', scenario)
    assert list(tmp_path.glob('runs/*/report.html'))
    assert 'rocsafe_sim rav' in run('rocsafe/bin/ros2', 'pkg', 'executables', 'rocsafe_sim')
    shown = run('rocsafe/bin/ros2', 'interface', 'show', 'rocsafe_interfaces/msg/VehicleState')
    assert 'header' in shown
