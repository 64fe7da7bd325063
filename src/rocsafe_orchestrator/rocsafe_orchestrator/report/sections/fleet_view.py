# SPDX-License-Identifier: Apache-2.0
"""What the report says of agents: who heard whom, plans made anew, rounds, duplicates."""

from collections.abc import Callable
from dataclasses import dataclass

from rocsafe_orchestrator.products.run_record import AgentSample
from rocsafe_view import formats

Row = tuple[str, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetView:
    """The rows of the tables of the agents.

    Attributes
    ----------
    sentence
        The most important in words.
    vehicles
        Names, the columns of `contact_rows` after the first.
    contact_rows
        Of each agent the part of the time for which it heard each other.
    epoch_rows
        Number, time, coordinator, members and unable vehicles of each plan made anew.
    round_rows
        Number, time, chooser, places and reason of each round of the search.
    agent_rows
        Of each agent its last epoch, plans flown, bytes sent, epochs with another plan.
    """

    sentence: str
    vehicles: tuple[str, ...]
    contact_rows: tuple[Row, ...]
    epoch_rows: tuple[Row, ...]
    round_rows: tuple[Row, ...]
    agent_rows: tuple[Row, ...]


def fleet_view(samples: tuple[AgentSample, ...], begin_ns: int) -> FleetView | None:
    """Return what to show, None for a mission without agents."""
    if not samples:
        return None
    own: dict[str, list[AgentSample]] = {}
    for sample in samples:
        own.setdefault(sample.vehicle, []).append(sample)
    names = tuple(sorted(own))
    # Parts of a fleet have epochs of their own.
    epochs = _firsts(samples, lambda one: (one.epoch, one.coordinator))
    rounds = _firsts(samples, lambda one: (one.search_round, one.search_by))
    duplicates = max(sample.duplicates for sample in samples)
    alarms = max(sample.alarms for sample in samples)
    return FleetView(
        sentence=f'{_count(len(names), "agent")}, {_count(len(epochs), "plan")} made anew, '
        f'{_count(duplicates, "photograph")} taken twice, '
        f'{_count(alarms, "epoch")} with plans that differ.',
        vehicles=names,
        contact_rows=tuple(_contact(name, own[name], names) for name in names),
        epoch_rows=tuple(_epoch(sample, begin_ns) for sample in epochs),
        round_rows=tuple(_round(sample, begin_ns) for sample in rounds),
        agent_rows=tuple(_agent(name, own[name]) for name in names),
    )


def _count(count: int, what: str) -> str:
    return f'{count} {what}' if count == 1 else f'{count} {what}s'


def _firsts(
    samples: tuple[AgentSample, ...], key_of: Callable[[AgentSample], tuple[int, str]]
) -> list[AgentSample]:
    """Return the first sample of each number of each agent, where both are told."""
    first: dict[tuple[int, str], AgentSample] = {}
    for sample in sorted(samples, key=lambda one: one.time_ns):
        first.setdefault(key_of(sample), sample)
    return [sample for key, sample in first.items() if all(key)]


def _contact(name: str, samples: list[AgentSample], names: tuple[str, ...]) -> Row:
    shares = (sum(other in one.heard for one in samples) / len(samples) for other in names)
    cells = (
        '' if other == name else formats.percent(share, 0)
        for other, share in zip(names, shares, strict=True)
    )
    return (name, *cells)


def _round(sample: AgentSample, begin_ns: int) -> Row:
    return (
        f'{sample.search_round}',
        formats.clock(max(0.0, 1e-9 * (sample.time_ns - begin_ns))),
        sample.search_by,
        f'{sample.search_places}' if sample.search_places else 'none: the search is over',
        sample.search_text,
    )


def _epoch(sample: AgentSample, begin_ns: int) -> Row:
    return (
        f'{sample.epoch}',
        formats.clock(max(0.0, 1e-9 * (sample.time_ns - begin_ns))),
        sample.coordinator,
        ', '.join(sample.members),
        ', '.join(sample.unable) or 'none',
    )


def _agent(name: str, samples: list[AgentSample]) -> Row:
    last = samples[-1]
    flown = {(one.epoch, one.coordinator) for one in samples if one.coordinator}
    return name, f'{last.epoch}', f'{len(flown)}', f'{last.bytes_sent}', f'{last.alarms}'
