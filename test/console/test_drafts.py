# SPDX-License-Identifier: Apache-2.0
"""New missions: what is launched is what was approved; what is drawn stands in the scenario."""

import os
import stat
import time
from pathlib import Path

import pytest
import yaml
from test.console.stage import SCENARIOS

from rocsafe_console.errors import ConsoleError, RefusedError
from rocsafe_console.runs.drafts import Drafts, with_drawn
from rocsafe_console.runs.faults import faults_of
from rocsafe_console.runs.launches import Launch
from rocsafe_console.runs.outline import areas_of

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


def digest_of(drafts: Drafts) -> str:
    """Return the hash by which the draft would be approved."""
    return drafts.digest('mission', drafts.text_of('drafts', 'mission'))


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
        drafts.launch('mission', digest_of(drafts), 'anna')
    _, _, approved = drafts.plan('mission')
    drafts.save('mission', TEXT, {'region': RING})
    with pytest.raises(RefusedError, match='not the plan that was approved'):
        drafts.launch('mission', approved, 'anna')
    _, _, approved = drafts.plan('mission')
    launch = drafts.launch('mission', approved, 'anna', ['abcd1234'])
    assert (launch.state, launch.text) == ('done', 'run done')
    told = (tmp_path / 'told').read_text().splitlines()[-1]
    assert told.startswith('run ')
    assert told.endswith('--confirm abcd1234')
    with pytest.raises(ValueError, match='confirm'):
        drafts.launch('mission', approved, 'anna', ['--out=/'])


def test_nobody_changes_what_is_launched(drafts, tmp_path):
    """What is saved after the approval does not fly, though `rocsafe run` reads it later."""
    (tmp_path / 'drafts').mkdir()
    (tmp_path / 'drafts' / 'yard.kml').write_text('')
    drafts.save('mission', TEXT + 'terrain: yard.kml\n', {})
    _, _, approved = drafts.plan('mission')
    drafts.launch('mission', approved, 'anna')
    drafts.save('mission', TEXT, {'region': RING})
    flown = Path((tmp_path / 'told').read_text().splitlines()[-1].split()[1])
    scenario = yaml.safe_load(flown.read_text())
    assert scenario['region'] == yaml.safe_load(TEXT)['region']
    # Files beside the draft are found from where it flies.
    assert scenario['terrain'] == str(tmp_path / 'drafts' / 'yard.kml')
    assert drafts.names()['drafts'] == ['mission']


def test_a_command_that_fails_is_told_without_its_colours(drafts):
    """By its own words."""
    drafts.save('mission', TEXT.replace('yard', 'bad') + '# bad\n', {'homes': {}})
    drafts._path('mission').write_text('name: bad\n')
    step = drafts.check('mission')
    assert (step.is_done, step.text) == (False, 'check done')


def test_a_draft_finds_the_files_of_the_scenario_that_it_begins_with(drafts, tmp_path):
    """Paths are relative to a scenario, and a draft lies elsewhere; words and comments stay."""
    (tmp_path / 'scenes').mkdir()
    scene = tmp_path / 'scenes' / 'a scene: x.yaml'
    scene.write_text('')
    text = "# begin\nscene: scenes\ncamera: {scene_file: '../scenes/a scene: x.yaml'}  # end\n"
    (tmp_path / 'scenarios' / 'yard.yaml').write_text(text)
    found = drafts.text_of('scenarios', 'yard')
    assert yaml.safe_load(found) == {'scene': 'scenes', 'camera': {'scene_file': str(scene)}}
    assert found.startswith('# begin')
    assert found.endswith('# end\n')


def test_the_outline_of_a_scenario_is_its_ground_its_vehicles_and_its_camera(drafts):
    """What is wrong is left out: the page can still be used to mend it."""
    outline = drafts.outline(TEXT + 'camera: {horizontal_fov_deg: 60.0, jpeg_quality: 90}\n')
    assert outline['region'] == [[[1.0, 1.0], [1.0, 2.0], [2.0, 2.0]]]
    assert outline['vehicles'][1] == {'name': 'rav2', 'home': [1.0, 2.0]}
    assert outline['camera'] == {'horizontal_fov_deg': 60.0}
    nothing = {'region': [], 'exclusions': [], 'vehicles': [], 'camera': {}}
    for text in (
        '', '[', 'region: 5', 'region: {polygon: [[1, x], [2], 3]}',
        'region: {file: /etc/passwd}', 'exclusions: {a: 1}', 'vehicles: {a: 1}',
    ):  # fmt: skip
        assert drafts.outline(text) == nothing, text


def test_all_scenarios_that_come_with_it_can_be_begun_with(tmp_path):
    """Each has a region that the page shows."""
    drafts = Drafts(tmp_path, SCENARIOS, os.environ)
    for name in drafts.names()['scenarios']:
        assert drafts.outline(drafts.text_of('scenarios', name))['region'], name


def test_vehicles_are_chosen_and_added():
    """A new one is like the one before it, but for the link of a real one."""
    text = TEXT.replace('home: [1, 2]', 'home: [1, 2], link: udp://x, cruise_speed_mps: 7')
    drawn = {'vehicles': ['rav2', 'rav9'], 'camera': {'image_width_px': 800, 'x': 1}}
    scenario = yaml.safe_load(with_drawn(text, 'yard', {**drawn, 'homes': {'rav9': [1, 1.5]}}))
    first, second = scenario['vehicles']
    assert (first['name'], first['link']) == ('rav2', 'udp://x')
    assert second == {'name': 'rav9', 'home': [1, 1.5], 'cruise_speed_mps': 7}
    assert scenario['camera'] == {'image_width_px': 800}
    with pytest.raises(ValueError, match='one or more'):
        with_drawn(TEXT, 'yard', {'vehicles': []})


KML = (
    '<kml><Placemark><name>yard</name><Polygon><outerBoundaryIs><LinearRing><coordinates>'
    '-9,53 -8.99,53 -8.99,53.01</coordinates></LinearRing></outerBoundaryIs></Polygon></Placemark>'
    '</kml>'
)


def test_a_region_is_imported_as_the_command_line_reads_it():
    """The same formats, and the same refusals, by the name of the file."""
    (((first, *_),),) = areas_of('yard.kml', KML)
    assert first == [53.0, -9.0]
    for name, text, words in (
        ('yard.exe', '', 'must be one of'), ('yard.kml', '<kml>', r'^yard\.kml'),
        ('../../x.geojson', '{}', r'^\.\./\.\./x\.geojson'),
    ):  # fmt: skip
        with pytest.raises(ValueError, match=words):
            areas_of(name, text)


def launched(drafts: Drafts, tmp_path: Path, run: str) -> Launch:
    """Launch a draft by a command that does `run`."""
    command = tmp_path / 'bin' / 'rocsafe'
    text = command.read_text().replace('#!/bin/sh\n', f'#!/bin/sh\n[ "$1" != run ] || {run}\n', 1)
    command.write_text(text)
    drafts.save('mission', TEXT, {})
    _, _, approved = drafts.plan('mission')
    return drafts.launch('mission', approved, 'anna')


def test_the_page_is_told_by_which_plan_real_vehicles_would_take_off(drafts, tmp_path):
    """Nothing has flown; the commander launches again with its hash."""
    words = 'plan ab12cd of real vehicles is not confirmed: look at plan.json, then run again'
    run = f'{{ echo "{words}"; echo "with --confirm ab12cd, or in a terminal"; exit 1; }}'
    launch = launched(drafts, tmp_path, run)
    assert (launch.state, launch.confirm) == ('failed', 'ab12cd')


def test_a_mission_runs_once_and_is_ended(drafts, tmp_path, monkeypatch):
    """As by Ctrl-C: its own rules say who lands first."""
    monkeypatch.setattr('rocsafe_console.runs.drafts.EARLY_END_S', 0.2)
    run = "{ trap 'echo ended; exit 130' INT; while :; do sleep 0.05; done; }"
    launch = launched(drafts, tmp_path, run)
    assert (launch.state, drafts.mission('mission').state) == ('running', 'running')
    with pytest.raises(RefusedError, match='is flying'):
        drafts.launch('mission', digest_of(drafts), 'anna')
    drafts.end('mission')
    end_s = time.monotonic() + 20.0
    while drafts.mission('mission').state == 'running':
        assert time.monotonic() < end_s
        time.sleep(0.02)
    assert drafts.mission('mission').text.endswith('ended')
    with pytest.raises(RefusedError, match='no such mission'):
        drafts.end('mission')
    assert drafts.mission('other').state == 'unknown'


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
