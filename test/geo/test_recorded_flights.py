# SPDX-License-Identifier: Apache-2.0
"""The model of flight against flights of a real autopilot."""

import csv
import os
from pathlib import Path

import numpy as np
import pytest
import shapely
from test.geo.recorded_surveys import HEIGHT_M, RECORDED, Recorded

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.route_motion import RouteMotion
from rocsafe_geo.position import GeoPosition

HOME = GeoPosition(47.3977420, 8.5455940, 0.0)
TRACK_TOLERANCE_M = 1.0
# Of the climb and of the return, which the table of surveys leaves out.
OVERHEAD_TOLERANCE = 0.02
RECORDED_CLIMB_S = 26.3
RECORDED_RETURN_S = 91.5


@pytest.mark.parametrize('survey', RECORDED, ids=lambda survey: survey.name)
def test_recorded_surveys_take_as_long(survey: Recorded) -> None:
    """Within 2 % without wind, within 5 % in it."""
    assert survey.model_s() == pytest.approx(survey.recorded_s, rel=survey.tolerance)


def test_take_off_and_return_take_as_long() -> None:
    """50 m up from the order; 284 m home and down until the motors stand."""
    flyer = RECORDED[1].performance()
    assert flyer.ascent_s(HEIGHT_M) == pytest.approx(RECORDED_CLIMB_S, rel=OVERHEAD_TOLERANCE)
    home = float(flyer.legs_s(np.array([284.0, 0.0]))) + flyer.descent_s(HEIGHT_M)
    assert home == pytest.approx(RECORDED_RETURN_S, rel=OVERHEAD_TOLERANCE)


@pytest.fixture
def recording() -> Path:
    """Return the folder of the recorded survey."""
    shared = os.environ.get('ROCSAFE_SHARED')
    if not shared:
        pytest.skip('ROCSAFE_SHARED names no folder with recorded flights')
    folder = Path(shared) / 'data' / 'sitl'
    if not (folder / 'sitl_survey_track.csv').is_file():
        pytest.skip(f'{folder} holds no recorded survey')
    return folder


def rows_of(path: Path) -> list[dict[str, str]]:
    """Return the rows of a CSV file."""
    with path.open() as file:
        return list(csv.DictReader(file))


def test_recorded_track_is_the_model_s(recording: Path) -> None:
    """From the first waypoint to the last, flown and modelled tracks stay within 1 m."""
    frame = LocalFrame(HOME)
    mission = [
        row
        for row in rows_of(recording / 'sitl_survey_mission.csv')
        if row['command'] == '16' and row['reached_t_s']
    ]
    latitudes, longitudes = (
        [float(row[key]) for row in mission] for key in ('lat_deg', 'lon_deg')
    )
    places = frame.to_enu(latitudes, longitudes, 0.0)[:, :2].tolist()
    reached = [float(row['reached_t_s']) for row in mission]
    flown = track_between(rows_of(recording / 'sitl_survey_track.csv'), reached, frame)
    flyer = RECORDED[1].performance()
    here, ways = (0.0, 0.0, HEIGHT_M), []
    for number, (east, north) in enumerate(places, start=1):
        place = (east, north, HEIGHT_M)
        ways.append(flyer.way(here, place, is_passed=number < len(places)))
        here = place
    motion = RouteMotion((0.0, 0.0, HEIGHT_M), ways, flyer.corner_radius_m)
    times = np.linspace(motion.arrivals_s[0], motion.arrivals_s[-1], 3000)
    modelled = motion.positions(times)[:, :2]
    apart = [
        shapely.distance(shapely.LineString(a), shapely.points(b)).max()
        for a, b in ((flown, modelled), (modelled, flown))
    ]
    assert max(apart) <= TRACK_TOLERANCE_M
    assert motion.arrivals_s[-1] - motion.arrivals_s[0] == pytest.approx(
        reached[-1] - reached[0], rel=0.02
    )


def track_between(
    rows: list[dict[str, str]], reached: list[float], frame: LocalFrame
) -> np.ndarray:
    """Return (east, north) of the recorded track from the first waypoint to the last."""
    inside = [row for row in rows if reached[0] <= float(row['t_s']) <= reached[-1]]
    latitudes = [float(row['lat_deg']) for row in inside]
    longitudes = [float(row['lon_deg']) for row in inside]
    return frame.to_enu(latitudes, longitudes, 0.0)[:, :2]
