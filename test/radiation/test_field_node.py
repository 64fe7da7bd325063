# SPDX-License-Identifier: Apache-2.0
"""The node answers each fix once, in order, with the dose rate at the true position."""

import math
from pathlib import Path

import pytest
import yaml

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.node import Node
from rclpy.parameter import Parameter
from rosgraph_msgs.msg import Clock
from sensor_msgs.msg import NavSatFix, NavSatStatus

from rocsafe_geo.position import GeoPosition, offset
from rocsafe_interfaces.msg import GeoPoint, RadiationReading
from rocsafe_interfaces.srv import QueryRadiationField
from rocsafe_radiation.field_node import FieldNode
from rocsafe_ros.conversions import ns_of_stamp, stamp_of_ns
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.parameters import ParameterError

DEADLINE_S = 60.0
STEP_NS = 200_000_000
WRECK = GeoPosition(53.2838, -9.0633, 60.0)
ABOVE = offset(WRECK, 0.0, 0.0, 32.0)
# 2.57 uSv/s / 32^2 * 3600 s/h; geocentric coordinates round to 1 nm.
RATE_ABOVE_USVH = 9.03515625
RATE_TOLERANCE = 3e-10


@pytest.fixture
def field_file(tmp_path):
    """Return a settings file of one source at the wreck."""
    file = tmp_path / 'field.yaml'
    place = [WRECK.latitude_deg, WRECK.longitude_deg]
    source = {'name': 'wreck', 'position': place, 'sigma_usvps': 2.57}
    content = {'sources': [source], 'ground_altitude_m': WRECK.altitude_m}
    file.write_text(yaml.safe_dump(content))
    return str(file)


def parameters(**values):
    """Return the parameters of a node."""
    return [Parameter(name, value=value) for name, value in values.items()]


def fix_at(number, position=ABOVE, status=NavSatStatus.STATUS_FIX):
    """Return the fix of step `number`."""
    fix = NavSatFix(
        latitude=position.latitude_deg,
        longitude=position.longitude_deg,
        altitude=position.altitude_m,
    )
    fix.status.status = status
    fix.header.stamp = stamp_of_ns(number * STEP_NS)
    return fix


class Bench:
    """A field node and the other end of its topics."""

    def __init__(self, ros, **values):
        self.ros = ros
        given = parameters(vehicles=['rav1'], **values)
        self.node = FieldNode(context=ros.context, parameter_overrides=given)
        self.drone = Node('drone', context=ros.context)
        self.readings = []
        self.reports = []
        self.fix = topics.create_publisher(self.drone, topics.FIX, 'rav1')
        self.truth = topics.create_publisher(self.drone, topics.GROUND_TRUTH_FIX, 'rav1')
        self.clock = topics.create_publisher(self.drone, topics.CLOCK)
        topics.create_subscription(self.drone, topics.RADIATION, self.readings.append, 'rav1')
        topics.create_subscription(self.drone, topics.STEP_DONE, self.reports.append)
        self.query = self.drone.create_client(QueryRadiationField, calls.QUERY_FIELD.name)
        for node in (self.node, self.drone):
            ros.executor.add_node(node)
        ros.spin_until(self.is_connected, DEADLINE_S)

    def is_connected(self):
        """Whether everything that is published is also heard."""
        return (
            self.fix.get_subscription_count() == 1
            and self.query.service_is_ready()
            and self.drone.count_publishers('rav1/radiation') == 1
        )

    def wait(self, count):
        """Spin until `count` readings have come."""
        self.ros.spin_until(lambda: len(self.readings) >= count, DEADLINE_S)

    def stamps(self):
        """Return the step numbers of the readings."""
        return [ns_of_stamp(reading.header.stamp) // STEP_NS for reading in self.readings]

    def ask(self, *points):
        """Return the answer to a query."""
        future = self.query.call_async(QueryRadiationField.Request(points=list(points)))
        self.ros.spin_until(future.done, DEADLINE_S)
        return future.result()

    def close(self):
        """Take the nodes down."""
        for node in (self.node, self.drone):
            self.ros.executor.remove_node(node)
            node.destroy_node()


@pytest.fixture
def bench(ros, field_file):
    """A field node that reads at the true position."""
    bench = Bench(ros, field_file=field_file)
    yield bench
    bench.close()


def test_a_reading_has_the_stamp_of_the_fix_and_the_rate_of_the_true_position(bench):
    """The position it states is the believed one."""
    believed = offset(ABOVE, 1.5, -0.7)
    bench.truth.publish(fix_at(1))
    bench.fix.publish(fix_at(1, believed))
    bench.wait(1)
    (reading,) = bench.readings
    assert bench.stamps() == [1]
    assert reading.header.frame_id == 'rav1/radiation_sensor'
    assert reading.dose_rate_usvh == pytest.approx(RATE_ABOVE_USVH, rel=RATE_TOLERANCE)
    assert reading.position.latitude == believed.latitude_deg
    assert reading.radiation_type == RadiationReading.RADIATION_TYPE_GAMMA
    assert (reading.model, reading.detector) == ('paper', 'ideal')
    assert math.isnan(reading.live_time_s)


def test_stamps_said_again_are_not_answered_again(bench):
    """A resent step adds nothing; the next step is answered as ever."""
    for number in (1, 2, 1, 2, 3):
        bench.truth.publish(fix_at(number))
        bench.fix.publish(fix_at(number))
    bench.wait(3)
    bench.ask()
    assert bench.stamps() == [1, 2, 3]


def test_without_a_fix_the_reading_goes_on_and_its_position_is_nan(bench):
    """The detector does not need to know where it is."""
    bench.truth.publish(fix_at(1))
    bench.fix.publish(fix_at(1, status=NavSatStatus.STATUS_NO_FIX))
    bench.wait(1)
    (reading,) = bench.readings
    assert reading.dose_rate_usvh == pytest.approx(RATE_ABOVE_USVH, rel=RATE_TOLERANCE)
    assert math.isnan(reading.position.latitude)


def test_at_the_fix_there_is_no_reading_without_a_fix(ros, field_file):
    """A real vehicle has no true position that is published: nothing is made up."""
    bench = Bench(ros, field_file=field_file, vehicles_at_their_fix=['rav1'])
    bench.fix.publish(fix_at(1, status=NavSatStatus.STATUS_NO_FIX))
    bench.fix.publish(fix_at(2))
    bench.wait(1)
    assert bench.stamps() == [2]
    assert bench.readings[0].dose_rate_usvh == pytest.approx(RATE_ABOVE_USVH, rel=RATE_TOLERANCE)
    bench.close()


def test_a_query_gives_a_rate_for_each_point(bench):
    """Finite at the source too."""
    above = GeoPoint(
        latitude=ABOVE.latitude_deg, longitude=ABOVE.longitude_deg, altitude=ABOVE.altitude_m
    )
    source = GeoPoint(
        latitude=WRECK.latitude_deg, longitude=WRECK.longitude_deg, altitude=WRECK.altitude_m
    )
    answer = bench.ask(above, source)
    expected = [RATE_ABOVE_USVH, 2.57 / 0.1**2 * 3600.0]
    assert answer.error_code == QueryRadiationField.Request.NONE
    assert list(answer.dose_rate_usvh) == pytest.approx(expected, rel=RATE_TOLERANCE)


def test_a_query_for_no_place_names_the_point(bench):
    """And answers for none of them."""
    answer = bench.ask(GeoPoint(latitude=95.0))
    assert answer.error_code == QueryRadiationField.Request.INVALID_POINT
    assert 'point 0: latitude = 95.0' in answer.error_msg
    assert len(answer.dose_rate_usvh) == 0


def test_it_reports_each_step_and_is_always_idle(ros, bench):
    """The world never waits for it longer than for one message."""
    ros.spin_until(lambda: bench.clock.get_subscription_count() >= 1, DEADLINE_S)
    bench.clock.publish(Clock(clock=stamp_of_ns(STEP_NS)))
    ros.spin_until(lambda: len(bench.reports) > 0, DEADLINE_S)
    assert bench.reports[0].participant == 'radiation_field'
    assert bench.reports[0].is_idle


@pytest.mark.parametrize(
    ('values', 'words'),
    [
        ({'source_names': ['wreck']}, 'parameter source_names is now in the file of field_file'),
        ({'background_usvh': 0.1}, 'parameter background_usvh is now in the file of field_file'),
        ({'field_file': '/none.yaml'}, '/none.yaml: no such file'),
    ],
)
def test_what_is_gone_or_not_there_is_refused_in_one_line(ros, values, words):
    """Naming what took its place."""
    with pytest.raises(ParameterError, match=words) as caught:
        FieldNode(context=ros.context, parameter_overrides=parameters(**values))
    assert '\n' not in str(caught.value)


def test_the_example_of_the_manual_is_a_field(ros, tmp_path):
    """The settings file of docs/radiation.md, as it stands there; the first source is seen."""
    manual = (Path(__file__).parents[2] / 'docs' / 'radiation.md').read_text()
    example = manual.partition('here `ground.yaml`:\n\n```yaml\n')[2].partition('```')[0]
    assert 'sources:' in example
    file = tmp_path / 'ground.yaml'
    file.write_text(example)
    bench = Bench(ros, field_file=str(file), model='shielded')
    near, far = (
        GeoPoint(latitude=53.2799 + north, longitude=-9.0630, altitude=70.0)
        for north in (0.0, 0.01)
    )
    rates = bench.ask(near, far).dose_rate_usvh
    assert rates[0] > 20.0 * rates[1] > 0.0
    bench.close()
