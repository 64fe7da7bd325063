# SPDX-License-Identifier: Apache-2.0
"""What the report says of particle counters."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from rocsafe_orchestrator.products.run_record import ParticleSample
from rocsafe_view import formats


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleView:
    """A sentence, its figures, and a row for each vehicle."""

    sentence: str
    triggers: int
    windows: int
    highest: str
    rows: tuple[tuple[str, ...], ...]


def particle_view(samples: Sequence[ParticleSample], begin_ns: int) -> ParticleView | None:
    """Return what to show, None without counts."""
    if not samples:
        return None
    triggers = [one for one in samples if one.triggered]
    names = sorted({one.vehicle for one in samples})
    sentence, highest = f'{len(triggers)} of {len(samples)} windows triggered', ''
    if triggers:
        most = max(triggers, key=lambda one: one.fluorescent)
        highest = (
            f'most fluorescent particles in one: {most.fluorescent}, {most.vehicle} at '
            f'{formats.clock((most.time_ns - begin_ns) / 1e9)}'
        )
        sentence += f'; {highest}'
    rows = tuple(_row([one for one in samples if one.vehicle == name], begin_ns) for name in names)
    return ParticleView(
        sentence=f'{sentence}.',
        triggers=len(triggers),
        windows=len(samples),
        highest=highest,
        rows=rows,
    )


def _row(samples: Sequence[ParticleSample], begin_ns: int) -> tuple[str, ...]:
    most = max(samples, key=lambda one: one.fluorescent)
    place = f'{most.latitude_deg:.6f}, {most.longitude_deg:.6f}'
    return (
        most.vehicle,
        f'{len(samples)}',
        f'{sum(one.triggered for one in samples)}',
        f'{most.fluorescent}',
        formats.clock((most.time_ns - begin_ns) / 1e9),
        place if math.isfinite(most.latitude_deg + most.longitude_deg) else 'unknown',
    )
