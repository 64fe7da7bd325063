# SPDX-License-Identifier: Apache-2.0
"""Environment of the tools during set-up, and of the workspace once it is built."""

import os
import shlex
import subprocess
from collections.abc import Mapping
from pathlib import Path

from workspace.errors import SetupError
from workspace.layout import Layout
from workspace.processes import MARK
from workspace.ros import SystemRos

# Left over from an activated environment, from make, or from a user's habits: each of them makes
# a tool of the set-up do something else than it is told.
_DROPPED = (
    '_ROS_WHEELS_BOOTSTRAP_COMPLETE',
    'COLCON_CURRENT_PREFIX',
    'COLCON_DEFAULTS_FILE',
    'MAKEFLAGS',
    'MAKELEVEL',
    'MFLAGS',
    'PIP_PREFIX',
    'PIP_TARGET',
    'PYTHONHOME',
    'PYTHONSTARTUP',
)
_PATHS = (
    'AMENT_PREFIX_PATH',
    'CMAKE_PREFIX_PATH',
    'COLCON_PREFIX_PATH',
    'LD_LIBRARY_PATH',
    'PATH',
    'PYTHONPATH',
)
_SHELL_STATE = {'_', 'OLDPWD', 'PWD', 'SHLVL', 'HOME'}
# Asking bash for its environment takes a second at most.
_CAPTURE_LIMIT_S = 60.0


def tool_environment(
    layout: Layout, ros: SystemRos | None, user: Mapping[str, str]
) -> dict[str, str]:
    """Return the environment for pip, colcon and what they start.

    Every cache, log and temporary file goes below the checkout. HOME stays, because pip reads the
    user's mirror and certificates there; colcon gets another (see `build_environment`).
    """
    environment = {name: value for name, value in user.items() if name not in _DROPPED}
    for name in _PATHS:
        kept = _kept_entries(user, name, layout.root)
        environment.pop(name, None)
        if kept and (ros or name in ('LD_LIBRARY_PATH', 'PATH')):
            environment[name] = ':'.join(kept)
    environment['PATH'] = f'{layout.venv}/bin:{environment.get("PATH", os.defpath)}'
    temporary = layout.cache / 'tmp'
    temporary.mkdir(parents=True, exist_ok=True)
    environment |= {
        MARK: str(layout.root),
        'COLCON_HOME': str(layout.cache / 'colcon'),
        'COLCON_LOG_PATH': str(layout.root / 'log'),
        'PIP_CACHE_DIR': str(layout.cache / 'pip'),
        'PIP_DISABLE_PIP_VERSION_CHECK': '1',
        'PIP_NO_INPUT': '1',
        'PIP_USER': '0',
        'PYTHONNOUSERSITE': '1',
        'TMPDIR': str(temporary),
        'VIRTUAL_ENV': str(layout.venv),
        'XDG_CACHE_HOME': str(layout.cache),
    }
    if ros is None:
        environment['AMENT_PREFIX_PATH'] = str(layout.venv)
        environment['CMAKE_PREFIX_PATH'] = str(layout.venv)
    return environment


def build_environment(tools: Mapping[str, str], layout: Layout) -> dict[str, str]:
    """Return the environment for colcon: as `tools`, with a home folder in the checkout."""
    home = layout.cache / 'home'
    home.mkdir(parents=True, exist_ok=True)
    # Left to itself colcon also limits the load: on a busy machine that stretches two minutes
    # to more than ten.
    return {**tools, 'HOME': str(home), 'MAKEFLAGS': f'-j{core_count()}'}


def core_count() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0))


def _kept_entries(user: Mapping[str, str], name: str, root: Path) -> list[str]:
    """Return the entries of a path variable that do not come from this checkout."""
    entries = [entry for entry in user.get(name, '').split(':') if entry]
    active = user.get('VIRTUAL_ENV')
    closed = [root, *([Path(active)] if active else [])]
    return [
        entry
        for entry in entries
        if not any(Path(entry).is_relative_to(folder) for folder in closed)
    ]


def capture(layout: Layout, ros: SystemRos | None) -> dict[str, str]:
    """Return what ``. install/setup.bash`` sets in an empty shell.

    Raises
    ------
    SetupError
        If the shell does not answer.
    """
    bare = {'PATH': os.defpath, 'HOME': str(layout.cache / 'home'), MARK: str(layout.root)}
    if ros is None:
        bare |= {'AMENT_PREFIX_PATH': str(layout.venv), 'CMAKE_PREFIX_PATH': str(layout.venv)}
    script = '. "$1" >/dev/null && exec env -0'
    command = ['bash', '--noprofile', '--norc', '-c', script, 'bash']
    try:
        answer = subprocess.run(
            [*command, str(layout.install / 'setup.bash')],
            stdin=subprocess.DEVNULL,
            capture_output=True,
            env=bare,
            timeout=_CAPTURE_LIMIT_S,
            check=True,
        )
    except (OSError, subprocess.SubprocessError) as error:
        raise SetupError(f'{layout.install}/setup.bash cannot be sourced: {error}') from error
    pairs = (item.split('=', 1) for item in answer.stdout.decode().split('\0') if '=' in item)
    return {name: value for name, value in pairs if name not in _SHELL_STATE | {MARK}}


def shell_script(layout: Layout, captured: Mapping[str, str], token: str) -> str:
    """Return a script for any POSIX shell that extends its environment by `captured`.

    The script does nothing in a shell where it ran before: `token` tells the builds apart.
    """
    lines = [
        '# Made by tools/workspace from `. install/setup.bash`, whose answer it repeats at once.',
        f'if [ "${{ROCSAFE_WORKSPACE-}}" != {shlex.quote(token)} ]; then',
        f'export ROCSAFE_WORKSPACE={shlex.quote(token)}',
        f'export VIRTUAL_ENV={shlex.quote(str(layout.venv))}',
        f'export PATH={shlex.quote(str(layout.venv / "bin"))}":$PATH"',
        'export PYTHONNOUSERSITE=1',
        f'export ROS_LOG_DIR="${{ROS_LOG_DIR:-{layout.ros_logs}}}"',
    ]
    for name, value in sorted(captured.items()):
        if name not in _PATHS:
            lines.append(f'export {name}={shlex.quote(value)}')
            continue
        # An empty entry would stand for the current folder.
        added = [entry for entry in value.split(':') if entry and entry not in _default_path()]
        entries = ':'.join(added)
        if entries:
            lines.append(f'export {name}={shlex.quote(entries)}"${{{name}:+:${name}}}"')
    return '\n'.join([*lines, 'fi', ''])


def _default_path() -> list[str]:
    return os.defpath.split(os.pathsep)
