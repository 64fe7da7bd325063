# SPDX-License-Identifier: Apache-2.0
"""The stages of a set-up: each knows whether it is complete and how to complete it."""

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import ExitStack, contextmanager
from ctypes.util import find_library
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

from workspace import building, machine, packages, records
from workspace.console import say, step
from workspace.environment import core_count, tool_environment
from workspace.errors import SetupError
from workspace.layout import Layout
from workspace.machine import BasePython
from workspace.ros import SystemRos, missing_packages


@dataclass(frozen=True)
class Workspace:
    """A checkout that is being set up.

    Attributes
    ----------
    layout
        Its files.
    ros
        The system's ROS, None for wheels.
    user
        Environment that the user started the set-up in.
    """

    layout: Layout
    ros: SystemRos | None
    user: Mapping[str, str]

    @cached_property
    def tools(self) -> dict[str, str]:
        """Environment for pip and colcon."""
        return tool_environment(self.layout, self.ros, self.user)

    @cached_property
    def needs_stand_in(self) -> bool:
        """Whether the machine has no ``ros2`` command of its own."""
        return building.real_ros2(self.layout, self.user.get('PATH', os.defpath)) is None

    @cached_property
    def kind(self) -> str:
        """What the environment stands on, apart from its Python."""
        prefixes = ':'.join(map(str, self.ros.prefixes)) if self.ros else 'wheels'
        return f'{self.layout.root} {prefixes}'

    def venv_mark(self, version: str) -> str:
        """Fingerprint of the virtual environment for Python `version` (``3.11``)."""
        return records.fingerprint(self.kind, version)

    def packages_mark(self, version: str) -> str:
        """Fingerprint of the packages that the nodes need."""
        names = ('ros.txt', 'python.txt', 'lock.txt', 'installer.txt')
        files = [self.layout.requirements / name for name in names]
        return records.fingerprint(self.venv_mark(version), *files)

    def development_mark(self, version: str) -> str:
        """Fingerprint of the packages that checks and tests need."""
        files = [self.layout.requirements / name for name in ('dev.txt', 'lock-dev.txt')]
        return records.fingerprint(self.packages_mark(version), *files)

    def ground_mark(self, version: str) -> str:
        """Fingerprint of what a build cannot survive a change of."""
        return records.fingerprint(self.venv_mark(version), self.layout.requirements / 'ros.txt')

    def build_mark(self, version: str) -> str:
        """Fingerprint of a build."""
        inputs = records.build_inputs(self.layout.sources)
        names = [str(path.relative_to(self.layout.root)) for path in inputs]
        return records.fingerprint(self.ground_mark(version), *names, *inputs)

    def kernels_mark(self, version: str) -> str:
        """Fingerprint of the planner's compiled loops."""
        return records.fingerprint(self.packages_mark(version), *self.layout.kernels)

    def commands_mark(self, version: str) -> str:
        """Fingerprint of the commands, which also tells a shell whether its environment is old."""
        return records.fingerprint(self.build_mark(version), self.needs_stand_in)


def is_ready(workspace: Workspace, *, development: bool) -> bool:
    """Tell, within a few milliseconds, whether every stage is complete."""
    layout = workspace.layout
    record = records.read(layout.venv_record)
    version = str(record.get('python'))
    if not (layout.python.exists() and version == _wanted_version(workspace, version)):
        return False
    wanted = {
        'venv': workspace.venv_mark(version),
        'packages': workspace.packages_mark(version),
        'commands': workspace.commands_mark(version),
        'kernels': workspace.kernels_mark(version),
    }
    if development:
        wanted['development'] = workspace.development_mark(version)
    return wanted.items() <= record.items() and _is_built(workspace, version)


def make_ready(workspace: Workspace, *, development: bool) -> None:
    """Complete every stage that is not."""
    version = _ready_venv(workspace)
    _ready_packages(workspace, version)
    if development:
        _ready_development(workspace, version)
    with _compiled_beside(workspace, version):
        _ready_build(workspace, version)
        _ready_commands(workspace, version)
    _tell_of_egl()


def _tell_of_egl() -> None:
    """Say in one line what the camera backend `engine` lacks; all else works without."""
    if not all(map(find_library, ('EGL', 'GL'))):
        say(
            'no EGL: the camera backend engine would need sudo apt install '
            '--no-install-recommends libegl1 libgl1 libgl1-mesa-dri'
        )


def _wanted_version(workspace: Workspace, present: str) -> str:
    """Return the Python version to use, given the one that is `present` in the environment."""
    if workspace.ros:
        return _dotted(workspace.ros.python_version)
    if workspace.user.get('PYTHON') or _runs_in_venv(workspace):
        return _dotted(sys.version_info[:2])
    return present if machine.probe(str(workspace.layout.python)) else ''


def _runs_in_venv(workspace: Workspace) -> bool:
    return Path(sys.executable).absolute() == workspace.layout.python


def _dotted(version: tuple[int, ...]) -> str:
    return '.'.join(map(str, version))


def _ready_venv(workspace: Workspace) -> str:
    layout = workspace.layout
    record = records.read(layout.venv_record)
    present = str(record.get('python'))
    if (
        layout.python.exists()
        and present == _wanted_version(workspace, present)
        and record.get('venv') == workspace.venv_mark(present)
    ):
        machine.check_tools(workspace.user.get('PATH', os.defpath))
        return present
    python = _check_machine(workspace)
    version = _dotted(python.minor)
    records.forget([layout.venv_record])
    with step(f'virtual environment .venv, Python {python.name} of {python.executable}'):
        packages.make_venv(layout, python, workspace.ros, workspace.tools)
    return version


def _check_machine(workspace: Workspace) -> BasePython:
    layout, ros = workspace.layout, workspace.ros
    machine.check_tools(workspace.user.get('PATH', os.defpath))
    if ros:
        absent = missing_packages(layout.sources, ros.prefixes)
        if absent:
            names = ' '.join(f'ros-jazzy-{name.replace("_", "-")}' for name in absent)
            raise SetupError(
                f'the sourced ROS lacks {", ".join(absent)}: sudo apt install {names}'
            )
        say(f'ROS 2 Jazzy of the system, {ros.rclpy}; no wheel of it is installed')
    else:
        machine.check_wheels_exist()
        say('no ROS is sourced: ROS 2 Jazzy comes from wheels')
    machine.check_disk(layout.root)
    wanted = ros.python_version if ros else None
    return machine.choose_python(workspace.user, wanted, layout.venv)


def _ready_packages(workspace: Workspace, version: str) -> None:
    layout, mark = workspace.layout, workspace.packages_mark(version)
    if records.read(layout.venv_record).get('packages') == mark:
        return
    # Without its record the environment is not complete, and is made anew after an interruption.
    records.forget([layout.venv_record])
    if workspace.ros:
        with step('libraries that the system lacks'):
            installed = packages.install_missing(layout, workspace.tools)
        say(f'installed into .venv: {", ".join(installed) or "none"}')
    else:
        with step('ROS 2 Jazzy and libraries, pinned in requirements/'):
            packages.install_wheels(layout, workspace.tools)
    records.write(
        layout.venv_record,
        {'python': version, 'venv': workspace.venv_mark(version), 'packages': mark},
    )


def _ready_development(workspace: Workspace, version: str) -> None:
    layout, mark = workspace.layout, workspace.development_mark(version)
    record = records.read(layout.venv_record)
    if record.get('development') == mark:
        return
    records.forget([layout.venv_record])
    with step('tools of the checks and tests, pinned in requirements/dev.txt'):
        packages.install_development(layout, workspace.ros, workspace.tools)
    records.write(layout.venv_record, {**record, 'development': mark})


def _is_built(workspace: Workspace, version: str) -> bool:
    mark = workspace.build_mark(version)
    return (workspace.layout.install / 'setup.bash').exists() and all(
        records.read(path).get('build') == mark for path in workspace.layout.build_records
    )


def _ready_build(workspace: Workspace, version: str) -> None:
    if _is_built(workspace, version):
        return
    layout, ground = workspace.layout, workspace.ground_mark(version)
    files = [str(path) for path in records.build_inputs(layout.sources)]
    before = [records.read(path) for path in layout.build_records]
    records.forget(layout.build_records)
    if any(
        record.get('ground') != ground or not set(record.get('files', ())) <= set(files)
        for record in before
    ):
        building.clear(layout)
    with step(f'colcon build of the packages in src/, {core_count()} at a time'):
        building.build(layout, workspace.tools, workspace.ros)
    record = {'build': workspace.build_mark(version), 'ground': ground, 'files': files}
    for path in layout.build_records:
        records.write(path, record)


def _ready_commands(workspace: Workspace, version: str) -> None:
    layout, mark = workspace.layout, workspace.commands_mark(version)
    record = records.read(layout.venv_record)
    if record.get('commands') == mark:
        return
    names = '.venv/bin/rocsafe' + (' and .venv/bin/ros2' if workspace.needs_stand_in else '')
    with step(f'commands {names}'):
        building.write_commands(layout, workspace.ros, mark, stand_in=workspace.needs_stand_in)
    records.write(layout.venv_record, {**record, 'commands': mark})


@contextmanager
def _compiled_beside(workspace: Workspace, version: str) -> Iterator[None]:
    """Compile wheels and the planner's loops while the block builds, which leaves a core idle."""
    layout, mark = workspace.layout, workspace.kernels_mark(version)
    if records.read(layout.venv_record).get('kernels') == mark:
        yield
        return
    with ExitStack() as compiling:
        if layout.kernels:
            compiling.enter_context(building.compiling_kernels(layout, workspace.tools))
        if workspace.ros is None:
            compiling.enter_context(packages.compiling_wheels(layout, workspace.tools))
        yield
        with step("libraries and the planner's loops, compiled beside the build"):
            compiling.close()
    records.write(layout.venv_record, {**records.read(layout.venv_record), 'kernels': mark})
