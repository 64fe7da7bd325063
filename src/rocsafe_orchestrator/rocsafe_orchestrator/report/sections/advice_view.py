# SPDX-License-Identifier: Apache-2.0
"""What the report says of the agent and of procedures."""

from dataclasses import dataclass

from rocsafe_orchestrator.products.agent_advice import AgentAdvice, Detected, Observed, Procedure
from rocsafe_orchestrator.products.release_estimates import sensor_name
from rocsafe_view import formats

# Agents and observations shown.
MOST_AGENTS, MOST_NEXT = 5, 3


@dataclass(frozen=True, slots=True, kw_only=True)
class AdviceView:
    """The sentences and the rows of the tables of agents, evidence and procedures."""

    sentence: str
    notes: tuple[str, ...]
    agent_rows: tuple[tuple[str, ...], ...]
    evidence_rows: tuple[tuple[str, ...], ...]
    procedure_rows: tuple[tuple[str, ...], ...]
    are_examples: bool


def advice_view(found: AgentAdvice | None) -> AdviceView | None:
    """Return what to show, None without advice."""
    if found is None:
        return None
    first = found.agents[0]
    wanted = formats.sentence_list(
        [_words(name) for name, _ in found.next_observations[:MOST_NEXT]]
    )
    return AdviceView(
        sentence=f'Most probable: {_words(first.name)} ({formats.probability(first.probability)}).'
        f' To be found out next: {wanted}.',
        notes=found.notes,
        agent_rows=tuple(
            (_words(one.name), one.category or '-', formats.probability(one.probability))
            for one in found.agents[:MOST_AGENTS]
        ),
        evidence_rows=_evidence_rows(found),
        procedure_rows=tuple(map(_procedure, found.procedures)),
        are_examples=found.is_example,
    )


def _evidence_rows(found: AgentAdvice) -> tuple[tuple[str, ...], ...]:
    rows = [*map(_detected, found.sensors), *map(_observed, found.reports)]
    if found.un_number is not None:
        rows.append((f'placard UN {found.un_number}', 'read', '-', '-', '-'))
    return tuple(rows)


def _detected(one: Detected) -> tuple[str, ...]:
    shown = f'{one.reading:.3g} {formats.gas_unit(one.unit)}' if one.is_seen else 'silent'
    return sensor_name(one.sensor), shown, 'detector', '-', '-'


def _observed(one: Observed) -> tuple[str, ...]:
    said = 'yes' if one.is_true else 'no'
    return _words(one.observation), said, one.witness or '-', one.time or '-', _place(one) or '-'


def _procedure(one: Procedure) -> tuple[str, ...]:
    where = [
        ' '.join(part for part in (_words(seen.observation), seen.time, _place(seen)) if part)
        for seen in one.observations
    ]
    because = '; '.join([', '.join(one.because_of), *where])
    return f'{one.file}: {one.heading}', because, one.text


def _place(one: Observed) -> str:
    return '' if one.place_deg is None else formats.latitude_longitude(*one.place_deg)


def _words(name: str) -> str:
    return name.replace('_', ' ')
