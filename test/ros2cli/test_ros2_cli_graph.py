# SPDX-License-Identifier: Apache-2.0
"""Commands that look at the graph, word for word as ros2cli 0.32 on the same node."""

import re

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rocsafe_interfaces.action import FlyRoute
from rocsafe_interfaces.msg import Route
from rocsafe_ros2cli.message_text import yaml_text

ROBOT_SERVICES = [
    '/rav1/robot/describe_parameters',
    '/rav1/robot/get_parameter_types',
    '/rav1/robot/get_parameters',
    '/rav1/robot/get_type_description',
    '/rav1/robot/list_parameters',
    '/rav1/robot/set_parameters',
    '/rav1/robot/set_parameters_atomically',
    '/rav1/switch',
]
FLY = 'rocsafe_interfaces/action/FlyRoute'


def test_topics_are_listed(robot, ros2):
    """Without hidden ones; with types if they are wanted."""
    names = [
        '/parameter_events',
        '/rav1/command',
        '/rav1/fix',
        '/rav1/image',
        '/region',
        '/rosout',
    ]
    assert ros2('topic', 'list') == (0, '\n'.join(names) + '\n', '')
    assert '/rav1/fix [sensor_msgs/msg/NavSatFix]\n' in ros2('topic', 'list', '-t')[1]


def test_topic_info(robot, ros2):
    """Type and counts; with -v the endpoints."""
    expected = 'Type: sensor_msgs/msg/NavSatFix\nPublisher count: 1\nSubscription count: 0\n'
    assert ros2('topic', 'info', '/rav1/fix') == (0, expected, '')
    status, out, _ = ros2('topic', 'info', '/rav1/fix', '-v')
    assert status == 0
    assert out.startswith(
        'Type: sensor_msgs/msg/NavSatFix\n\nPublisher count: 1\n\n'
        'Node name: robot\nNode namespace: /rav1\nTopic type: sensor_msgs/msg/NavSatFix\n'
        'Topic type hash: RIHS01_'
    )
    assert '\n  Reliability: BEST_EFFORT\n' in out
    assert out.endswith('\n\nSubscription count: 0\n\n')
    assert ros2('topic', 'info', '/none') == (1, '', "Unknown topic '/none'\n")


def test_nodes_are_listed(robot, ros2):
    """Our own node, and that of the fixture, are hidden."""
    assert ros2('node', 'list') == (0, '/rav1/robot\n', '')


def test_node_info(robot, ros2):
    """All ends of a node, an empty line where it has none."""
    status, out, _ = ros2('node', 'info', '/rav1/robot')
    lines = out.splitlines()
    assert status == 0
    assert lines[:9] == [
        '/rav1/robot',
        '  Subscribers:',
        '    /rav1/command: std_msgs/msg/String',
        '  Publishers:',
        '    /parameter_events: rcl_interfaces/msg/ParameterEvent',
        '    /rav1/fix: sensor_msgs/msg/NavSatFix',
        '    /rav1/image: sensor_msgs/msg/CompressedImage',
        '    /region: rocsafe_interfaces/msg/Region',
        '    /rosout: rcl_interfaces/msg/Log',
    ]
    assert lines[9] == '  Service Servers:'
    assert [line.split(':')[0].strip() for line in lines[10:18]] == ROBOT_SERVICES
    assert lines[18:] == [
        '  Service Clients:',
        '',
        '  Action Servers:',
        f'    /rav1/fly_route: {FLY}',
        '  Action Clients:',
        '',
    ]
    assert ros2('node', 'info', '/none') == (1, '', "Unable to find node '/none'\n")


def test_services_are_listed(robot, ros2):
    """Without hidden ones; with types if they are wanted."""
    assert ros2('service', 'list') == (0, '\n'.join(ROBOT_SERVICES) + '\n', '')
    assert '/rav1/switch [std_srvs/srv/SetBool]\n' in ros2('service', 'list', '-t')[1]


def test_a_service_is_called(robot, ros2):
    """Request and response in Python's words, the request read from YAML."""
    expected = (
        'requester: making request: std_srvs.srv.SetBool_Request(data=True)\n\n'
        "response:\nstd_srvs.srv.SetBool_Response(success=True, message='on')\n\n"
    )
    answer = ros2('service', 'call', '/rav1/switch', 'std_srvs/srv/SetBool', '{data: true}')
    assert answer == (0, expected, '')


@pytest.mark.parametrize(
    ('words', 'error'),
    [
        (('std_srvs/srv/None',), 'The passed service type is invalid'),
        (('none/srv/SetBool',), 'The passed service type is invalid'),
        (('SetBool',), 'The passed service type is invalid'),
        (('std_msgs/msg/String',), 'The passed type is not a service'),
        (
            ('std_srvs/srv/SetBool', '{power: true}'),
            "Failed to populate field: 'SetBool_Request' object has no attribute 'power'",
        ),
    ],
)
def test_a_wrong_call_is_refused_at_once(ros2, words, error):
    """Before any node is made."""
    assert ros2('service', 'call', '/rav1/switch', *words) == (1, '', error + '\n')


def test_actions_are_listed(robot, ros2):
    """Names, with types if they are wanted."""
    assert ros2('action', 'list') == (0, '/rav1/fly_route\n', '')
    assert ros2('action', 'list', '-t') == (0, f'/rav1/fly_route [{FLY}]\n', '')


def test_a_goal_is_sent(robot, ros2):
    """Goal, feedback, result and status, each as the real command lays it out."""
    goal = FlyRoute.Goal(plan_id='p1', route=Route(vehicle='rav1'))
    status, out, error = ros2(
        'action',
        'send_goal',
        '-f',
        '/rav1/fly_route',
        FLY,
        '{plan_id: p1, route: {vehicle: rav1}}',
    )
    assert (status, error) == (0, '')
    # Feedback is printed as it comes, also before the answer of the server.
    for index in (0, 1):
        feedback = (
            f'Feedback:\n    viewpoint_index: {index}\nviewpoint_count: 0\n'
            'distance_left_m: 0.0\ntime_left_s: 0.0\n\n'
        )
        assert feedback in out
        out = out.replace(feedback, '')
    assert re.sub('[0-9a-f]{32}', '<ID>', out) == (
        'Waiting for an action server to become available...\n'
        f'Sending goal:\n     {yaml_text(goal)}\n'
        'Goal accepted with ID: <ID>\n\n'
        "Result:\n    outcome: 0\nerror_msg: ''\nviewpoints_visited: 2\nshots_taken: 0\n"
        'distance_flown_m: 0.0\nduration_s: 0.0\n\n'
        'Goal finished with status: SUCCEEDED\n'
    )


def test_a_rejected_goal_says_so(robot, ros2):
    """With status 0, as the real command."""
    status, out, _ = ros2('action', 'send_goal', '/rav1/fly_route', FLY, '{plan_id: bad}')
    assert status == 0
    goal = FlyRoute.Goal(plan_id='bad')
    assert out.endswith(f'     {yaml_text(goal)}\nGoal was rejected.\n')


def test_a_wrong_goal_is_refused_at_once(ros2):
    """Unknown type, unknown field."""
    send = ('action', 'send_goal', '/rav1/fly_route')
    invalid = 'The passed action type is invalid\n'
    assert ros2(*send, 'rocsafe_interfaces/action/None') == (1, '', invalid)
    assert ros2(*send, 'std_srvs/srv/SetBool') == (1, '', invalid)
    status, _, error = ros2(*send, FLY, '{none: 1}')
    assert status == 1
    assert error.startswith("Failed to populate field: 'FlyRoute_Goal' object has no attribute")


def test_parameters_are_listed(robot, ros2):
    """Of one node, named with or without the first slash."""
    listed = (
        '  battery.cells\n  count\n  names\n  speed_mps\n'
        '  start_type_description_service\n  use_sim_time\n'
    )
    assert ros2('param', 'list', '/rav1/robot') == (0, listed, '')
    assert ros2('param', 'list', 'rav1/robot') == (0, listed, '')
    assert ros2('param', 'list', '/none') == (1, '', 'Node not found\n')


@pytest.mark.parametrize(
    ('name', 'label', 'value'),
    [
        ('speed_mps', 'Double value is:', '5.0'),
        ('names', 'String values are:', "['a', 'b']"),
        ('battery.cells', 'Integer values are:', '[1, 2]'),
        ('use_sim_time', 'Boolean value is:', 'False'),
    ],
)
def test_a_parameter_is_shown(robot, ros2, name, label, value):
    """With its type in words."""
    assert ros2('param', 'get', '/rav1/robot', name) == (0, f'{label} {value}\n', '')


def test_a_parameter_that_is_not_there(robot, ros2):
    """The node is told from the parameter."""
    assert ros2('param', 'get', '/rav1/robot', 'none') == (1, '', 'Parameter not set\n')
    assert ros2('param', 'get', '/none', 'none') == (1, '', 'Node not found\n')


def test_a_parameter_is_set_or_refused(robot, ros2):
    """A refusal goes to standard error with the node's reason; status 0, as the real command."""
    done = (0, 'Set parameter successful\n', '')
    assert ros2('param', 'set', '/rav1/robot', 'count', '4') == done
    assert ros2('param', 'get', '/rav1/robot', 'count')[1] == 'Integer value is: 4\n'
    assert ros2('param', 'set', '/rav1/robot', 'count', '3') == done
    status, out, error = ros2('param', 'set', '/rav1/robot', 'speed_mps', '100.0')
    assert (status, out) == (0, '')
    assert error.startswith('Setting parameter failed: ')
