# SPDX-License-Identifier: Apache-2.0
"""A machine that is not there: stand-ins for Python, pip, uv, colcon and the compilers."""

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
REAL_PYTHON = Path(sys.base_prefix) / f'bin/python3.{sys.version_info[1]}'
DEADLINE_S = 60.0

# Runs what needs a real Python with its own name in sys.executable; records and imitates the rest.
FAKE_PYTHON = """#!/bin/bash
note() {{ echo "$*" >>"$FAKE_CALLS"; env >"$FAKE_CALLS.$1.env"; }}
hang() {{ if [ "$FAKE_HANG" = "$1" ]; then sleep 300; fi; }}
fail() {{ if [ "$FAKE_FAIL" = "$1" ]; then echo "$FAKE_TEXT"; exit 1; fi; }}
target="${{@: -1}}"
case "$*" in
*'-m venv '*)
    note venv "$*"; hang venv
    mkdir -p "$target/bin"; cp "$0" "$target/bin/python" ;;
*'-m pip install '*)
    note pip "$*"; fail pip; hang pip ;;
*'-m pip config list')
    echo "$FAKE_PIP_SETTINGS" ;;
*'-m uv pip install '*)
    note uv "$*"; fail uv; hang uv ;;
*colcon_core.command*)
    note colcon "$*"; mkdir -p build install; hang colcon; fail colcon
    echo "export AMENT_PREFIX_PATH=$PWD/install/a:$FAKE_PREFIX" >install/setup.bash ;;
*solver.precompile*)
    note kernels "$*"; hang kernels; fail kernels ;;
*importlib.metadata*)
    echo "$FAKE_LIBRARIES" ;;
*)
    exec -a "$0" {real} "$@" ;;
esac
"""
FAKE_CMAKE = '#!/bin/sh\necho cmake version ${FAKE_CMAKE_VERSION:-3.25.1}\n'
SYSTEM_TOOLS = ('sh', 'bash', 'env', 'cp', 'mkdir', 'sleep', 'dirname', 'sed', 'cat', 'kill')


def write_executable(path: Path, text: str) -> Path:
    """Write a script that can be run."""
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    path.chmod(0o755)
    return path


@dataclass
class FakeMachine:
    """A checkout with a PATH of stand-ins and an empty home folder."""

    checkout: Path
    home: Path
    tools: Path
    variables: dict[str, str] = field(default_factory=dict)

    @property
    def calls_file(self) -> Path:
        """Where the fake Python notes what it was asked."""
        return self.home.parent / 'calls'

    @property
    def calls(self) -> list[str]:
        """First words of what the fake Python was asked, in order."""
        return [line.split()[0] for line in self.call_lines]

    @property
    def call_lines(self) -> list[str]:
        """What the fake Python was asked, in order."""
        return self.calls_file.read_text().splitlines() if self.calls_file.exists() else []

    def forget_calls(self) -> None:
        """Start counting anew."""
        self.calls_file.unlink(missing_ok=True)

    def environment_of(self, tool: str) -> dict[str, str]:
        """Return the environment that `tool` was started with last."""
        lines = Path(f'{self.calls_file}.{tool}.env').read_text().splitlines()
        return dict(line.split('=', 1) for line in lines if '=' in line)

    def start(self, *arguments: str, **variables: str) -> 'subprocess.Popen[str]':
        """Start a set-up."""
        environment = {
            'PATH': str(self.tools),
            'HOME': str(self.home),
            'FAKE_CALLS': str(self.calls_file),
            **self.variables,
            **variables,
        }
        return subprocess.Popen(
            ['sh', str(self.checkout / 'tools/setup.sh'), *arguments],
            env=environment,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.PIPE,
            text=True,
        )

    def setup(self, *arguments: str, **variables: str) -> 'subprocess.CompletedProcess[str]':
        """Run a set-up to its end."""
        process = self.start(*arguments, **variables)
        out, err = process.communicate(timeout=DEADLINE_S)
        return subprocess.CompletedProcess(process.args, process.returncode, out, err)

    def wait_for_call(self, name: str) -> None:
        """Wait until the fake Python was asked to do `name`."""
        wait_until(lambda: name in self.calls)


def wait_until(condition: Callable[[], bool]) -> None:
    """Wait until `condition` holds; fail the test at the deadline."""
    end = time.monotonic() + DEADLINE_S
    while not condition():
        if time.monotonic() > end:
            pytest.fail(f'not within {DEADLINE_S} s: {condition}')
        time.sleep(0.02)


@pytest.fixture
def machine(tmp_path: Path) -> Iterator[FakeMachine]:
    """Make a machine where nothing is set up, and end what is still running on it."""
    tools = tmp_path / 'bin'
    write_executable(tools / 'python3', FAKE_PYTHON.format(real=REAL_PYTHON))
    write_executable(tools / 'cmake', FAKE_CMAKE)
    for name in ('g++', 'make', 'git'):
        write_executable(tools / name, '#!/bin/sh\n')
    for name in SYSTEM_TOOLS:
        (tools / name).symlink_to(shutil.which(name) or '/missing')
    checkout = tmp_path / 'checkout'
    copy_checkout(checkout)
    home = tmp_path / 'home'
    home.mkdir()
    yield FakeMachine(checkout=checkout, home=home, tools=tools)
    end_processes_with(f'FAKE_CALLS={home.parent}/calls')


def copy_checkout(target: Path) -> None:
    """Copy what a set-up reads of this repository."""
    shutil.copytree(ROOT / 'tools', target / 'tools')
    shutil.copytree(ROOT / 'requirements', target / 'requirements')
    for name in ('rocsafe_geo', 'rocsafe_interfaces'):
        shutil.copytree(ROOT / 'src' / name, target / 'src' / name)


def end_processes_with(variable: str) -> None:
    """Kill every process whose environment holds `variable`."""
    for number in processes_with(variable):
        os.kill(number, signal.SIGKILL)


def processes_with(variable: str) -> list[int]:
    """List the processes whose environment holds `variable`."""
    found = []
    for folder in Path('/proc').glob('[0-9]*'):
        try:
            if variable.encode() in (folder / 'environ').read_bytes().split(b'\0'):
                found.append(int(folder.name))
        except OSError:
            continue
    return found


@pytest.fixture
def running_on() -> Callable[[FakeMachine], list[int]]:
    """List what still runs on a fake machine."""
    return lambda machine: processes_with(f'FAKE_CALLS={machine.calls_file}')


@pytest.fixture
def system_ros(machine: FakeMachine, tmp_path: Path) -> FakeMachine:
    """Give the machine a sourced ROS 2 Jazzy, built for the Python of this test run."""
    prefix = tmp_path / 'opt/ros/jazzy'
    minor = sys.version_info[1]
    rclpy = prefix / f'lib/python3.{minor}/site-packages/rclpy'
    rclpy.mkdir(parents=True)
    (rclpy / f'_rclpy_pybind11.cpython-3{minor}-x86_64-linux-gnu.so').touch()
    index = prefix / 'share/ament_index/resource_index/packages'
    index.mkdir(parents=True)
    for name in (
        'ament_cmake',
        'rosidl_default_generators',
        'rosidl_default_runtime',
        'action_msgs',
        'builtin_interfaces',
        'geometry_msgs',
        'sensor_msgs',
        'std_msgs',
    ):
        (index / name).touch()
    machine.variables |= {
        'ROS_DISTRO': 'jazzy',
        'AMENT_PREFIX_PATH': str(prefix),
        'PYTHONPATH': str(rclpy.parent),
        'FAKE_PREFIX': str(prefix),
        'FAKE_LIBRARIES': (
            '{"aiohttp": "3.9.1", "bm25s": "0.3.16", "cryptography": "41.0.7", '
            '"colcon_core": "0.16.1", "contourpy": "1.0.7", '
            '"cv2": "4.6.0", "mcap": "", '
            '"mcap_ros2": "", "msgpack": "1.0.3", "pymavlink": "2.4.41", '
            '"numba": "0.58.1", "panda3d": "1.10.14", "pmtiles": "3.4.1", "scipy": "1.11.4", '
            '"PIL": "10.2.0", "pydantic": "1.10.14", "pyproj": "3.6.1", "rasterio": "1.3.9", '
            '"jinja2": "3.1.2", "markupsafe": "2.1.5", '
            '"rich": "13.7.1", "setuptools": "68.1.2", "shapely": "2.0.3", "yaml": "6.0.1", '
            '"numpy": "1.26.4"}'
        ),
    }
    return machine
