# SPDX-License-Identifier: Apache-2.0
"""How near vehicles came to each other in the air, by their recorded tracks."""

import numpy as np
import pytest

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.products.run_record import (
    FlightLog,
    RecordingFacts,
    Track,
    VehicleSample,
)
from rocsafe_orchestrator.products.separation import airborne_spans_ns, nearest_in_the_air

NS = 1_000_000_000
FRAME = LocalFrame(GeoPosition(53.28, -9.06, 66.0))
FACTS = RecordingFacts(message_count=0, start_ns=0)
WAITING, FLYING, LANDED = 11, 4, 8


def track(*places: tuple[float, float, float], step_s: float = 1.0) -> Track:
    """Return a track through places (east, north, up), one each step."""
    geodetic = FRAME.to_geodetic(np.array(places))
    return Track(
        time_ns=(np.arange(len(places)) * step_s * NS).astype(np.int64),
        latitude_deg=geodetic[:, 0],
        longitude_deg=geodetic[:, 1],
        altitude_m=geodetic[:, 2],
        is_truth=True,
    )


def samples(*states: tuple[float, int]) -> tuple[VehicleSample, ...]:
    """Return what a vehicle said of itself: (seconds, state)."""
    return tuple(
        VehicleSample(
            time_ns=round(time_s * NS),
            state=state,
            plan_id='p',
            viewpoint_count=1,
            viewpoints_visited=0,
            shots_taken=0,
            battery_fraction=1.0,
            distance_flown_m=0.0,
            text='',
        )
        for time_s, state in states
    )


CROSSING = {
    'rav1': track((-10.0, 0.0, 30.0), (10.0, 0.0, 30.0)),
    'rav2': track((0.0, -10.0, 33.0), (0.0, 10.0, 33.0)),
}


def test_least_distance_lies_between_two_records() -> None:
    """Both pass over one place at once, 3 m apart in height, halfway between their records."""
    flying = samples((0.0, FLYING), (1.0, FLYING))
    log = FlightLog(facts=FACTS, tracks=CROSSING, samples={'rav1': flying, 'rav2': flying})
    nearest = nearest_in_the_air(log)
    assert nearest is not None
    assert nearest.distance_m == pytest.approx(3.0, abs=1e-3)
    assert nearest.vehicles == ('rav1', 'rav2')
    assert nearest.time_ns == pytest.approx(0.5 * NS, abs=0.001 * NS)


def test_who_is_on_the_ground_is_near_to_nobody() -> None:
    """Only while both fly do they count; never at once: there is no distance."""
    early, late = samples((0.0, FLYING), (0.2, LANDED)), samples((0.0, WAITING), (0.6, FLYING))
    log = FlightLog(facts=FACTS, tracks=CROSSING, samples={'rav1': early, 'rav2': late})
    assert nearest_in_the_air(log) is None
    both = FlightLog(
        facts=FACTS, tracks=CROSSING, samples={'rav1': samples((0.0, FLYING)), 'rav2': late}
    )
    assert nearest_in_the_air(both) is None


def test_two_flights_are_two_spans() -> None:
    """Between them the vehicle stands on the ground for a new battery."""
    said = samples((0.0, FLYING), (1.0, FLYING), (2.0, WAITING), (5.0, FLYING), (9.0, LANDED))
    assert airborne_spans_ns(said) == ((0, 2 * NS), (5 * NS, 9 * NS))
