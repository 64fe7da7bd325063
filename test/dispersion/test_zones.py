# SPDX-License-Identifier: Apache-2.0
"""Threat zones against bisection, bounds over uncertain wind, exposure over time."""

import json
import math

import numpy as np
import pytest
from scipy.optimize import brentq

from rocsafe_dispersion.agents.agent_table import agent
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.plume.steady_plume import SteadyPlume
from rocsafe_dispersion.zones.exposure import Exposure, MapGrid
from rocsafe_dispersion.zones.levels import response_levels
from rocsafe_dispersion.zones.threat_zones import area_above, lines_at, threat_zones, zones_geojson
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.wind.wind_vector import wind_from

from .airs import EASTWARDS, LAYER

CHLORINE = agent('chlorine')
RELEASE = Release(place_m=(0.0, 0.0), height_m=1.0, rate_g_s=100.0)
TRAVEL = similarity_travel(LAYER, 1.0)
GRID = MapGrid(west_m=-100.0, south_m=-500.0, cell_m=10.0, columns=301, rows=101)
PLUME = SteadyPlume(release=RELEASE, travel=TRAVEL, wind=EASTWARDS)


def field(plume: SteadyPlume) -> np.ndarray:
    """Return the concentrations of a plume on the grid."""
    return plume.concentrations_g_m3(GRID.places_m()).reshape(GRID.rows, GRID.columns)


def test_zone_ends_where_bisection_says():
    """Within 2 % on the axis of the plume, for all levels."""
    zones = threat_zones(GRID, [field(PLUME)], response_levels(CHLORINE))
    assert [zone.level.label for zone in zones] == [
        'AEGL-1 (60 min)', 'AEGL-2 (60 min)', 'AEGL-3 (60 min)',
    ]  # fmt: skip
    for zone in zones:
        if zone.is_cut:
            continue
        end = brentq(
            lambda x, level=zone.level.g_m3: float(
                PLUME.concentrations_g_m3(np.array([[x, 0.0, 1.5]]))[0] - level
            ),
            20.0,
            20_000.0,
        )
        assert zone.farthest_m == pytest.approx(end, rel=0.02)
    assert sum(not zone.is_cut for zone in zones) >= 2


def test_outer_bound_holds_the_expected_area():
    """And is larger where the wind is uncertain."""
    winds = [wind_from(5.0, 270.0 + turn) for turn in np.linspace(-20.0, 20.0, 21)]
    maps = [field(SteadyPlume(release=RELEASE, travel=TRAVEL, wind=wind)) for wind in winds]
    zone = threat_zones(GRID, maps, response_levels(CHLORINE)[1:2])[0]
    sure = threat_zones(GRID, [field(PLUME)], response_levels(CHLORINE)[1:2])[0]
    assert zone.outer.contains(zone.expected)
    assert zone.outer.area > 2.0 * sure.expected.area
    assert sure.outer.equals(sure.expected)


def test_area_of_a_disc_with_a_hole():
    """Known areas."""
    east, north = np.meshgrid(GRID.east_m() - 1400.0, GRID.north_m())
    radius = np.hypot(east, north)
    area = area_above(GRID, np.exp(-(((radius - 300.0) / 100.0) ** 2)), math.exp(-1.0))
    assert area.area == pytest.approx(math.pi * (400.0**2 - 200.0**2), rel=0.02)
    assert len(area.geoms) == 1
    assert len(area.geoms[0].interiors) == 1


def test_no_zone_where_nothing_is_exceeded():
    """Empty, not cut."""
    zone = threat_zones(GRID, [np.zeros((GRID.rows, GRID.columns))], response_levels(CHLORINE))[0]
    assert zone.expected.is_empty
    assert zone.farthest_m == 0.0
    assert not zone.is_cut


def test_geojson_lies_where_the_plume_is():
    """Longitudes first, east of the release, and readable by anybody."""
    frame = LocalFrame(GeoPosition(53.0, -9.0, 0.0))
    zones = threat_zones(GRID, [field(PLUME)], response_levels(CHLORINE)[2:])
    document = json.loads(json.dumps(zones_geojson(zones, frame, {'agent': 'chlorine'})))
    first = document['features'][0]
    assert first['properties']['averaging_minutes'] == 60.0
    assert first['properties']['agent'] == 'chlorine'
    points = np.array(first['geometry']['coordinates'][0][0])
    assert points[:, 0].max() > -9.0 + 0.001
    assert np.abs(points[:, 1] - 53.0).max() < 0.01


def test_levels_without_a_published_time_do_not_exist():
    """Neither are ERPG taken for other times; they are for 60 minutes."""
    assert response_levels(CHLORINE, 45.0) == []
    assert response_levels(agent('lewisite')) == []
    names = [level.name for level in response_levels(agent('sulphur_dioxide'))]
    assert names == ['AEGL-1', 'AEGL-2', 'AEGL-3']


def test_largest_mean_of_a_cloud_that_passes():
    """Of 10 minutes of gas within an hour, the mean over 30 minutes is a third."""
    exposure = Exposure(60.0, 30.0, 2.0, arrival_g_m3=0.5)
    for minute in range(1, 61):
        exposure.add(60.0 * minute, np.array([[1.0 if 20 < minute <= 30 else 0.0, 0.2]]))
    assert exposure.largest_mean_g_m3() == pytest.approx(np.array([[1.0 / 3.0, 0.2]]))
    assert exposure.load() == pytest.approx(np.array([[10.0, 60.0 * 0.04]]))
    assert exposure.arrival_s()[0, 0] == 21.0 * 60.0
    assert math.isinf(exposure.arrival_s()[0, 1])


def test_short_exposure_counts_as_clean_air_before():
    """Five minutes of gas are a twelfth of the mean of an hour."""
    exposure = Exposure(60.0, 60.0)
    for minute in range(1, 6):
        exposure.add(60.0 * minute, np.ones((1, 1)))
    assert exposure.largest_mean_g_m3()[0, 0] == pytest.approx(5.0 / 60.0)


@pytest.mark.parametrize(
    'make',
    [
        lambda: threat_zones(GRID, [], []),
        lambda: threat_zones(GRID, [np.zeros((2, 2))], []),
        lambda: threat_zones(GRID, [np.full((GRID.rows, GRID.columns), np.nan)], []),
        lambda: MapGrid(west_m=0, south_m=0, cell_m=0.0, columns=9, rows=9),
        lambda: Exposure(7.0, 1.0),
        lambda: Exposure(1.0, 1.0).load(),
        lambda: Exposure(1.0, 1.0).arrival_s(),
    ],
)
def test_bad_values_are_refused(make):
    """With one error type."""
    with pytest.raises(ValueError, match=r'must|need'):
        make()


def test_lines_leave_out_the_edge_of_ground_without_a_value():
    """Times of arrival are infinite upwind: no line of any time runs along that edge."""
    east = np.tile(GRID.east_m(), (GRID.rows, 1))
    arrival = np.where(east > 0.0, east / 5.0, np.inf)
    for time_s in (30.0, 60.0):
        (line,) = lines_at(GRID, arrival, time_s)
        assert line[:, 0] == pytest.approx(5.0 * time_s)
        assert np.ptp(line[:, 1]) == pytest.approx(GRID.cell_m * (GRID.rows - 1))
    assert lines_at(GRID, np.full_like(arrival, np.inf), 30.0) == []
