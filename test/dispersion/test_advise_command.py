# SPDX-License-Identifier: Apache-2.0
"""The command `advise` and the ranking of procedures."""

import json
from pathlib import Path

import pytest

from rocsafe_dispersion.command_line.advise_command import main
from rocsafe_dispersion.identification.procedures import (
    SHIPPED,
    Section,
    rank_sections,
    read_sections,
)

EVIDENCE = """\
un_number: 1017
reports:
  - observation: smell_chlorine
    is_true: true
    witness: driver of the train
    time: 2026-05-01T14:05Z
    place_deg: [53.28, -9.06]
  - {observation: smell_fish, is_true: false}
sensors:
  - {sensor: electrochemical_chlorine, reading: 8.0}
"""


def test_evidence_of_a_file_with_its_procedures(tmp_path: Path, capsys):
    """The agent first, and with each procedure the reports that led to it, time and place."""
    path = tmp_path / 'evidence.yaml'
    path.write_text(EVIDENCE, encoding='utf-8')
    assert main([str(path), '--sensor', 'pid_10_6_ev=0', '--json', f'--out={tmp_path}']) == 0
    document = json.loads(capsys.readouterr().out)
    assert document['agents'][0]['name'] == 'chlorine'
    assert document['agents'][0]['probability'] > 0.99
    first = document['procedures'][0]
    assert first['file'] == 'irritant-gas.md'
    assert first['heading'] == 'Chlorine, UN 1017'
    (report,) = first['reports']
    assert report['time'] == '2026-05-01T14:05Z'
    assert report['place_deg'] == [53.28, -9.06]
    assert json.loads((tmp_path / 'advice.json').read_text(encoding='utf-8')) == document


def test_without_evidence_nothing_is_confident(capsys):
    """No agent stands out and no procedure is recommended."""
    assert main(['--json']) == 0
    document = json.loads(capsys.readouterr().out)
    assert document['agents'][0]['probability'] < 0.2
    assert document['procedures'] == []
    assert document['next_observations'][0]['gain_bit'] > 0.0


@pytest.mark.parametrize(
    ('signs', 'file'),
    [
        (['--saw=sign_cholinergic_crisis', '--saw=effect_nerve'], 'nerve-agent.md'),
        (['--saw=smell_bitter_almonds', '--saw=effect_blood'], 'cyanide-and-asphyxiants.md'),
        (['--saw=smell_geranium', '--saw=effect_blister'], 'blister-agent.md'),
        (['--un=1005'], 'irritant-gas.md'),
        (['--sensor=pid_10_6_ev=5'], 'unknown-gas.md'),
    ],
)
def test_the_fitting_procedure_is_first(signs, file, capsys):
    """Of those shipped."""
    assert main([*signs, '--json']) == 0
    assert json.loads(capsys.readouterr().out)['procedures'][0]['file'] == file


def test_a_reading_that_fits_many_agents_recommends_no_procedure_of_one(capsys):
    """A lamp that shows gas is no sign of a nerve or blister agent."""
    assert main(['--sensor=pid_10_6_ev=5', '--json']) == 0
    found = json.loads(capsys.readouterr().out)['procedures']
    assert {row['file'] for row in found} == {'unknown-gas.md'}


def test_text_says_agents_next_observation_and_procedures(capsys):
    """And what the reader must know."""
    assert main(['--un=1079', '--sensor=pid_10_6_ev=0', '--saw=smell_pungent']) == 0
    text = capsys.readouterr().out
    assert 'note: UN 1079 is not in the table' in text
    assert 'note: no detector shows gas' in text
    assert 'find out next:' in text
    assert 'procedures:' in text


def test_ranking_needs_a_common_word_and_prefers_the_rare_one():
    """A word of every section does not decide."""
    sections = [
        Section(file=f'{at}.md', heading='gas', text=text)
        for at, text in enumerate(['gas and water', 'gas and chlorine', 'gas and sand'])
    ]
    (first, *_) = rank_sections(sections, {'gas': 1.0, 'chlorine': 1.0})
    assert first.section.file == '1.md'
    assert first.because_of == ('chlorine', 'gas')
    assert rank_sections(sections, {'geranium': 1.0}) == ()
    assert rank_sections(sections, {}) == ()
    assert rank_sections((), {'gas': 1.0}) == ()


def test_sections_of_the_shipped_examples_say_what_they_are():
    """Every file names itself an example."""
    sections = read_sections(SHIPPED)
    assert len({section.file for section in sections}) == len(list(SHIPPED.glob('*.md')))
    for file in SHIPPED.glob('*.md'):
        assert 'It is no procedure of any service' in file.read_text(encoding='utf-8')


@pytest.mark.parametrize(
    ('arguments', 'message'),
    [
        (['--saw=smell_x'], 'observation'),
        (['--sensor=pid_10_6_ev'], 'must be KIND=READING'),
        (['--sensor=pid_10_6_ev=nan'], 'reading'),
        (['--procedures=nowhere'], 'must be a folder'),
        (['--un=5000'], 'un_number'),
        (['--readings=nowhere.yaml'], 'nowhere.yaml'),
        (['--readings=evidence.yaml'], 'no parameter file'),
        (['nowhere.yaml'], 'nowhere.yaml'),
        (['evidence.yaml', '--un=1005'], 'the file says un_number 1017'),
        (['wrong.yaml'], 'reports'),
        (['--procedures=empty'], 'has no Markdown file'),
        (['--procedures=binary'], 'must be text in UTF-8'),
        (['--count=0'], '--count'),
    ],
)
def test_bad_input_gives_one_line(arguments, message, tmp_path: Path, monkeypatch, capsys):
    """And exit code 2."""
    monkeypatch.chdir(tmp_path)
    Path('evidence.yaml').write_text(EVIDENCE, encoding='utf-8')
    Path('wrong.yaml').write_text('reports: [{observation: smell_fish}]\n', encoding='utf-8')
    Path('empty').mkdir()
    Path('binary').mkdir()
    Path('binary/a.md').write_bytes(b'\xff\xfe\x00')
    assert main(arguments) == 2
    error = capsys.readouterr().err
    assert error.startswith('error: ')
    assert message in error
    assert error.count('\n') == 1
