# SPDX-License-Identifier: Apache-2.0
"""The `rocsafe` command: what it says to a stranger, and its exit codes."""

import json
import os
import re
import resource
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

from rocsafe_orchestrator import cli, errors
from rocsafe_orchestrator.cli import main

DERAILMENT = Path(__file__).parents[2] / 'config' / 'scenarios' / 'derailment.yaml'


def test_help_documents_every_exit_code(capsys: pytest.CaptureFixture[str]) -> None:
    """A script writer finds each code in `rocsafe --help`."""
    with pytest.raises(SystemExit) as ended:
        main(['--help'])
    assert ended.value.code == 0
    text = capsys.readouterr().out
    codes = {int(code) for code in re.findall(r'(?:^|    )  (\d+)  ', text, re.MULTILINE)}
    own = {errors.EXIT_COMPLETE, errors.EXIT_FAILED, errors.EXIT_USAGE, errors.EXIT_SETUP}
    assert own <= codes
    for signal_code in ('129', '130', '143'):
        assert signal_code in text


@pytest.mark.parametrize(
    'command', ['run', 'plan', 'replan', 'whatif', 'check', 'report', 'replay']
)
def test_every_command_has_help(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """`rocsafe COMMAND --help` says what the command does."""
    with pytest.raises(SystemExit) as ended:
        main([command, '--help'])
    assert ended.value.code == 0
    assert len(capsys.readouterr().out.splitlines()) > 5


def test_scene_show_becomes_the_viewer(monkeypatch: pytest.MonkeyPatch) -> None:
    """With the scene of the scenario, also over the flat ground, and an overview of its region."""
    from rocsafe_orchestrator.process_table import executables

    started: list[list[str]] = []
    monkeypatch.setattr(executables, 'find_executable', lambda *_names: Path('/viewer'))
    monkeypatch.setattr('os.execv', lambda _path, words: started.append(words))
    monkeypatch.setenv('DISPLAY', ':7')
    main(['scene', 'show', str(DERAILMENT), '--follow', 'rav2'])
    values = dict(word.split(':=', 1) for word in started[0] if ':=' in word)
    assert values['scene_file'].endswith('config/scenes/derailment.yaml"')
    assert (values['window'], values['follow']) == ('true', '"rav2"')
    east, north, up = json.loads(values['eye_m'])
    assert abs(east) < 1.0
    assert north < -100.0 < 100.0 < up
    assert main(['scene', 'show', str(DERAILMENT), '--follow', 'rav9']) != 0


@pytest.mark.parametrize(
    ('arguments', 'line'),
    [
        (['run', 'x.yaml', '--speed', '-1'], '--speed: -1: must be within 0 to 1000'),
        (['run', 'x.yaml', '--speed', 'fast'], '--speed: fast: must be within'),
        (['run', 'x.yaml', '--seed', '1.5'], '--seed: 1.5: must be a whole number, 0 to'),
        (['plan', 'x.kml', '--vehicles', '0'], '--vehicles: 0: must be a whole number, 1 to'),
        (['plan', 'x.kml', '--height', 'nan'], '--height: nan: must be within 1 to 500 m'),
        (['run'], 'one of the arguments SCENARIO --resume is required'),
        (['run', 'x.yaml', '--resume', 'runs/x'], 'not allowed with argument'),
        (['scene', 'show', 'x.yaml', '--eye', '1,2'], '--eye: 1,2: must be three numbers'),
        (['fly'], "invalid choice: 'fly'"),
        ([], 'required'),
    ],
)
def test_wrong_arguments_end_with_2(
    arguments: list[str], line: str, capsys: pytest.CaptureFixture[str]
) -> None:
    """A wrong argument is named with its limit."""
    with pytest.raises(SystemExit) as ended:
        main(arguments)
    assert ended.value.code == errors.EXIT_USAGE
    assert line in capsys.readouterr().err


@pytest.mark.parametrize('command', ['run', 'check', 'plan'])
def test_missing_scenario_is_one_line(command: str, capsys: pytest.CaptureFixture[str]) -> None:
    """A mistyped path is told without a traceback."""
    assert main([command, 'no.yaml']) == errors.EXIT_USAGE
    assert capsys.readouterr().err == 'rocsafe: no.yaml: no such file\n'


def test_missing_config_is_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    """The parameter file of `--config` has to be there."""
    assert main(['run', str(DERAILMENT), '--config', 'no.yaml']) == errors.EXIT_USAGE
    assert capsys.readouterr().err == 'rocsafe: no.yaml: no such file\n'


@pytest.mark.parametrize(
    ('text', 'line'),
    [
        ('a: [', 'config.yaml: line 1: '),
        ('hello', "{path}: 'hello': must be blocks `node: "),
        ('/**: {use_sim_time: true}', '{path}: use_sim_time: must be blocks `node: '),
        ('/**: {ros__parameters: 3}', '{path}: ros__parameters: must be blocks `node: '),
        ('a: 1\na: 2', "config.yaml: line 2: key 'a' is given twice"),
        ('/**/brigde: {ros__parameters: {}}', '{path}: no node brigde (did you mean bridge?)\n'),
        ('rav1: {raw: {ros__parameters: {}}}', '{path}: no node raw (did you mean rav?)\n'),
    ],
)
def test_wrong_config_is_one_line(
    text: str, line: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """What is no file of ROS parameters starts nothing."""
    path = tmp_path / 'config.yaml'
    path.write_text(text)
    assert main(['run', str(DERAILMENT), '--config', str(path)]) == errors.EXIT_USAGE
    told = capsys.readouterr().err
    assert told.startswith(f'rocsafe: {line.format(path=path)}')
    assert told.count('\n') == 1


def test_workspace_that_is_not_sourced_ends_with_3_and_leaves_nothing(
    capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """Without executables nothing begins, and no run directory is made."""
    monkeypatch.setenv('AMENT_PREFIX_PATH', '')
    assert main(['run', str(DERAILMENT), '--out', str(tmp_path)]) == errors.EXIT_SETUP
    assert 'make setup' in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_library_that_cannot_be_loaded_is_one_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    """With too little memory an import fails half-way."""

    def fail(_words: object) -> int:
        raise ImportError('libX.so: failed to map segment from shared object')

    monkeypatch.setattr(cli, '_obey', fail)
    assert main(['check', 'x.yaml']) == errors.EXIT_SETUP
    assert capsys.readouterr().err == (
        'rocsafe: cannot load all parts: libX.so: failed to map segment from shared object '
        '(too little memory, or run `make setup`)\n'
    )


def test_check_shows_what_would_fly(capsys: pytest.CaptureFixture[str]) -> None:
    """Area, viewpoints, vehicles and sources are printed."""
    assert main(['check', str(DERAILMENT)]) == errors.EXIT_COMPLETE
    text = capsys.readouterr().out
    for part in ('valid', '2.02 ha', '24.63 x 18.48 m apart', 'rav3', '454 m', 'wreck'):
        assert part in text


REAL = {'vehicles[0].link': 'udp://127.0.0.1:14550'}
OVER_THE_HOME = [[53.279, -9.0605], [53.279, -9.0615], [53.2798, -9.0615], [53.2798, -9.0605]]


@pytest.mark.parametrize(
    ('changes', 'words', 'code'),
    [
        (
            {'exclusions': [{'polygon': OVER_THE_HOME}]},
            'rav1 home lies in an exclusion',
            errors.EXIT_FAILED,
        ),
        (
            {'vehicles[0].endurance_s': 5.0, 'vehicles[1].endurance_s': 5.0},
            'endurance_s is 4 s',
            errors.EXIT_FAILED,
        ),
        (
            {'clock.start': '1066-10-14T09:00:00Z'},
            'must be within 1970-01-01 to 2038-01-01',
            errors.EXIT_USAGE,
        ),
        (
            {'vehicles[0].link': 'udp://0.0.0.0:14550'},
            'listens beyond this machine: set allow_lan: true',
            errors.EXIT_FAILED,
        ),
        (
            {'vehicles[0].link': 'udp://0.0.0.0:14550', 'vehicles[0].drone': {'allow_lan': True}},
            'set signing_key_file, or unsigned: true',
            errors.EXIT_FAILED,
        ),
        (
            REAL | {'vehicles[0].drone': {'signing_key_file': 'missing.key'}},
            'missing.key: No such file',
            errors.EXIT_FAILED,
        ),
        (
            REAL | {'vehicles[0].drone': {'image_folder': 'missing'}},
            "image folder 'missing' is no folder",
            errors.EXIT_FAILED,
        ),
        (
            REAL
            | {
                'vehicles[0].drone': {'detector': {'udp': '127.0.0.1:1', 'format_file': 'missing'}}
            },
            "format_file = 'missing': no such file",
            errors.EXIT_USAGE,
        ),
    ],
    ids=[
        'exclusion over the home',
        'endurance of 5 s',
        'start in the year 1066',
        'link to a network',
        'unsigned link',
        'no signing key',
        'no image folder',
        'no formats of a detector',
    ],
)
def test_check_finds_what_will_fail(
    changes: dict[str, object],
    words: str,
    code: int,
    small: Callable[..., Path],
    capsys: pytest.CaptureFixture[str],
) -> None:
    """The planner itself is asked, so that what it refuses in a mission is told here."""
    assert main(['check', str(small(changes))]) == code
    told = capsys.readouterr()
    assert words in told.err
    assert 'valid' not in told.out


def test_check_names_who_flies_nothing(
    small: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """A vehicle that reaches no viewpoint stays at home: the others fly all."""
    assert main(['check', str(small({'vehicles.0.endurance_s': 5.0}))]) == errors.EXIT_COMPLETE
    assert re.search('without a flight +rav1', capsys.readouterr().out)


@pytest.mark.slow
def test_check_shows_other_cameras(capsys: pytest.CaptureFixture[str]) -> None:
    """Each with its name and how it hangs."""
    scenario = DERAILMENT.with_name('derailment_cameras.yaml')
    assert main(['check', str(scenario)]) == errors.EXIT_COMPLETE
    text = capsys.readouterr().out
    assert 'camera oblique, pitch -35 deg' in text
    assert 'camera turret, in a gimbal' in text


def test_check_names_every_mistake(
    small: Callable[..., Path], capsys: pytest.CaptureFixture[str]
) -> None:
    """Each mistake is a line, with the name of the command before it."""
    path = small({'seed': -1, 'survey.height_agl_m': 0.0})
    assert main(['check', str(path)]) == errors.EXIT_USAGE
    lines = capsys.readouterr().err.splitlines()
    assert [line.split(' = ')[0] for line in lines] == [
        'rocsafe: small.yaml: seed',
        'rocsafe: small.yaml: survey.height_agl_m',
    ]


def test_report_of_something_else_is_refused(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """A folder that is no run directory is named."""
    assert main(['report', str(tmp_path)]) == errors.EXIT_USAGE
    assert 'is no run directory (it has no run.json)' in capsys.readouterr().err


def test_localize_becomes_the_executable_with_the_options(tmp_path: Path) -> None:
    """What it says is said, its exit code is the command's, and what ends one ends the other."""
    executable = tmp_path / 'lib' / 'rocsafe_radiation' / 'localize'
    executable.parent.mkdir(parents=True)
    executable.write_text('#!/bin/sh\necho "$$ got $*"\necho "error: no" >&2\nexit 2\n')
    executable.chmod(0o755)
    command = [sys.executable, '-m', 'rocsafe_orchestrator.cli', 'localize', 'good.csv', '--json']
    with subprocess.Popen(
        command,
        env={**os.environ, 'AMENT_PREFIX_PATH': str(tmp_path)},
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    ) as process:
        said, errors_said = process.communicate(timeout=60.0)
    assert (said, errors_said) == (f'{process.pid} got good.csv --json\n', 'error: no\n')
    assert process.returncode == errors.EXIT_USAGE


def test_version_is_that_of_every_package(capsys: pytest.CaptureFixture[str]) -> None:
    """`rocsafe --version` prints the version that all packages have, and the git revision."""
    sources = Path(__file__).parents[2] / 'src'
    manifests = [re.search(r'<version>(.*)</version>', path.read_text())
                 for path in sources.glob('rocsafe_*/package.xml')]  # fmt: skip
    setups = [
        re.search(r"version='(.*)'", path.read_text()) for path in sources.glob('*/setup.py')
    ]
    (version,) = {found[1] for found in (*manifests, *setups) if found is not None}
    assert None not in (*manifests, *setups)
    with pytest.raises(SystemExit) as ended:
        main(['--version'])
    assert ended.value.code == 0
    assert re.fullmatch(
        rf'rocsafe {re.escape(version)}( \(git [0-9a-f]{{12}}.*\))?\n', capsys.readouterr().out
    )


@pytest.mark.parametrize(
    ('files', 'options', 'line'),
    [
        ((), (), 'is no run directory'),
        (('scenario.yaml',), (), 'cannot be resumed: it is over, or its vehicles have no agents'),
        (('scenario.yaml', 'session.json'), (), 'cannot be resumed: it had no plan yet'),
        ((), ('--seed', '3'), '--seed: a run that is resumed keeps its own'),
    ],
)
def test_run_that_cannot_be_resumed_is_refused_by_one_line(
    files: tuple[str, ...],
    options: tuple[str, ...],
    line: str,
    tmp_path: Path,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Saying why."""
    for name in files:
        (tmp_path / name).touch()
    assert main(['run', '--resume', str(tmp_path), *options]) == errors.EXIT_SETUP
    (text,) = capsys.readouterr().err.splitlines()
    assert line in text


@pytest.mark.parametrize('command', [['check', str(DERAILMENT)], ['run', str(DERAILMENT)]])
def test_short_memory_is_told_before_anything_begins(command: list[str]) -> None:
    """A library asks for memory for ever where it gets none: the command never ended."""
    script = f'import sys; sys.argv[1:] = {command!r}\nfrom rocsafe_orchestrator.cli import main\n'
    called = [sys.executable, '-c', f'{script}raise SystemExit(main())']

    def limit() -> None:
        resource.setrlimit(resource.RLIMIT_AS, (400_000 * 1024, 400_000 * 1024))

    done = subprocess.run(
        called, preexec_fn=limit, capture_output=True, text=True, timeout=60.0, check=False
    )
    assert done.returncode == errors.EXIT_SETUP
    wanted = 'rocsafe: ulimit -v allows 400000 kB of memory: must be at least 2097152 kB'
    assert done.stderr == f'{wanted}, or unlimited\n'
