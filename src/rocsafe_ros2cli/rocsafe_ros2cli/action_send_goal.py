# SPDX-License-Identifier: Apache-2.0
"""`ros2 action send_goal`."""

from argparse import ArgumentParser, Namespace
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient

from rocsafe_ros2cli.command import CommandError, Verb
from rocsafe_ros2cli.command_node import NAME_PREFIX, CommandNode, command_node
from rocsafe_ros2cli.interfaces import interface_class
from rocsafe_ros2cli.message_fill import fill, new_message, read_values, values_text
from rocsafe_ros2cli.message_text import yaml_text
from rocsafe_ros2cli.topic_graph import full_topic_name

CANCEL_LIMIT_S = 5.0
"""How long the server may take to confirm that a goal is being cancelled."""

STATUS_NAMES = {
    GoalStatus.STATUS_ACCEPTED: 'ACCEPTED',
    GoalStatus.STATUS_EXECUTING: 'EXECUTING',
    GoalStatus.STATUS_CANCELING: 'CANCELING',
    GoalStatus.STATUS_SUCCEEDED: 'SUCCEEDED',
    GoalStatus.STATUS_CANCELED: 'CANCELED',
    GoalStatus.STATUS_ABORTED: 'ABORTED',
}

ENDED = (GoalStatus.STATUS_SUCCEEDED, GoalStatus.STATUS_CANCELED, GoalStatus.STATUS_ABORTED)


def _add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `send_goal`."""
    parser.add_argument('action_name', help="Name of the action (e.g. '/rav1/fly_route')")
    parser.add_argument('action_type', help='Type of the action (package/action/Name)')
    values = parser.add_mutually_exclusive_group()
    values.add_argument('goal', nargs='?', default='{}', help="YAML (e.g. '{order: 10}')")
    values.add_argument('--stdin', action='store_true', help='Read goal from standard input')
    parser.add_argument('-f', '--feedback', action='store_true', help='Show the feedback')


def _send_goal(options: Namespace) -> int:
    """Send a goal and wait for its result; Ctrl-C cancels it."""
    action_type = interface_class(
        options.action_type, 'action', 'The passed action type is invalid'
    )
    goal = new_message(action_type.Goal)
    values = read_values(values_text(options.goal, from_stdin=options.stdin))
    try:
        fill(goal, values)
    except Exception as error:  # the setters of messages raise what they like
        raise CommandError(f'Failed to populate message fields: {error!r}') from error
    name = f'{NAME_PREFIX}_send_goal_{options.action_type.replace("/", "_")}'
    with command_node(name) as holder:
        action_name = full_topic_name(holder.node, options.action_name)
        client = ActionClient(holder.node, action_type, action_name)
        try:
            _run_goal(holder, client, goal, options)
        finally:
            holder.stop()
            client.destroy()
    return 0


def _run_goal(holder: CommandNode, client: Any, goal: Any, options: Namespace) -> None:
    """Send the goal and print what becomes of it."""
    print('Waiting for an action server to become available...')
    holder.spin_until(client.server_is_ready)
    print(f'Sending goal:\n     {yaml_text(goal)}')
    sent = client.send_goal_async(goal, _print_feedback if options.feedback else None)
    try:
        _follow(holder, sent)
    except BaseException:
        _cancel(holder, sent)
        raise


def _follow(holder: CommandNode, sent: Any) -> None:
    """Print what becomes of a goal."""
    holder.spin_until(sent.done)
    handle = sent.result()
    if handle is None:
        raise CommandError(f'Exception while sending goal: {sent.exception()!r}')
    if not handle.accepted:
        print('Goal was rejected.')
        return
    print(f'Goal accepted with ID: {bytes(handle.goal_id.uuid).hex()}\n')
    future = handle.get_result_async()
    holder.spin_until(future.done)
    response = future.result()
    if response is None:
        raise CommandError(f'Exception while getting result: {future.exception()!r}')
    print(f'Result:\n    {yaml_text(response.result)}')
    print(f'Goal finished with status: {STATUS_NAMES.get(response.status, "UNKNOWN")}')


def _print_feedback(message: Any) -> None:
    """Print one feedback."""
    print(f'Feedback:\n    {yaml_text(message.feedback)}')


def _cancel(holder: CommandNode, sent: Any) -> None:
    """Cancel a goal whose end nobody waits for any more; one not yet accepted as soon as it is."""
    holder.spin_until(sent.done, CANCEL_LIMIT_S)
    handle = sent.result() if sent.done() else None
    if handle is None or not handle.accepted or handle.status in ENDED:
        return
    print('Canceling goal...')
    future = handle.cancel_goal_async()
    if not holder.spin_until(future.done, CANCEL_LIMIT_S):
        raise CommandError(f'Failed to cancel goal: no answer within {CANCEL_LIMIT_S:g} s')
    response = future.result()
    if response is None:
        raise CommandError(f'Exception while canceling goal: {future.exception()!r}')
    if not any(goal.goal_id == handle.goal_id for goal in response.goals_canceling):
        raise CommandError('Failed to cancel goal')
    print('Goal canceled.')


VERB = Verb(
    name='send_goal',
    summary='Send an action goal',
    add_arguments=_add_arguments,
    run=_send_goal,
)
