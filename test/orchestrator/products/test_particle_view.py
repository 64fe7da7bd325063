# SPDX-License-Identifier: Apache-2.0
"""What the report says of particle counters."""

import math

from rocsafe_orchestrator.products.run_record import ParticleSample
from rocsafe_orchestrator.report.sections.particle_view import particle_view

SECOND = 10**9


def sample(time_s: int, vehicle: str, fluorescent: int, *, triggered: bool) -> ParticleSample:
    """Return a window."""
    return ParticleSample(
        time_ns=time_s * SECOND, vehicle=vehicle, fluorescent=fluorescent, particles_per_l=1e4,
        triggered=triggered, latitude_deg=53.28,
        longitude_deg=math.nan if vehicle == 'b' else -9.0,
    )  # fmt: skip


def test_triggers_are_told_with_vehicle_time_and_place():
    """The most fluorescent window of each vehicle; no counts, no section."""
    samples = [
        sample(10, 'a', 2, triggered=False),
        sample(75, 'a', 40, triggered=True),
        sample(11, 'b', 3, triggered=False),
    ]
    view = particle_view(samples, 10 * SECOND)
    assert view is not None
    assert view.sentence == (
        '1 of 3 windows triggered; most fluorescent particles in one: 40, a at 01:05.'
    )
    assert (view.triggers, view.windows) == (1, 3)
    assert view.highest in view.sentence
    assert view.rows == (
        ('a', '2', '1', '40', '01:05', '53.280000, -9.000000'),
        ('b', '1', '0', '3', '00:01', 'unknown'),
    )
    assert particle_view([], 0) is None
