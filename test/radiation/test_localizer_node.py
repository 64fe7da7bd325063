# SPDX-License-Identifier: Apache-2.0
"""The node says what the readings so far support, also to who asks late."""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter
from visualization_msgs.msg import Marker

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_hazard import fit_cycle_node
from rocsafe_interfaces.msg import DoseAlarm, DoseRate, GeoPoint, RadiationReading
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_radiation.localizer_node import LocalizerNode
from rocsafe_ros.conversions import ns_of_stamp, region_of_area, stamp_of_ns
from rocsafe_ros.interfaces import calls, topics

from .simulated_survey import survey

DEADLINE_S = 60.0
ORIGIN = GeoPosition(53.28, -9.06, 66.0)
SOURCE = (120.0, 170.0, 9250.0)
PLACE = (53.28, -9.06, 98.0)
EASTERN_HALF = ((100.0, 0.0), (300.0, 0.0), (300.0, 300.0), (100.0, 300.0))


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
        integration_time_s=1.0,
        live_time_s=1.0,
        dose_rate_usvh=counts / 550.0,
        dose_rate_std_usvh=math.sqrt(counts) / 550.0,
        position=GeoPoint(latitude=place[0], longitude=place[1], altitude=place[2]),
    )
    reading.header.stamp = stamp_of_ns(number * 1_000_000_000)
    return reading


class Bench:
    """A localizer and the other end of its topics."""

    def __init__(self, ros, **changes):
        values = {
            'vehicles': ['rav1'],
            'origin_latitude_deg': ORIGIN.latitude_deg,
            'origin_longitude_deg': ORIGIN.longitude_deg,
            'origin_altitude_m': ORIGIN.altitude_m,
            # Most readings have come when the second fit begins: the first has too few.
            'period_s': 1.0,
            **changes,
        }
        self.ros = ros
        overrides = [Parameter(name, value=value) for name, value in values.items()]
        self.node = LocalizerNode(context=ros.context, parameter_overrides=overrides)
        self.drone = Node('drone', context=ros.context)
        self.nodes = [self.node, self.drone]
        for node in self.nodes:
            ros.executor.add_node(node)
        self.publisher = topics.create_publisher(self.drone, topics.RADIATION, 'rav1')
        self.region = topics.create_publisher(self.drone, topics.REGION)
        self.found = self.hear(topics.HAZARD_SOURCES)
        spec = calls.SUGGEST_VIEWPOINTS
        self.suggest = self.drone.create_client(spec.call_type, spec.name)
        ros.spin_until(self.is_connected, DEADLINE_S)

    def is_connected(self):
        """Whether everything that is published is also heard."""
        return (
            self.publisher.get_subscription_count() == 1
            and self.region.get_subscription_count() == 1
            and self.suggest.service_is_ready()
        )

    def hear(self, spec, vehicle=''):
        """Return the list to which messages of `spec` come from now on."""
        heard = []
        topics.create_subscription(self.drone, spec, heard.append, vehicle)
        return heard

    def fly(self, flown):
        """Publish readings."""
        for reading in flown:
            self.publisher.publish(reading)

    def wait(self, condition):
        """Spin until `condition` holds."""
        self.ros.spin_until(condition, DEADLINE_S)

    def wait_for(self, count):
        """Spin until sources are told that come from `count` readings."""
        self.wait(
            lambda: any(
                array.sources and array.sources[0].reading_count == count
                for array in self.found[-1:]
            )
        )

    def ask(self, count):
        """Return the answer to where to measure next, once there is one."""
        while True:
            future = self.suggest.call_async(SuggestViewpoints.Request(count=count))
            self.wait(future.done)
            if future.result().status != SuggestViewpoints.Response.NOT_YET:
                return future.result()

    def close(self):
        """Take the nodes down."""
        for node in self.nodes:
            self.ros.executor.remove_node(node)
            node.destroy_node()


@pytest.fixture
def benches(ros, monkeypatch):
    """A maker of benches, which are taken down at the end; fits follow each other without rest."""
    monkeypatch.setattr(fit_cycle_node, 'REST', 0.0)
    made = []

    def make(**changes):
        made.append(Bench(ros, **changes))
        return made[-1]

    yield make
    for bench in made:
        bench.close()


def test_sources_follow_the_readings_and_are_latched(benches):
    """After the last reading, all are in the estimate; a late listener gets it at once."""
    bench = benches()
    bench.fly(readings())
    bench.wait_for(441)
    late = [bench.hear(spec) for spec in (topics.HAZARD_SOURCES, topics.DOSE_MAP, topics.CORDONS)]
    bench.wait(lambda: all(late))
    check(late[0][-1])
    check_map(late[1][-1])
    check_cordons(late[2][-1])


def test_it_says_where_to_measure_next_within_the_region(benches):
    """More is wanted of a weak source; nothing of a strong one, whose place is known."""
    bench = benches(ellipse_95_m=0.001)
    assert bench.ask(5).status == SuggestViewpoints.Response.TOO_FEW_READINGS
    east = [LocalFrame(ORIGIN).position_of([x, y, 0.0]) for x, y in EASTERN_HALF]
    bench.region.publish(region_of_area(SurveyArea(boundary=tuple(east))))
    bench.fly(readings())
    bench.wait_for(441)
    answer = bench.ask(5)
    assert not answer.is_enough
    assert '0.001 m are wanted' in answer.reason
    places = [(p.latitude, p.longitude, p.altitude) for p in answer.viewpoints]
    enu = LocalFrame(ORIGIN).to_enu(*zip(*places, strict=True))
    assert len(enu) == 5
    assert enu[:, 0].min() >= 100.0
    assert all(math.hypot(x - SOURCE[0], y - SOURCE[1]) < 100.0 for x, y, _ in enu.tolist())
    assert list(answer.expected_gain) == sorted(answer.expected_gain, reverse=True)


def test_enough_is_enough(benches):
    """With the source within 5 m, nothing more is asked for."""
    bench = benches()
    bench.fly(readings())
    bench.wait_for(441)
    answer = bench.ask(5)
    assert answer.is_enough
    assert not answer.viewpoints
    assert answer.reason.startswith('1 source, placed within')
    assert bench.found[-1].is_enough
    assert bench.found[-1].false_alarm_probability == 0.01


def test_doses_add_up_and_levels_are_told(benches):
    """Three seconds at 0.36, 36 and 0.36 uSv/h; the level of 25 is reached and left."""
    bench = benches(alarm_dose_rates_usvh=[25.0], alarm_doses_usv=[0.005])
    rates = bench.hear(topics.DOSE_RATE, 'rav1')
    doses = bench.hear(topics.ACCUMULATED_DOSE, 'rav1')
    alarms = bench.hear(topics.DOSE_ALARM, 'rav1')
    bench.fly(message(k, PLACE, 550.0 * r) for k, r in ((1, 0.36), (2, 36.0), (3, 0.36)))
    bench.wait(lambda: doses and doses[-1].measured_s == pytest.approx(3.0) and len(alarms) == 3)
    assert doses[-1].dose_usv == pytest.approx(0.0102, rel=1e-3)
    assert doses[-1].dose == pytest.approx(0.0102e-6, rel=1e-3)
    assert [rate.rate for rate in rates] == pytest.approx([0.36e-6, 36e-6, 0.36e-6], rel=1e-5)
    assert {rate.units for rate in rates} == {DoseRate.UNITS_SIEVERT_PER_HOUR}
    told = sorted((a.quantity, a.triggered, a.threshold_usv) for a in alarms)
    assert told == [
        (DoseAlarm.DOSE_RATE, False, 25.0),
        (DoseAlarm.DOSE_RATE, True, 25.0),
        (DoseAlarm.DOSE, True, 0.005),
    ]
    assert alarms[0].name == 'cordon (German responders)'


def test_a_node_started_again_knows_what_the_one_before_did(benches, tmp_path):
    """Readings, sources and dose; a reading that comes again counts once."""
    flown = list(readings())
    first = benches(spool_directory=str(tmp_path))
    first.fly(flown[:300])
    first.wait_for(299)
    first.close()
    first.nodes.clear()
    second = benches(spool_directory=str(tmp_path))
    doses = second.hear(topics.ACCUMULATED_DOSE, 'rav1')
    second.fly(flown[290:])
    second.wait_for(441)
    check(second.found[-1])
    expected = sum(reading.dose_rate_usvh for reading in flown) / 3600.0
    second.wait(lambda: doses and doses[-1].header.stamp.sec == 441)
    assert doses[-1].dose_usv == pytest.approx(expected)


def test_the_grid_of_beliefs_serves_the_same_topics(benches):
    """Sources, and the grid itself."""
    bench = benches(method='belief-grid')
    beliefs = bench.hear(topics.BELIEF_MAP)
    bench.fly(readings())
    bench.wait_for(441)
    # The grid of the same readings comes after the sources; earlier ones know less.
    bench.wait(lambda: beliefs and max(beliefs[-1].data) >= 90)
    assert bench.found[-1].method == 'belief-grid'
    assert min(beliefs[-1].data) == 0


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


def check_cordons(array):
    """Assert that cordons are closed lines around the source."""
    clear, *lines = array.markers
    assert clear.action == Marker.DELETEALL
    assert {line.ns for line in lines} >= {'100 uSv/h mean', '100 uSv/h upper_95'}
    (hundred,) = [line for line in lines if line.ns == '100 uSv/h mean']
    assert hundred.points[0] == hundred.points[-1]
    distances = [math.hypot(p.x - SOURCE[0], p.y - SOURCE[1]) for p in hundred.points]
    assert min(distances) > 8.0
    assert max(distances) < 12.0
