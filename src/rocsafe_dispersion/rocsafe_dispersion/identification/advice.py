# SPDX-License-Identifier: Apache-2.0
"""Advice from evidence: agents, what to find out next, sections of procedures that fit."""

import dataclasses
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_dispersion.identification.evidence import Evidence
from rocsafe_dispersion.identification.posterior import Identification, identify
from rocsafe_dispersion.identification.procedures import (
    RankedSection,
    Section,
    question,
    rank_sections,
)
from rocsafe_dispersion.identification.signatures import placards


@dataclass(frozen=True, slots=True, kw_only=True)
class Advice:
    """Evidence, what it says about the agent, and the sections that fit, the best first."""

    evidence: Evidence
    found: Identification
    procedures: tuple[RankedSection, ...]

    def notes(self) -> list[str]:
        """Return what the reader must know about the evidence."""
        notes, number = [], self.evidence.un_number
        if number is not None and number not in placards().values():
            notes.append(f'UN {number} is not in the table: it speaks against those that are')
        sensors = self.evidence.sensors
        if sensors and not any(report.is_seen for report in sensors):
            notes.append(
                'no detector shows gas: their silence counts only where they were in the gas'
            )
        return notes


def advice(evidence: Evidence, sections: Sequence[Section], count: int) -> Advice:
    """Return the advice with at most `count` sections."""
    found = identify(evidence)
    ranked = rank_sections(sections, question(evidence, found), count)
    return Advice(evidence=evidence, found=found, procedures=tuple(ranked))


def advice_document(given: Advice) -> dict[str, Any]:
    """Return advice as values for JSON."""
    found, evidence = given.found, given.evidence
    return {
        'agents': [
            {
                'name': name,
                'category': agents()[name].category if name in agents() else '',
                'probability': round(probability, 6),
            }
            for name, probability in found.probabilities
        ],
        'categories': {name: round(value, 6) for name, value in found.categories.items()},
        'entropy_bit': round(found.entropy_bit, 4),
        'next_observations': [
            {'observation': one.observation, 'gain_bit': round(one.gain_bit, 4)}
            for one in found.next_observations
        ],
        'notes': given.notes(),
        'evidence': _plain(evidence),
        'procedures': [_procedure(one, evidence) for one in given.procedures],
    }


def _plain(evidence: Evidence) -> dict[str, Any]:
    content = dataclasses.asdict(evidence)
    for row, report in zip(content['sensors'], evidence.sensors, strict=True):
        row |= {'unit': report.kind.unit, 'is_seen': report.is_seen}
    return content


def _procedure(ranked: RankedSection, evidence: Evidence) -> dict[str, Any]:
    """Return a section with the reports, their times and places, because of which it is there."""
    words = set(ranked.because_of)
    reports = [
        dataclasses.asdict(report)
        for report in evidence.reports
        if report.is_true and words & set(report.observation.split('_')[1:])
    ]
    return {
        'file': ranked.section.file,
        'heading': ranked.section.heading,
        'score': round(ranked.score, 4),
        'because_of': list(ranked.because_of),
        'reports': reports,
        'text': ranked.section.text,
    }
