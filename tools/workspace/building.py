# SPDX-License-Identifier: Apache-2.0
"""The build of all packages, and the commands that run them."""

import os
import shlex
from collections.abc import Mapping
from contextlib import AbstractContextManager
from pathlib import Path

from workspace import records
from workspace.environment import build_environment, capture, shell_script
from workspace.layout import Layout
from workspace.packages import remove
from workspace.processes import in_idle_time, run_logged, running
from workspace.ros import SystemRos

# Started by the environment's own Python, so that the executables it installs start with it too.
_COLCON = 'import sys; from colcon_core.command import main; sys.exit(main())'
_EXIT_NOT_SET_UP = 3
# A package of the distribution that the wheels lack: src/ has one of the same name.
_TF_PACKAGE = 'tf2_msgs'


def build(layout: Layout, environment: Mapping[str, str], ros: SystemRos | None) -> None:
    """Build and install every package with colcon; what the system's ROS has is left to it."""
    python = str(layout.python)
    prefixes = ros.prefixes if ros else ()
    has_tf = any((prefix / 'share' / _TF_PACKAGE).is_dir() for prefix in prefixes)
    command = [python, '-c', _COLCON, 'build', '--symlink-install', '--base-paths', 'src']
    cmake = [f'-DPython3_EXECUTABLE={python}', '-DBUILD_TESTING=OFF', '--no-warn-unused-cli']
    if ros is None:
        # Libraries are found by LD_LIBRARY_PATH. Wheels must not name folders of this machine.
        cmake.append('-DCMAKE_SKIP_RPATH=ON')
    ignored = ['--packages-ignore', _TF_PACKAGE] if has_tf else []
    run_logged(
        [*command, *ignored, '--cmake-args', *cmake],
        layout.logs / 'build.log',
        build_environment(environment, layout),
        folder=layout.root,
    )


def clear(layout: Layout) -> None:
    """Remove the folders of earlier builds."""
    remove(layout.build)
    remove(layout.install)


def compiling_kernels(
    layout: Layout, environment: Mapping[str, str]
) -> AbstractContextManager[None]:
    """Compile, beside a block, the planner's inner loops: the first plan need not wait for it."""
    sources = [str(layout.planner), str(layout.sources / 'rocsafe_geo')]
    paths = [*sources, environment.get('PYTHONPATH', '')]
    work = (
        "import runpy; runpy.run_module('rocsafe_planner.solver.precompile', run_name='__main__')"
    )
    return running(
        in_idle_time(layout.python, work),
        layout.logs / 'kernels.log',
        {**environment, 'PYTHONPATH': os.pathsep.join(filter(None, paths))},
        folder=layout.root,
    )


def write_commands(layout: Layout, ros: SystemRos | None, token: str, *, stand_in: bool) -> None:
    """Write the environment of the workspace and the commands that start in it.

    Parameters
    ----------
    token
        Identifies this build.
    stand_in
        Whether the ``ros2`` command of `rocsafe_ros2cli` is needed.
    """
    captured = capture(layout, ros)
    records.write_text(layout.environment_script, shell_script(layout, captured, token))
    executable = layout.install / 'rocsafe_orchestrator/lib/rocsafe_orchestrator/rocsafe'
    _write_command(layout, 'rocsafe', f'exec {shlex.quote(str(executable))} "$@"')
    if stand_in:
        start = f'exec {shlex.quote(str(layout.python))} -m rocsafe_ros2cli "$@"'
        _write_command(layout, 'ros2', f'{_prefer_real_ros2(layout)}\n{start}')
    else:
        remove(layout.venv / 'bin/ros2')


def real_ros2(layout: Layout, path: str) -> Path | None:
    """Return the ``ros2`` command on `path` that is not `rocsafe_ros2cli`."""
    for folder in path.split(os.pathsep):
        command = Path(folder) / 'ros2'
        if folder and os.access(command, os.X_OK) and not command.is_relative_to(layout.venv):
            return command
    return None


def _write_command(layout: Layout, name: str, start: str) -> None:
    script = shlex.quote(str(layout.environment_script))
    lines = [
        '#!/bin/sh',
        f'# Made by tools/workspace: {name} in the environment of the built workspace.',
        f'if [ ! -r {script} ]; then',
        f'    echo "{name}: this folder was moved or cleaned: run make setup" >&2',
        f'    exit {_EXIT_NOT_SET_UP}',
        'fi',
        f'. {script}',
        start,
        '',
    ]
    records.write_text(layout.venv / 'bin' / name, '\n'.join(lines), mode=0o755)


def _prefer_real_ros2(layout: Layout) -> str:
    own = shlex.quote(str(layout.venv / 'bin'))
    return '\n'.join(
        [
            '# A real ros2 that has come onto the PATH since is never shadowed.',
            'IFS=:',
            'for folder in $PATH; do',
            f'    if [ "$folder" != {own} ] && [ -x "$folder/ros2" ]; then',
            '        unset IFS',
            '        exec "$folder/ros2" "$@"',
            '    fi',
            'done',
            'unset IFS',
        ]
    )
