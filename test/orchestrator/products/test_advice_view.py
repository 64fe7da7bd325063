# SPDX-License-Identifier: Apache-2.0
"""What the report says of the agent, from what the command `advise` wrote."""

import json
from pathlib import Path
from typing import Any

import pytest

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products import agent_advice
from rocsafe_orchestrator.products.agent_advice import advise
from rocsafe_orchestrator.report.sections.advice_view import advice_view

REPORT = {
    'observation': 'smell_chlorine',
    'is_true': True,
    'witness': 'driver',
    'time': '14:05',
    'place_deg': [53.28, -9.06],
}
CONTENT: dict[str, Any] = {
    'agents': [
        {'name': 'hydrogen_sulphide', 'category': 'industrial', 'probability': 0.9},
        {'name': 'no agent', 'category': '', 'probability': 0.1},
    ],
    'next_observations': [{'observation': 'smell_fish', 'gain_bit': 0.3}],
    'notes': ['UN 1079 is not in the table'],
    'evidence': {
        'reports': [REPORT],
        'sensors': [
            {'sensor': 'ion_mobility', 'reading': 1.0, 'unit': 'mg_m3', 'is_seen': True},
            {'sensor': 'metal_oxide', 'reading': 0.0, 'unit': 'ppm', 'is_seen': False},
        ],
        'un_number': 1079,
    },
    'procedures': [
        {
            'file': 'a.md',
            'heading': 'Chlorine',
            'score': 1.0,
            'because_of': ['chlorine'],
            'reports': [REPORT],
            'text': 'Stay upwind.',
        }
    ],
}


@pytest.fixture
def calls(monkeypatch: pytest.MonkeyPatch) -> list[list[str]]:
    """Return the arguments with which the command would have been started."""
    found: list[list[str]] = []
    monkeypatch.setattr(agent_advice, 'run_estimator', lambda *call: found.append(list(call[2])))
    return found


def test_agents_evidence_and_procedures_are_rows(tmp_path: Path, calls) -> None:
    """With units, times and places; a silent detector is said to be silent."""
    (tmp_path / 'advice.json').write_text(json.dumps(CONTENT))
    view = advice_view(advise(tmp_path / 'estimator.yaml', tmp_path))
    assert view is not None
    assert view.sentence.startswith('Most probable: hydrogen sulphide (')
    assert view.sentence.endswith('To be found out next: smell fish.')
    assert view.agent_rows[1][:2] == ('no agent', '-')
    assert view.evidence_rows[0][:2] == ('ion mobility', '1 mg/m³')
    assert view.evidence_rows[1][:2] == ('metal oxide', 'silent')
    assert view.evidence_rows[2][:4] == ('smell chlorine', 'yes', 'driver', '14:05')
    assert '53.28' in view.evidence_rows[2][4]
    assert view.evidence_rows[3][0] == 'placard UN 1079'
    ((title, because, text),) = view.procedure_rows
    assert (title, text) == ('a.md: Chlorine', 'Stay upwind.')
    assert '14:05' in because
    assert view.are_examples


def test_evidence_and_procedures_of_the_run_are_used(tmp_path: Path, calls) -> None:
    """If they are there."""
    (tmp_path / 'advice.json').write_text(json.dumps(CONTENT))
    advise(tmp_path / 'e.yaml', tmp_path)
    (tmp_path / 'evidence.yaml').touch()
    (tmp_path / 'procedures').mkdir()
    assert not advise(tmp_path / 'e.yaml', tmp_path).is_example
    before, after = calls
    assert before == [f'--readings={tmp_path / "e.yaml"}', f'--out={tmp_path}']
    assert after[2:] == [
        str(tmp_path / 'evidence.yaml'), f'--procedures={tmp_path / "procedures"}'
    ]  # fmt: skip


def test_without_advice_there_is_no_section() -> None:
    """The report says elsewhere what is missing."""
    assert advice_view(None) is None


def test_a_file_that_lacks_something_is_told(tmp_path: Path, calls) -> None:
    """In one line."""
    (tmp_path / 'advice.json').write_text('{"agents": []}')
    with pytest.raises(OrchestratorError, match=r'advice\.json cannot be read'):
        advise(tmp_path / 'estimator.yaml', tmp_path)
