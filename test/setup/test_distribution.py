# SPDX-License-Identifier: Apache-2.0
"""The wheels: complete, startable, and installed without compiler, index or checkout."""

import base64
import hashlib
import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path, PurePath

import pytest

from distribution import command
from distribution.archive import Member, read_wheel, write_wheel
from distribution.install_list import install_list
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


def test_the_list_holds_what_is_needed_indirectly():
    """Numba needs llvmlite, which no manifest names."""
    text = install_list([], [LOCK['numba'].split(' ')[0]], LOCK)
    assert 'llvmlite==' in text
    assert 'colcon' not in text


@pytest.mark.all
def test_wheels_alone_plan_a_mission(tmp_path, monkeypatch):
    """In a fresh environment, without the checkout, `rocsafe check` and `ros2` work.

    The libraries of the index are taken from this environment: the test needs no network.
    """
    monkeypatch.setattr(command, 'OUT', tmp_path / 'dist')
    assert command.main() == 0
    venv = tmp_path / 'venv'
    _run([sys.executable, '-m', 'venv', '--without-pip', str(venv)])
    wheels = [str(path) for path in sorted((tmp_path / 'dist').glob('*.whl'))]
    pip = [sys.executable, '-m', 'pip', '--python', str(venv / 'bin/python'), 'install', '-q']
    _run([*pip, '--no-deps', '--no-index', '--no-compile', *wheels])
    site = sysconfig.get_path('purelib', vars={'base': str(venv)})
    Path(site, 'libraries.pth').write_text(sysconfig.get_path('purelib') + '\n')
    scenario = venv / 'share/rocsafe/config/scenarios/derailment.yaml'
    assert 'valid' in _run([str(venv / 'bin/rocsafe'), 'check', str(scenario)])
    ros2 = str(venv / 'bin/ros2')
    assert 'rocsafe_sim rav' in _run([ros2, 'pkg', 'executables', 'rocsafe_sim'])
    shown = _run([ros2, 'interface', 'show', 'rocsafe_interfaces/msg/VehicleState'])
    assert 'header' in shown


def _run(arguments: list[str]) -> str:
    """Run a command without the environment of the workspace; return its output."""
    base = Path(sys.prefix)
    libraries = [base / 'lib', *sorted(Path(sysconfig.get_path('purelib')).glob('ros_*.libs'))]
    prefix = Path(arguments[0]).parents[1]
    environment = {
        'PATH': os.defpath,
        'HOME': os.environ['HOME'],
        'LD_LIBRARY_PATH': os.pathsep.join(map(str, [prefix / 'lib', *libraries])),
        '_ROS_WHEELS_BOOTSTRAP_COMPLETE': '1',
        'AMENT_PREFIX_PATH': str(base),
    }
    done = subprocess.run(
        arguments, env=environment, capture_output=True, text=True, timeout=LIMIT_S, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    return done.stdout
