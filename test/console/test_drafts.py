# SPDX-License-Identifier: Apache-2.0
"""New missions: what is launched is what was approved; what is drawn stands in the scenario."""

import os
import stat
from pathlib import Path

import pytest
import yaml
from test.console.stage import SCENARIOS

from rocsafe_console.errors import ConsoleError, RefusedError
from rocsafe_console.runs.drafts import Drafts, with_drawn
from rocsafe_console.runs.faults import faults_of

RING = [[53.0, -9.0], [53.0, -8.99], [53.01, -8.99]]
TEXT = """\
name: yard
origin: {ground_altitude_m: 5.0, latitude_deg: 1.0, longitude_deg: 2.0}
region: {polygon: [[1, 1], [1, 2], [2, 2]]}
vehicles: [{name: rav1, home: [1, 1]}, {name: rav2, home: [1, 2]}]
"""


@pytest.fixture
def drafts(tmp_path) -> Drafts:
    """Return drafts whose command `rocsafe` tells what it was asked."""
    (tmp_path / 'bin').mkdir()
    (tmp_path / 'scenarios').mkdir()
    (tmp_path / 'scenarios' / 'yard.yaml').write_text(TEXT)
    command = tmp_path / 'bin' / 'rocsafe'
    command.write_text(
        '#!/bin/sh\nif [ "$1" = plan ]; then mkdir -p "$4"; echo "{}" > "$4/plan.json"; '
        f'echo "{{}}" > "$4/plan.geojson"; fi\necho "$@" >> {tmp_path}/told\n'
        'echo "\\033[1m$1\\033[0m done"\n[ "$1" != check ] || ! grep -q bad "$2"\n'
    )
    command.chmod(command.stat().st_mode | stat.S_IXUSR)
    path = f'{tmp_path / "bin"}:{os.environ["PATH"]}'
    environment = {'PATH': path, 'ROCSAFE_MISSION_TOKEN': 'x', 'ROCSAFE_SUPERVISOR_PID': '1'}
    return Drafts(tmp_path, tmp_path / 'scenarios', environment)


def test_what_was_drawn_stands_in_the_scenario_and_the_rest_stays():
    """Region, exclusions, one home; the origin moves to the new region."""
    drawn = {'region': RING, 'exclusions': [RING], 'homes': {'rav2': [53.0, -9.1]}}
    scenario = yaml.safe_load(with_drawn(TEXT, 'mission', drawn))
    assert scenario['name'] == 'mission'
    assert scenario['region'] == {'polygon': RING}
    assert scenario['exclusions'] == [{'polygon': RING}]
    assert [vehicle['home'] for vehicle in scenario['vehicles']] == [[1, 1], [53.0, -9.1]]
    assert scenario['origin'] == {'ground_altitude_m': 5.0}
    assert yaml.safe_load(with_drawn(TEXT, 'yard', {})) == yaml.safe_load(TEXT)


@pytest.mark.parametrize(
    ('text', 'drawn', 'words'),
    [
        ('[1]', {}, 'mapping'),
        ('a: {', {}, 'mission'),
        (TEXT, {'region': RING[:2]}, '3 to 1000 corners'),
        (TEXT, {'region': 'x'}, '3 to 1000 corners'),
        (TEXT, {'region': [[91, 0], *RING]}, 'must be on the earth'),
        (TEXT, {'exclusions': [RING[:1]]}, '3 to 1000 corners'),
    ],
)
def test_a_drawing_that_is_none_is_refused(text, drawn, words):
    """By what is wrong with it."""
    with pytest.raises(ValueError, match=words):
        with_drawn(text, 'mission', drawn)


def test_only_what_was_approved_is_launched(drafts, tmp_path):
    """A change of the draft or of its plan makes the approval void."""
    drafts.save('mission', TEXT, {})
    assert drafts.check('mission').is_done
    with pytest.raises(RefusedError, match='not the plan that was approved'):
        drafts.launch('mission', drafts.digest('mission'))
    _, _, approved = drafts.plan('mission')
    drafts.save('mission', TEXT, {'region': RING})
    with pytest.raises(RefusedError, match='not the plan that was approved'):
        drafts.launch('mission', approved)
    _, _, approved = drafts.plan('mission')
    step = drafts.launch('mission', approved, ['abcd1234'])
    assert (step.is_done, step.text) == (True, 'run done')
    told = (tmp_path / 'told').read_text().splitlines()[-1]
    assert told.startswith('run ')
    assert told.endswith('--confirm abcd1234')
    with pytest.raises(ValueError, match='confirm'):
        drafts.launch('mission', approved, ['--out=/'])


def test_a_command_that_fails_is_told_without_its_colours(drafts):
    """By its own words."""
    drafts.save('mission', TEXT.replace('yard', 'bad') + '# bad\n', {'homes': {}})
    drafts._path('mission').write_text('name: bad\n')
    step = drafts.check('mission')
    assert (step.is_done, step.text) == (False, 'check done')


@pytest.mark.parametrize('name', ['', '../x', 'a b', '-x', 'x' * 70, 'a/b'])
def test_a_draft_stays_in_its_folder(drafts, name):
    """A name is letters, digits, hyphens and underscores."""
    with pytest.raises(ValueError, match='name'):
        drafts.save(name, TEXT, {})
    with pytest.raises(ConsoleError, match='there is none'):
        drafts.text_of('scenarios', name)


def test_scenarios_and_drafts_are_listed(drafts, tmp_path: Path):
    """Each can be begun with."""
    drafts.save('mission', TEXT, {})
    assert drafts.names() == {'scenarios': ['yard'], 'drafts': ['mission']}
    assert drafts.text_of('scenarios', 'yard') == TEXT
    without = Drafts(tmp_path, tmp_path / 'scenarios', {'PATH': str(tmp_path / 'nothing')})
    with pytest.raises(ConsoleError, match='is not on the PATH'):
        without.check('mission')


SCENARIO = """\
name: x
seed: abc
survey:
  height_agl_m: -32.0
vehicles:
- name: rav1
  home: [53.28, -9.06]
- name: rav2
  cruise_spd: 8.0
"""


@pytest.mark.parametrize(
    ('printed', 'fault'),
    [
        ("seed = 'abc': must be a valid integer", ('seed', 2, "= 'abc': must be a valid integer")),
        ('survey.height_agl_m = -32.0: must be', ('survey.height_agl_m', 4, '= -32.0: must be')),
        ('vehicles[1].cruise_spd: unknown key', ('vehicles[1].cruise_spd', 9, 'unknown key')),
        # What is missing is told where it belongs.
        ('vehicles[1].home: is missing', ('vehicles[1].home', 8, 'is missing')),
        ('survey.camera.width: must be', ('survey.camera.width', 3, 'must be')),
        ('region: is missing', ('region', 0, 'is missing')),
        ("line 3: expected ',' or ']', but got ':'", ('', 3, "expected ',' or ']', but got ':'")),
        ('two vehicles would meet', ('', 0, 'two vehicles would meet')),
    ],
)
def test_a_mistake_is_told_beside_its_field(printed, fault):
    """Its path, its line in the text, and the words of `rocsafe check`."""
    (found,) = faults_of(f'some table\nrocsafe: x.yaml: {printed}\n', SCENARIO)
    assert (found.field, found.line, found.text) == fault


def test_a_scenario_without_mistakes_has_no_faults():
    """Whatever else is printed."""
    assert faults_of('x: 59 viewpoints\nwarning: windy', SCENARIO) == ()


@pytest.mark.slow
def test_the_mistakes_that_the_command_finds_stand_on_their_lines(tmp_path):
    """The real `rocsafe check` on a real scenario with four mistakes."""
    text = (SCENARIOS / 'derailment.yaml').read_text()
    text = text.replace('height_agl_m: ', 'height_agl_m: -').replace('seed: ', 'seed: x')
    (tmp_path / 'scenarios').mkdir()
    drafts = Drafts(tmp_path, tmp_path / 'scenarios', os.environ)
    saved = drafts.save('mission', text, {}).splitlines()
    step = drafts.check('mission')
    assert not step.is_done
    lines = {one.field: saved[one.line - 1].strip() for one in step.faults}
    assert lines['survey.height_agl_m'].startswith('height_agl_m: -')
    assert lines['seed'].startswith('seed: x')
