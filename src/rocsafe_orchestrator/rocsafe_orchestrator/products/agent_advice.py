# SPDX-License-Identifier: Apache-2.0
"""Which agent the detectors and witnesses of a run name, and procedures: ``advice.json``.

Of the run directory, ``evidence.yaml`` and the folder ``procedures`` are used if they are there.
"""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products.estimator_process import run_estimator
from rocsafe_orchestrator.run_directory import PROCEDURES

EVIDENCE_FILE = 'evidence.yaml'


@dataclass(frozen=True, slots=True, kw_only=True)
class NamedAgent:
    """An agent, its category, and its probability."""

    name: str
    category: str
    probability: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Observed:
    """A report of a witness, with its time and place as he gave them, or empty."""

    observation: str
    is_true: bool
    witness: str
    time: str
    place_deg: tuple[float, float] | None


@dataclass(frozen=True, slots=True, kw_only=True)
class Detected:
    """The highest reading of a detector, in its unit."""

    sensor: str
    reading: float
    unit: str
    is_seen: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Procedure:
    """A section of a procedure, and the words and observations because of which it fits."""

    file: str
    heading: str
    text: str
    because_of: tuple[str, ...]
    observations: tuple[Observed, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentAdvice:
    """The agents, the most probable first, and what to find out and to do next.

    Attributes
    ----------
    next_observations
        Observation, and what knowing it would tell on average, bit.
    notes
        What the reader must know about the evidence.
    is_example
        Whether the procedures are the examples that are shipped.
    """

    agents: tuple[NamedAgent, ...]
    reports: tuple[Observed, ...]
    sensors: tuple[Detected, ...]
    un_number: int | None
    next_observations: tuple[tuple[str, float], ...]
    procedures: tuple[Procedure, ...]
    notes: tuple[str, ...]
    is_example: bool


def advise(parameters: Path, folder: Path) -> AgentAdvice:
    """Name the agent from what the estimator with the file `parameters` kept.

    ``advice.json`` is written to `folder`.

    Raises
    ------
    OrchestratorError
        If there is no advice, with the reason.
    """
    evidence, procedures = folder / EVIDENCE_FILE, folder / PROCEDURES
    arguments = [f'--readings={parameters}', f'--out={folder}']
    arguments += [str(evidence)] * evidence.exists()
    arguments += [f'--procedures={procedures}'] * procedures.exists()
    run_estimator('rocsafe_dispersion', 'advise', arguments)
    try:
        content = json.loads((folder / 'advice.json').read_text(encoding='utf-8'))
        return _advice(content, is_example=not procedures.exists())
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise OrchestratorError(f'advice.json cannot be read: {error}') from error


def _advice(content: Mapping[str, Any], *, is_example: bool) -> AgentAdvice:
    evidence = content['evidence']
    return AgentAdvice(
        agents=tuple(NamedAgent(**row) for row in content['agents']),
        reports=tuple(map(_observed, evidence['reports'])),
        sensors=tuple(map(_detected, evidence['sensors'])),
        un_number=evidence['un_number'],
        next_observations=tuple(
            (row['observation'], row['gain_bit']) for row in content['next_observations']
        ),
        procedures=tuple(map(_procedure, content['procedures'])),
        notes=tuple(content['notes']),
        is_example=is_example,
    )


def _observed(row: Mapping[str, Any]) -> Observed:
    place = row['place_deg']
    return Observed(
        observation=row['observation'],
        is_true=row['is_true'],
        witness=row['witness'],
        time=row['time'],
        place_deg=None if place is None else (place[0], place[1]),
    )


def _detected(row: Mapping[str, Any]) -> Detected:
    return Detected(
        sensor=row['sensor'], reading=row['reading'], unit=row['unit'], is_seen=row['is_seen']
    )


def _procedure(row: Mapping[str, Any]) -> Procedure:
    return Procedure(
        file=row['file'],
        heading=row['heading'],
        text=row['text'],
        because_of=tuple(row['because_of']),
        observations=tuple(map(_observed, row['reports'])),
    )
