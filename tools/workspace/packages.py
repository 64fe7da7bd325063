# SPDX-License-Identifier: Apache-2.0
"""The virtual environment and the packages that are installed into it."""

import ast
import json
import platform
import re
import shutil
import subprocess
from collections.abc import Mapping, Sequence
from contextlib import AbstractContextManager
from pathlib import Path

from workspace.errors import CommandError, SetupError
from workspace.layout import Layout
from workspace.machine import BasePython
from workspace.processes import in_idle_time, run_logged, running
from workspace.ros import SystemRos

# What a library of the system must be to be used with a system's ROS: its module, the name and
# the lowest version that was tried, which is that of Ubuntu 24.04 where it will do. What is older
# or missing comes, pinned, from python.txt.
SYSTEM_MINIMA: dict[str, tuple[str, tuple[int, ...]]] = {
    'aiohttp': ('aiohttp', (3, 14)),
    'bm25s': ('bm25s', (0, 3)),
    'colcon_core': ('colcon-common-extensions', (0, 12)),
    'contourpy': ('contourpy', (1, 0, 7)),
    'cryptography': ('cryptography', (45, 0)),
    'cv2': ('opencv-python-headless', (4, 6)),
    'jinja2': ('Jinja2', (3, 1)),
    'markupsafe': ('MarkupSafe', (2, 1)),
    'mcap': ('mcap', (1, 0)),
    'mcap_ros2': ('mcap-ros2-support', (0, 5)),
    'msgpack': ('msgpack', (1, 0)),
    'numba': ('numba', (0, 58)),
    'panda3d': ('panda3d', (1, 10, 13)),
    'PIL': ('pillow', (10, 2)),
    'pmtiles': ('pmtiles', (3, 4)),
    'pydantic': ('pydantic', (2, 0)),
    'pymavlink': ('pymavlink', (2, 4, 41)),
    'pyproj': ('pyproj', (3, 6)),
    'rasterio': ('rasterio', (1, 3, 9)),
    'rich': ('rich', (13, 7)),
    'scipy': ('scipy', (1, 11)),
    'setuptools': ('setuptools', (68, 0)),
    'shapely': ('shapely', (2, 0, 3)),
    'yaml': ('PyYAML', (6, 0)),
}
# Importing everything takes seconds; a minute means that something hangs.
_INSPECT_LIMIT_S = 120.0

# A lock names all packages; nothing else is installed.
_LOCKED = ('--require-hashes', '--no-deps')

_INSPECT = """
import importlib, importlib.metadata, json, sys
versions = {}
for module, distribution in json.loads(sys.argv[1]).items():
    try:
        loaded = importlib.import_module(module)
        version = getattr(loaded, '__version__', None) or getattr(loaded, 'VERSION', None)
        if not isinstance(version, str):
            version = importlib.metadata.version(distribution)
    except Exception:
        version = ''
    versions[module] = version
print(json.dumps(versions))
"""

# What pip and uv say.
_NETWORK_SIGNS = re.compile(
    'name resolution|NewConnectionError|Failed to establish|Network is unreachable|'
    'Connection refused|ConnectTimeout|ReadTimeout|ProxyError|CERTIFICATE_VERIFY_FAILED|'
    'error sending request|Failed to download distribution due to network timeout'
)
_ABSENT = re.compile(
    r'No matching distribution found for (\S+)|'
    r'Because (\S+) was not found in the package registry|'
    r'there is no version of (\S+)|Because (\S+) has no wheels with a matching'
)
# Settings of pip, by which a user names a mirror, and the options of uv that say the same.
_UV_OPTIONS = {
    'index-url': '--default-index',
    'extra-index-url': '--index',
    'find-links': '--find-links',
    'trusted-host': '--allow-insecure-host',
    'cert': '--cert',
}


def make_venv(
    layout: Layout, python: BasePython, ros: SystemRos | None, environment: Mapping[str, str]
) -> None:
    """Make the virtual environment; an existing one is replaced."""
    remove(layout.venv)
    options = ['--system-site-packages'] if ros else []
    command = [str(python.executable), '-I', '-m', 'venv', *options, str(layout.venv)]
    # Not run by its own Python yet, so nothing of an activated environment may reach it.
    bare = {name: value for name, value in environment.items() if name != 'PYTHONPATH'}
    run_logged(command, layout.logs / 'venv.log', bare)
    # The wheels bring package.xml files, which colcon would take for packages to build.
    (layout.venv / 'COLCON_IGNORE').touch()


def install_wheels(layout: Layout, environment: Mapping[str, str]) -> None:
    """Install ROS and every library, each file by its hash."""
    _install_locked(layout, 'packages', 'lock.txt', environment)


def install_missing(layout: Layout, environment: Mapping[str, str]) -> list[str]:
    """Install, for a system's ROS, the libraries it lacks; return their requirements.

    numpy stays the system's: its ROS messages are compiled against it.
    """
    modules = {module: name for module, (name, _) in SYSTEM_MINIMA.items()} | {'numpy': 'numpy'}
    found = _versions(layout, modules, environment)
    if not found['numpy']:
        raise SetupError(
            'the sourced ROS has no numpy; on Debian or Ubuntu: sudo apt install python3-numpy'
        )
    constraint = layout.cache / 'system-numpy.txt'
    constraint.write_text(f'numpy=={found["numpy"]}\n')
    pins = pinned(layout.requirements / 'python.txt')
    wanted = [
        pins[name.lower()]
        for module, (name, minimum) in SYSTEM_MINIMA.items()
        if _numbers(found[module]) < minimum
    ]
    if wanted:
        _pip(layout, 'packages', [*wanted, f'-c{constraint}'], environment)
    return wanted


def install_development(layout: Layout, ros: SystemRos | None, env: Mapping[str, str]) -> None:
    """Install what the checks and the tests need beyond the nodes."""
    if ros:
        numpy = f'-c{layout.cache}/system-numpy.txt'
        _pip(layout, 'development', [f'-r{layout.requirements}/dev.txt', numpy], env)
    else:
        _install_locked(layout, 'development', 'lock-dev.txt', env)


def compiling_wheels(
    layout: Layout, environment: Mapping[str, str]
) -> AbstractContextManager[None]:
    """Compile, beside a block, what was installed, as pip does; what does not compile stays so."""
    work = f'import compileall; compileall.compile_dir({str(layout.venv / "lib")!r}, quiet=2)'
    return running(in_idle_time(layout.python, work), layout.logs / 'bytecode.log', environment)


def pinned(requirements: Path) -> dict[str, str]:
    """Return the requirement lines of a file by lower-case name."""
    lines = (line.split('#')[0].strip() for line in requirements.read_text().splitlines())
    return {line.split('==')[0].lower(): line for line in lines if line}


def remove(path: Path) -> None:
    """Remove a file, link or folder, if it is there.

    Raises
    ------
    SetupError
        If the system does not allow it.
    """
    try:
        if path.is_symlink() or path.is_file():
            path.unlink()
        elif path.exists():
            shutil.rmtree(path)
    except OSError as error:
        raise SetupError(f'cannot remove {error.filename}: {error.strerror}') from error


def _install_locked(
    layout: Layout, log_name: str, lock: str, environment: Mapping[str, str]
) -> None:
    """Install the files of a lock with uv, which is several times faster than pip."""
    _pip(layout, 'installer', [*_LOCKED, f'-r{layout.requirements}/installer.txt'], environment)
    sources, proxy = _pip_settings(layout, environment)
    # pip asks all indices alike, too; the hashes say which file is the right one.
    options = ['--index-strategy=unsafe-best-match', *_LOCKED, *sources]
    where = [f'--python={layout.python}', f'-r{layout.requirements}/{lock}']
    _install(
        layout, log_name, ['uv', 'pip', 'install', *options, *where], {**proxy, **environment}
    )


def _pip(
    layout: Layout, log_name: str, arguments: Sequence[str], environment: Mapping[str, str]
) -> None:
    _install(layout, log_name, ['pip', 'install', '--prefer-binary', *arguments], environment)


def _install(
    layout: Layout, log_name: str, arguments: Sequence[str], environment: Mapping[str, str]
) -> None:
    command = [str(layout.python), '-m', *arguments]
    try:
        run_logged(command, layout.logs / f'{log_name}.log', environment)
    except CommandError as error:
        raise _explained(error) from error


def _pip_settings(
    layout: Layout, environment: Mapping[str, str]
) -> tuple[list[str], dict[str, str]]:
    """Return the mirrors, certificates and proxy of pip as options and environment of uv."""
    listed = _asked(layout, ['-m', 'pip', 'config', 'list'], environment).splitlines()
    values: dict[str, list[str]] = {}
    # In the order in which pip lets one setting replace another.
    for section in ('global', 'install', ':env:'):
        for line in listed:
            key, _, value = line.partition('=')
            place, _, name = key.rpartition('.')
            if place == section:
                values[name] = ast.literal_eval(value).split()
    options = [
        f'{_UV_OPTIONS[name]}={word}' for name in _UV_OPTIONS for word in values.get(name, ())
    ]
    if 'cert' not in values:
        options.append('--system-certs')
    if values.get('no-index', ['0'])[0].lower() in ('1', 'true', 'yes', 'on'):
        options.append('--no-index')
    proxy = values.get('proxy', [])
    return options, {name: proxy[0] for name in ('HTTP_PROXY', 'HTTPS_PROXY') if proxy}


def _explained(failure: CommandError) -> SetupError:
    """Return one line for the failures of pip and uv that have one cause."""
    if 'No space left on device' in failure.log_text:
        return SetupError('no space is left on the disk: make room and run this again')
    if _NETWORK_SIGNS.search(failure.log_text):
        return SetupError(
            'the package index cannot be reached: connect this machine to it, or name a mirror '
            'by PIP_INDEX_URL, and run this again'
        )
    if re.search('DO NOT MATCH THE HASHES|Hash mismatch for', failure.log_text):
        return SetupError(
            'a package differs from the one that was locked in requirements/: it may have '
            'been tampered with; see the log'
        )
    absent = _ABSENT.search(failure.log_text)
    if absent:
        return SetupError(
            f'the package index has no {absent.group(absent.lastindex or 0)} for this Python on '
            f'{platform.machine()} with {" ".join(platform.libc_ver())}'
        )
    return failure


def _versions(
    layout: Layout, modules: Mapping[str, str], environment: Mapping[str, str]
) -> dict[str, str]:
    answer = _asked(layout, ['-c', _INSPECT, json.dumps(modules)], environment)
    versions: dict[str, str] = json.loads(answer.splitlines()[-1])
    return versions


def _asked(layout: Layout, arguments: Sequence[str], environment: Mapping[str, str]) -> str:
    """Return what the environment's Python prints."""
    try:
        answer = subprocess.run(
            [layout.python, *arguments],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            text=True,
            env=environment,
            timeout=_INSPECT_LIMIT_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise SetupError(
            f'{layout.python} cannot list its libraries or settings: {error}'
        ) from error
    return answer.stdout


def _numbers(version: str) -> tuple[int, ...]:
    return tuple(int(part) for part in re.findall(r'\d+', version)[:3])
