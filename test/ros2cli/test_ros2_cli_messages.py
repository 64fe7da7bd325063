# SPDX-License-Identifier: Apache-2.0
"""Messages as text and from text, word for word as ros2cli 0.32 and rosidl_runtime_py 0.13."""

import math

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from hypothesis import given
from hypothesis import strategies as st
from rcl_interfaces.msg import ParameterValue
from sensor_msgs.msg import CompressedImage, NavSatFix, RegionOfInterest
from std_msgs.msg import Empty, String

from rocsafe_interfaces.msg import GeoPoint, GeoPolygon, Region, Route, Viewpoint
from rocsafe_ros2cli.command import CommandError
from rocsafe_ros2cli.message_fill import fill, filled_message
from rocsafe_ros2cli.message_text import TextStyle, yaml_text


def fix():
    """Return a position with numbers that are awkward to write."""
    message = NavSatFix(latitude=52.5, longitude=-1e-7, altitude=math.nan)
    message.header.frame_id = 'gps'
    message.position_covariance[0] = 1e20
    return message


def test_yaml_shows_every_field_in_the_order_of_the_definition():
    """The block of `topic echo`, exponents and NaN as YAML has them."""
    assert yaml_text(fix()) == (
        'header:\n  stamp:\n    sec: 0\n    nanosec: 0\n  frame_id: gps\n'
        'status:\n  status: -2\n  service: 0\n'
        'latitude: 52.5\nlongitude: -1.0e-07\naltitude: .nan\n'
        'position_covariance:\n- 1.0e+20\n' + '- 0.0\n' * 8 + 'position_covariance_type: 0\n'
    )


def test_long_fields_are_cut_with_dots():
    """An array shows its first elements, a string its first letters."""
    message = CompressedImage(format='abcdef', data=bytes(5))
    text = yaml_text(message, TextStyle(truncate_length=3))
    assert text.endswith("format: abc...\ndata:\n- 0\n- 0\n- 0\n- '...'\n")


@pytest.mark.parametrize(
    ('message', 'label'),
    [
        (fix(), '<array type: double[9]>'),
        (Route(), '<sequence type: rocsafe_interfaces/msg/Viewpoint, length: 0>'),
        (CompressedImage(data=bytes(7)), '<sequence type: uint8, length: 7>'),
        (ParameterValue(string_array_value=['a']), '<sequence type: string, length: 1>'),
    ],
)
def test_arrays_that_are_not_shown_tell_type_and_length(message, label):
    """The option `--no-arr`."""
    assert label in yaml_text(message, TextStyle(show_arrays=False))


def test_a_message_without_fields_is_an_empty_mapping():
    """The member that C needs in an empty structure does not show."""
    assert yaml_text(Empty()) == '{}\n'


def test_fields_are_set_from_dictionaries():
    """Nested messages, arrays of messages and of numbers; the rest keeps its values."""
    route = Route(length_m=5.0)
    values = {'vehicle': 'rav1', 'viewpoints': [{'id': 3, 'position': {'latitude': 2}}]}
    fill(route, values)
    assert route.vehicle == 'rav1'
    assert route.length_m == 5.0
    assert route.viewpoints == [Viewpoint(id=3, position=GeoPoint(latitude=2.0))]

    message = NavSatFix()
    fill(message, {'position_covariance': list(range(9)), 'latitude': 1})
    assert list(message.position_covariance) == list(range(9))
    assert message.latitude == 1.0


@pytest.mark.parametrize(
    ('kind', 'values', 'error'),
    [
        (String, {'dat': 1}, "'String' object has no attribute 'dat'"),
        (String, 'text', "Value 'text' is expected to be a dictionary but is a str"),
        (Route, {'home': 3}, "Value '3' is expected to be a dictionary but is a int"),
        (Route, {'viewpoints': [3]}, "Value '3' is expected to be a dictionary but is a int"),
        (Route, {'viewpoints': 3}, "Value '3' is expected to be a dictionary but is a int"),
        (Route, {'length_m': 'abc'}, "could not convert string to float: 'abc'"),
        (RegionOfInterest, {'height': -1}, "The 'height' field must be an unsigned integer"),
        (NavSatFix, {'position_covariance': [1]}, "The 'position_covariance' numpy.ndarray"),
        (Route, {'viewpoints': [{'id': -1}]}, "The 'id' field must be an unsigned integer"),
    ],
)
def test_wrong_values_are_refused_in_the_words_of_the_real_command(kind, values, error):
    """What the message class or the conversion says reaches the user."""
    with pytest.raises((AttributeError, TypeError, ValueError, AssertionError)) as caught:
        fill(kind(check_fields=True), values)
    assert str(caught.value).startswith(error)


def test_text_that_is_not_yaml_is_refused_in_one_line():
    """The user sees where the YAML ends to be one."""
    with pytest.raises(CommandError, match=r'not YAML: .*line 1, column') as caught:
        filled_message(String, '{a: [')
    assert '\n' not in str(caught.value)


@pytest.mark.slow
@given(
    name=st.text(st.characters(codec='utf-8', exclude_categories=['Cc', 'Cs']), max_size=20),
    corners=st.lists(st.tuples(st.floats(-90, 90), st.floats(-180, 180)), max_size=4),
)
def test_what_echo_prints_can_be_published_again(name, corners):
    """Text of a message, read as YAML, fills an equal message."""
    points = [GeoPoint(latitude=lat, longitude=lon, altitude=1.0) for lat, lon in corners]
    region = Region(name=name, boundary=GeoPolygon(points=points))
    assert filled_message(Region, yaml_text(region)) == region
