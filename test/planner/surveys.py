# SPDX-License-Identifier: Apache-2.0
"""Hypothesis draws surveys of all kinds: regions, exclusions, fleets, wind."""

import math

from hypothesis import strategies as st

from rocsafe_geo.motion.autopilot import DIRECT, Autopilot
from rocsafe_geo.position import GeoPosition, offset
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_planner.plan.survey_region import SurveyRegion

from .fleets import request, vehicle

CENTRE = GeoPosition(53.28, -9.06)


def ring(places):
    """Return the ring of places (east, north) in metres about the centre."""
    return tuple(offset(CENTRE, east, north) for east, north in places)


def star(count, radii, turn=0.0, centre=(0.0, 0.0)):
    """Return the corners of a star-shaped polygon: concave where radii differ much."""
    angles = [turn + math.tau * k / count for k in range(count)]
    return [
        (centre[0] + r * math.cos(a), centre[1] + r * math.sin(a))
        for r, a in zip(radii, angles, strict=True)
    ]


@st.composite
def areas(draw):
    """Draw concave stars, some with a hole, thin strips, tiny yards and single points."""
    kind = draw(st.sampled_from(('star', 'holed', 'thin', 'tiny')))
    if kind == 'thin':
        length, turn = draw(st.floats(50.0, 400.0)), draw(st.floats(0.0, 3.0))
        cos, sin = math.cos(turn), math.sin(turn)
        corners = [(-length, 0.0), (length, 0.0), (length, 0.5), (-length, 0.5)]
        return SurveyArea(ring([(x * cos - y * sin, x * sin + y * cos) for x, y in corners]))
    if kind == 'tiny':
        return SurveyArea(ring([(0.0, 0.0), (0.5, 0.0), (0.0, 0.5)]))
    count = draw(st.integers(3, 8))
    radii = draw(st.lists(st.floats(30.0, 180.0), min_size=count, max_size=count))
    corners = star(count, radii, draw(st.floats(0.0, 6.0)))
    holes = [ring([(0.3 * x, 0.3 * y) for x, y in corners])] if kind == 'holed' else []
    return SurveyArea(ring(corners), tuple(holes))


AUTOPILOTS = (
    Autopilot(),
    DIRECT,
    Autopilot(jerk_mps3=4.0, smoothing_s=0.0, waypoint_radius_m=8.0, landing_height_m=50.0),
)


@st.composite
def fleets(draw):
    """Draw one to four unlike vehicles that stand outside the regions."""
    made = []
    for number in range(draw(st.integers(1, 4))):
        bearing, far = draw(st.floats(0.0, 6.2)), draw(st.floats(210.0, 600.0))
        home = offset(CENTRE, far * math.cos(bearing), far * math.sin(bearing))
        landing = draw(st.sampled_from(('home', 'home', 'open', 'elsewhere')))
        made.append(
            vehicle(
                f'rav{number}',
                (home.latitude_deg, home.longitude_deg),
                cruise_speed_mps=draw(st.floats(4.0, 15.0)),
                acceleration_mps2=draw(st.floats(0.5, 4.0)),
                hover_s=draw(st.just(0.0) | st.floats(0.0, 3.0)),
                autopilot=draw(st.sampled_from(AUTOPILOTS)),
                endurance_s=draw(st.sampled_from((900.0, 10_000.0))),
                battery_swap_s=60.0,
                is_open=landing == 'open',
                end=offset(CENTRE, 0.0, -far) if landing == 'elsewhere' else None,
                sensors=draw(st.sampled_from(((), ('gamma',)))) if number else ('gamma',),
            )
        )
    return tuple(made)


@st.composite
def exclusions(draw):
    """Draw up to two zones inside or across the regions."""
    zones = []
    for _ in range(draw(st.integers(0, 2))):
        centre = (draw(st.floats(-120.0, 120.0)), draw(st.floats(-120.0, 120.0)))
        radii = draw(st.lists(st.floats(10.0, 60.0), min_size=5, max_size=5))
        zones.append(SurveyArea(ring(star(5, radii, centre=centre))))
    return tuple(zones)


@st.composite
def surveys(draw, **changes):
    """Draw a whole request, its vehicles slower than no wind."""
    return request(
        **{
            'regions': (
                SurveyRegion(area=draw(areas()), sensors=draw(st.sampled_from(((), ('gamma',))))),
            ),
            'vehicles': draw(fleets()),
            'exclusions': draw(exclusions()),
            'wind_mps': (draw(st.floats(-2.5, 2.5)), draw(st.floats(-2.5, 2.5))),
            'grid': draw(st.sampled_from(('axis_aligned', 'rotated', 'best'))),
            'distance_m': draw(st.sampled_from((0.0, 5.0))),
            'height_agl_m': 40.0,
            **changes,
        }
    )
