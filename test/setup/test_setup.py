# SPDX-License-Identifier: Apache-2.0
"""Whole set-ups on a machine of stand-ins: what is done, done again, refused and interrupted."""

import os
import shutil
import signal
from pathlib import Path

import pytest

STAGES = ['venv', 'pip', 'uv', 'colcon']
INSTALLED = ['pip', 'uv']


def test_first_setup_makes_everything(machine):
    """Environment, wheels and build are made in this order, each told in one line."""
    done = machine.setup()
    assert done.returncode == 0, done.stderr
    assert machine.calls == STAGES
    for text in ('virtual environment', 'wheels', 'colcon build', 'commands', 'ready after'):
        assert text in done.stdout
    installer, libraries = machine.call_lines[1:3]
    for line, name in ((installer, 'installer.txt'), (libraries, 'lock.txt')):
        assert '--require-hashes' in line
        assert f'requirements/{name}' in line
    assert os.access(machine.checkout / '.venv/bin/rocsafe', os.X_OK)
    assert os.access(machine.checkout / '.venv/bin/ros2', os.X_OK)


def test_second_setup_does_nothing(machine):
    """What is complete is not touched again."""
    machine.setup()
    machine.forget_calls()
    done = machine.setup()
    assert (done.returncode, done.stdout, machine.calls) == (0, 'setup: ready\n', [])


def test_home_and_temporary_folder_stay_untouched(machine):
    """Nothing is written outside the checkout, and every tool is told so."""
    machine.setup('--dev', TMPDIR='/nowhere')
    assert list(machine.home.iterdir()) == []
    inside = f'{machine.checkout}/'
    for name in ('PIP_CACHE_DIR', 'TMPDIR', 'XDG_CACHE_HOME', 'COLCON_HOME', 'COLCON_LOG_PATH'):
        assert machine.environment_of('pip')[name].startswith(inside), name
    assert machine.environment_of('colcon')['HOME'].startswith(inside)


def test_tests_add_their_tools_once(machine):
    """A set-up for the tests adds to one for a mission and leaves the rest as it is."""
    machine.setup()
    machine.forget_calls()
    machine.setup('--dev')
    assert machine.calls == INSTALLED
    assert '--require-hashes' in machine.call_lines[1]
    assert 'requirements/lock-dev.txt' in machine.call_lines[1]
    machine.forget_calls()
    assert machine.setup().stdout == 'setup: ready\n'
    assert machine.setup('--dev').stdout == 'setup: ready\n'
    assert machine.calls == []


def test_changed_file_repeats_only_its_stage(machine):
    """The content of the files decides; Python sources are used in place."""
    machine.setup()
    for file, stages in (
        ('requirements/python.txt', INSTALLED),
        ('requirements/lock.txt', INSTALLED),
        ('requirements/installer.txt', INSTALLED),
        ('requirements/ros.txt', [*INSTALLED, 'colcon']),
        ('src/rocsafe_geo/package.xml', ['colcon']),
        ('src/rocsafe_geo/setup.py', ['colcon']),
        ('src/rocsafe_interfaces/CMakeLists.txt', ['colcon']),
        ('src/rocsafe_interfaces/msg/Route.msg', ['colcon']),
        ('src/rocsafe_geo/rocsafe_geo/frame.py', []),
    ):
        machine.forget_calls()
        with (machine.checkout / file).open('a') as stream:
            stream.write('\n')
        assert machine.setup().returncode == 0, file
        assert machine.calls == stages, file


def test_inner_loops_are_compiled_ahead_and_again_when_they_change(machine):
    """The first plan waits for no compiler, also after the solver's sources have changed."""
    solver = machine.checkout / 'src/rocsafe_planner/rocsafe_planner/solver'
    solver.mkdir(parents=True)
    (solver / 'moves.py').write_text('')
    done = machine.setup()
    assert sorted(machine.calls) == sorted([*STAGES, 'kernels'])
    assert 'compiled beside the build' in done.stdout
    machine.forget_calls()
    assert machine.setup().stdout == 'setup: ready\n'
    (solver / 'moves.py').write_text('changed')
    machine.setup()
    assert machine.calls == ['kernels']
    environment = machine.environment_of('kernels')
    assert environment['PYTHONPATH'].split(':')[0] == str(machine.checkout / 'src/rocsafe_planner')


def test_inner_loops_that_do_not_compile_end_the_setup(machine, running_on):
    """Their log is shown; a build that fails first ends them."""
    solver = machine.checkout / 'src/rocsafe_planner/rocsafe_planner/solver'
    solver.mkdir(parents=True)
    (solver / 'moves.py').write_text('')
    failed = machine.setup(FAKE_FAIL='kernels', FAKE_TEXT='error: no such loop')
    assert failed.returncode == 1
    assert failed.stderr.splitlines()[0].strip() == 'error: no such loop'
    shutil.rmtree(machine.checkout / 'build')
    failed = machine.setup(FAKE_FAIL='colcon', FAKE_HANG='kernels')
    assert failed.returncode == 1
    machine.wait_for_call('kernels')
    assert running_on(machine) == []
    machine.forget_calls()
    assert machine.setup().returncode == 0
    assert sorted(machine.calls) == ['colcon', 'kernels']


def test_touched_file_repeats_nothing(machine):
    """A new date on an old content, as git gives on a change of branch, is no change."""
    machine.setup()
    machine.forget_calls()
    os.utime(machine.checkout / 'src/rocsafe_geo/package.xml')
    machine.setup()
    assert machine.calls == []


def test_removed_folder_is_made_again(machine):
    """Whoever removes a folder gets it back."""
    machine.setup()
    built = STAGES[-1:]
    for folder, stages in (('build', built), ('install', built), ('.venv', ['venv', *INSTALLED])):
        machine.forget_calls()
        shutil.rmtree(machine.checkout / folder)
        assert machine.setup().returncode == 0, folder
        assert machine.calls == stages, folder


def test_removed_message_empties_the_build(machine):
    """What an earlier build generated from a file does not outlive the file."""
    machine.setup()
    left_over = machine.checkout / 'install/left_over'
    left_over.touch()
    (machine.checkout / 'src/rocsafe_interfaces/msg/Route.msg').unlink()
    machine.setup()
    assert not left_over.exists()


def test_moved_checkout_is_set_up_anew(machine):
    """A virtual environment cannot be moved, so it is made again; its commands say why."""
    machine.setup()
    machine.forget_calls()
    moved = machine.checkout.rename(machine.checkout.with_name('elsewhere'))
    machine.checkout = moved
    assert machine.setup().returncode == 0
    assert machine.calls == STAGES
    assert str(moved) in (moved / '.venv/workspace.sh').read_text()


def test_other_python_makes_another_environment(machine):
    """PYTHON chooses; one that does not start is refused by its name."""
    machine.setup()
    refused = machine.setup(PYTHON='python9')
    assert refused.returncode == 1
    assert refused.stderr == (
        'setup: PYTHON=python9 is not a Python 3.10, 3.11 or 3.12 that starts\n'
    )


def test_broken_environment_is_made_again(machine):
    """An environment whose Python does not start any more is replaced."""
    machine.setup()
    machine.forget_calls()
    (machine.checkout / '.venv/bin/python').write_text('#!/bin/sh\nexit 127\n')
    assert machine.setup().returncode == 0
    assert machine.calls == ['venv', *INSTALLED]


@pytest.mark.parametrize(
    ('number', 'stage'),
    [*((signal.SIGINT, stage) for stage in STAGES), (signal.SIGTERM, 'pip')],
)
def test_interrupted_setup_ends_at_once_and_goes_on(machine, running_on, stage, number):
    """A signal in any stage ends all of it with the shell's code; the next call completes it."""
    process = machine.start(FAKE_HANG=stage)
    machine.wait_for_call(stage)
    process.send_signal(number)
    _, err = process.communicate(timeout=60)
    assert process.returncode == 128 + number
    assert err == 'setup: interrupted; the same command goes on from here\n'
    assert running_on(machine) == []
    machine.forget_calls()
    assert machine.setup().returncode == 0
    assert machine.calls == (['colcon'] if stage == 'colcon' else STAGES)
    assert machine.setup().stdout == 'setup: ready\n'


@pytest.mark.parametrize('stage', STAGES)
def test_killed_setup_leaves_nothing_that_harms_the_next(machine, running_on, stage):
    """After SIGKILL its children live on; the next set-up ends them before it starts."""
    process = machine.start(FAKE_HANG=stage)
    machine.wait_for_call(stage)
    process.kill()
    process.communicate(timeout=60)
    assert running_on(machine) != []
    done = machine.setup()
    assert done.returncode == 0, done.stderr
    assert 'that an interrupted set-up had left' in done.stdout
    assert running_on(machine) == []
    assert machine.setup().stdout == 'setup: ready\n'


def test_two_setups_do_not_collide(machine):
    """The second waits for the first, then finds everything done."""
    first = machine.start(FAKE_HANG='pip')
    machine.wait_for_call('pip')
    second = machine.start()
    line = second.stdout.readline()
    assert line == f'setup: waiting for process {first.pid}, which is at work in this folder\n'
    first.terminate()
    first.communicate(timeout=60)
    out, _ = second.communicate(timeout=60)
    assert second.returncode == 0
    assert out.endswith(' s\n')


@pytest.mark.parametrize(
    ('tool', 'text', 'reason'),
    [
        ('pip', 'OSError: [Errno 28] No space left on device', 'no space is left on the disk'),
        ('pip', 'NewConnectionError: Temporary failure in name resolution', 'cannot be reached'),
        ('pip', 'ERROR: No matching distribution found for uv==7', 'has no uv==7 for this Python'),
        ('pip', 'ERROR: THESE PACKAGES DO NOT MATCH THE HASHES', 'differs from the one'),
        ('uv', 'cause: No space left on device (os error 28)', 'no space is left on the disk'),
        ('uv', 'cause: error sending request for url (https://a.b)', 'cannot be reached'),
        ('uv', 'cause: Hash mismatch for `affine==3`', 'differs from the one'),
        ('uv', 'Because there is no version of affine==9 and you', 'has no affine==9 for this'),
        ('uv', 'Because affine was not found in the package registry', 'has no affine for this'),
    ],
)
def test_failed_installation_is_one_line(machine, tool, text, reason):
    """Disk, network and platform are told by their cause, not by a traceback."""
    failed = machine.setup(FAKE_FAIL=tool, FAKE_TEXT=text)
    assert failed.returncode == 1
    assert failed.stderr.count('\n') == 1
    assert reason in failed.stderr
    assert machine.setup().returncode == 0


def test_mirror_of_pip_is_also_that_of_uv(machine):
    """Whoever named a mirror, certificates or a proxy for pip need name nothing more."""
    settings = [
        "global.index-url='https://one/simple'",
        "global.extra-index-url='https://two/simple file:///three'",
        "install.trusted-host='two'",
        "global.cert='/certificates.pem'",
        "global.proxy='http://proxy:3128'",
        "global.constraint='/other'",
        ":env:.index-url='https://four/simple'",
    ]
    assert machine.setup(FAKE_PIP_SETTINGS='\n'.join(settings)).returncode == 0
    words = machine.call_lines[STAGES.index('uv')].split()
    for option, values in (
        ('--default-index', ['https://four/simple']),
        ('--index', ['https://two/simple', 'file:///three']),
        ('--allow-insecure-host', ['two']),
        ('--cert', ['/certificates.pem']),
        ('--no-index', []),
    ):
        told = [word.split('=', 1)[1] for word in words if word.startswith(f'{option}=')]
        assert told == values, option
    assert '--system-certs' not in words
    assert machine.environment_of('uv')['HTTPS_PROXY'] == 'http://proxy:3128'


def test_failed_build_shows_the_end_of_its_log(machine):
    """The last lines are shown and the log is named."""
    failed = machine.setup(FAKE_FAIL='colcon', FAKE_TEXT='error: unknown type Foo')
    assert failed.returncode == 1
    shown, told = failed.stderr.splitlines()
    assert shown.strip() == 'error: unknown type Foo'
    assert told.endswith(f'all of it in {machine.checkout}/log/setup/build.log')


@pytest.mark.parametrize(
    ('name', 'package'), [('g++', 'g++'), ('make', 'make'), ('cmake', 'cmake'), ('git', 'git')]
)
def test_missing_tool_is_one_line(machine, name, package):
    """The line says which tool, why, and how to get it, before anything is made."""
    (machine.tools / name).unlink()
    failed = machine.setup()
    assert failed.returncode == 1
    assert failed.stderr.startswith(f'setup: missing: {name} (')
    assert failed.stderr.endswith(f'sudo apt install {package}\n')
    assert not (machine.checkout / '.venv').exists()


def test_old_cmake_is_refused(machine):
    """Version and minimum are told."""
    failed = machine.setup(FAKE_CMAKE_VERSION='3.18.4')
    assert failed.returncode == 1
    assert 'version 3.18, 3.21 or newer is needed' in failed.stderr


def test_path_with_blank_is_refused(machine):
    """The build tools cannot handle it, so it is told before they fail."""
    machine.checkout = machine.checkout.rename(machine.checkout.with_name('my checkout'))
    failed = machine.setup()
    assert failed.returncode == 1
    assert failed.stderr.count('\n') == 1
    assert "has ' ' in its path" in failed.stderr


def test_clean_keeps_runs_only(machine):
    """Everything that was made goes, what a mission brought home stays."""
    machine.setup()
    (machine.checkout / 'runs/one').mkdir(parents=True)
    before = {'tools', 'requirements', 'src', 'runs', '.cache'}
    assert machine.setup('--clean').returncode == 0
    assert {path.name for path in machine.checkout.iterdir()} == before
    assert (machine.checkout / 'runs/one').exists()


def test_sourced_jazzy_is_used_and_no_wheel(system_ros):
    """The system's ROS and libraries serve; only what is missing or too old is installed."""
    done = system_ros.setup()
    assert done.returncode == 0, done.stderr
    venv, pip, build = system_ros.call_lines
    assert '--system-site-packages' in venv
    installed = [word for word in pip.split() if '==' in word]
    names = [word.split('==')[0] for word in installed]
    assert names == ['aiohttp', 'cryptography', 'mcap', 'mcap-ros2-support', 'pydantic']
    assert 'ros.txt' not in pip
    constraint = system_ros.checkout / '.cache/system-numpy.txt'
    assert f'-c{constraint}' in pip
    assert constraint.read_text() == 'numpy==1.26.4\n'
    assert system_ros.environment_of('colcon')['AMENT_PREFIX_PATH'].endswith('/opt/ros/jazzy')
    assert build.startswith('colcon')


def test_change_between_wheels_and_system_makes_anew(machine, system_ros):
    """Sourcing a ROS, or not, changes what everything stands on."""
    wheels = dict.fromkeys(('ROS_DISTRO', 'AMENT_PREFIX_PATH', 'PYTHONPATH'), '')
    assert system_ros.setup(**wheels).returncode == 0
    machine.forget_calls()
    assert system_ros.setup().returncode == 0
    assert machine.calls == [stage for stage in STAGES if stage != 'uv']
    machine.forget_calls()
    assert system_ros.setup().stdout == 'setup: ready\n'
    assert system_ros.setup(**wheels).returncode == 0
    assert machine.calls == STAGES


def test_real_ros2_is_never_shadowed(system_ros):
    """Where a ros2 command is on the PATH, no stand-in is made, and one that was is removed."""
    system_ros.setup()
    stand_in = system_ros.checkout / '.venv/bin/ros2'
    assert stand_in.exists()
    real = system_ros.tools / 'ros2'
    real.write_text('#!/bin/sh\n')
    real.chmod(0o755)
    system_ros.setup()
    assert not stand_in.exists()


def test_other_distribution_is_refused(system_ros):
    """One line names what is sourced and what is needed."""
    failed = system_ros.setup(ROS_DISTRO='humble')
    assert failed.returncode == 1
    assert failed.stderr.startswith('setup: ROS_DISTRO=humble is sourced, ROCSAFE needs jazzy')
    assert failed.stderr.count('\n') == 1


def test_jazzy_in_part_is_refused(system_ros):
    """A distribution without rclpy, or without a package that ours need, is told."""
    failed = system_ros.setup(AMENT_PREFIX_PATH='/opt/none')
    assert 'no prefix in AMENT_PREFIX_PATH holds rclpy' in failed.stderr
    prefix = system_ros.variables['AMENT_PREFIX_PATH']
    Path(prefix, 'share/ament_index/resource_index/packages/geometry_msgs').unlink()
    failed = system_ros.setup()
    assert failed.stderr == (
        'setup: the sourced ROS lacks geometry_msgs: sudo apt install ros-jazzy-geometry-msgs\n'
    )
