# SPDX-License-Identifier: Apache-2.0
"""Routes that real vehicles do not fly are refused in one line, not flown in part."""

import pytest

pytest.importorskip('rocsafe_interfaces', reason='no ROS 2 here: source it or run make setup')

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import Flight, GeoPoint, Route, Viewpoint
from rocsafe_mavlink.drone.drone import DroneSpec
from rocsafe_mavlink.plan.flight_limits import FlightLimits
from rocsafe_mavlink.vehicle_interface.conversions import assignment_of

PLACE = GeoPosition(53.28, -9.06, 60.0)
VIEW = Viewpoint(
    id=3, position=GeoPoint(latitude=53.2801, longitude=-9.06, altitude=92.0), height_agl_m=32.0
)
SPEC = DroneSpec(name='rav1', target=(1, 1), frame=LocalFrame(PLACE), limits=FlightLimits())


def route(**changes):
    """Return a route of one flight over one viewpoint."""
    home = GeoPoint(latitude=53.28, longitude=-9.06, altitude=60.0)
    fields = {'viewpoints': [VIEW], 'flights': [Flight(viewpoints=[VIEW])], **changes}
    return Route(vehicle='rav1', home=home, **fields)


def test_plain_route_is_taken():
    """One flight, at once, from home to home."""
    plan = assignment_of(route(), 'p', SPEC).plan
    assert [stop.height_m for stop in plan.stops] == [32.0]


@pytest.mark.parametrize(
    ('changes', 'words'),
    [
        (
            {'flights': [Flight(viewpoints=[VIEW]), Flight()]},
            'has 2 flights: must be 1',
        ),
        ({'is_open': True}, 'ends elsewhere: must end at home'),
        ({'end': [GeoPoint(latitude=53.281, longitude=-9.06)]}, 'ends elsewhere'),
        ({'viewpoints': [], 'flights': []}, 'height_m'),
    ],
)
def test_route_beyond_that_is_refused(changes, words):
    """The line names what it is, its value and what it must be."""
    with pytest.raises(ValueError, match=words) as caught:
        assignment_of(route(**changes), 'p', SPEC)
    assert '\n' not in str(caught.value)
