# SPDX-License-Identifier: Apache-2.0
"""The node says what the readings so far support, also to who asks late."""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_interfaces.msg import GeoPoint, RadiationReading
from rocsafe_radiation.localizer_node import LocalizerNode
from rocsafe_ros import topics
from rocsafe_ros.conversions import ns_of_stamp, stamp_of_ns

from .simulated_survey import survey

DEADLINE_S = 60.0
ORIGIN = GeoPosition(53.28, -9.06, 66.0)
SOURCE = (120.0, 170.0, 9250.0)


def readings():
    """Return messages of a survey over the source, the first without a place."""
    flown = survey([SOURCE])
    places = LocalFrame(ORIGIN).to_geodetic(flown.positions_enu_m)
    yield message(0, (math.nan, math.nan, math.nan), 5.0)
    for number, place in enumerate(places.tolist(), 1):
        yield message(number, place, flown.counts[number - 1])


def message(number, place, counts):
    """Return a reading of one second with 550 counts a second for 1 uSv/h."""
    reading = RadiationReading(
        model='paper',
        counts=int(counts),
        live_time_s=1.0,
        dose_rate_usvh=counts / 550.0,
        dose_rate_std_usvh=math.sqrt(counts) / 550.0,
        position=GeoPoint(latitude=place[0], longitude=place[1], altitude=place[2]),
    )
    reading.header.stamp = stamp_of_ns(number * 1_000_000_000)
    return reading


def test_sources_follow_the_readings_and_are_latched(ros):
    """After the last reading, all are in the estimate; a late listener gets it at once."""
    values = {
        'vehicles': ['rav1'],
        'origin_latitude_deg': ORIGIN.latitude_deg,
        'origin_longitude_deg': ORIGIN.longitude_deg,
        'origin_altitude_m': ORIGIN.altitude_m,
        'period_s': 0.2,
    }
    overrides = [Parameter(name, value=value) for name, value in values.items()]
    node = LocalizerNode(context=ros.context, parameter_overrides=overrides)
    drone = Node('drone', context=ros.context)
    late = Node('late', context=ros.context)
    for each in (node, drone, late):
        ros.executor.add_node(each)
    try:
        publisher = topics.create_publisher(drone, topics.RADIATION, 'rav1')
        early = []
        topics.create_subscription(drone, topics.HAZARD_SOURCES, early.append)
        ros.spin_until(lambda: publisher.get_subscription_count() == 1, DEADLINE_S)
        for reading in readings():
            publisher.publish(reading)
        ros.spin_until(lambda: early and early[-1].sources[0].reading_count == 441, DEADLINE_S)
        heard, maps = [], []
        topics.create_subscription(late, topics.DOSE_MAP, maps.append)
        topics.create_subscription(late, topics.HAZARD_SOURCES, heard.append)
        ros.spin_until(lambda: heard and maps, DEADLINE_S)
        check(heard[-1])
        check_map(maps[-1])
    finally:
        for each in (node, drone, late):
            ros.executor.remove_node(each)
            each.destroy_node()


def check(array):
    """Assert that `array` tells the source."""
    (source,) = array.sources
    place = GeoPosition(
        source.position.latitude, source.position.longitude, source.position.altitude
    )
    east, north, up = LocalFrame(ORIGIN).enu_of(place)
    assert math.hypot(east - SOURCE[0], north - SOURCE[1]) < 2.0
    assert abs(up - 0.5) < 3.0
    assert source.dose_rate_at_1m_usvh == pytest.approx(SOURCE[2], rel=0.2)
    assert source.position_covariance[0] > 0.0
    assert array.source_count_probability[1] > 0.9
    assert array.method == 'poisson-ml'
    assert ns_of_stamp(array.header.stamp) == 441_000_000_000


def check_map(grid):
    """Assert that `grid` is highest at the source: 9250 uSv/h at 1 m are 83 of 100."""
    info = grid.info
    column = round((SOURCE[0] - info.origin.position.x) / info.resolution)
    row = round((SOURCE[1] - info.origin.position.y) / info.resolution)
    cells = list(grid.data)
    assert len(cells) == info.width * info.height
    assert cells[row * info.width + column] > 60
    assert cells[0] < 40
    assert grid.header.frame_id == 'map'
