# SPDX-License-Identifier: Apache-2.0
"""`ros2 action`."""

from argparse import Namespace
from typing import Any

from action_msgs.msg import GoalStatus
from rclpy.action import ActionClient, get_action_names_and_types

from rocsafe_ros2cli.command import CommandError, Verb, argument, flag
from rocsafe_ros2cli.command_node import CommandNode, command_node, graph_node
from rocsafe_ros2cli.interfaces import interface_class
from rocsafe_ros2cli.message_fill import filled_message
from rocsafe_ros2cli.message_text import yaml_text
from rocsafe_ros2cli.names import full_name, print_names

CANCEL_LIMIT_S = 5.0
"""Longest wait for the server to confirm that a goal is being cancelled."""

STATUS_NAMES = {
    GoalStatus.STATUS_SUCCEEDED: 'SUCCEEDED',
    GoalStatus.STATUS_CANCELED: 'CANCELED',
    GoalStatus.STATUS_ABORTED: 'ABORTED',
}


def _list(options: Namespace) -> None:
    """List actions."""
    with graph_node() as node:
        print_names(get_action_names_and_types(node), show_types=options.show_types)


def _send_goal(options: Namespace) -> None:
    """Send a goal and wait for its result; Ctrl-C cancels it."""
    action_type = interface_class(
        options.action_type, 'action', 'The passed action type is invalid'
    )
    goal = filled_message(action_type.Goal, options.goal)
    with command_node() as holder:
        client = ActionClient(
            holder.node, action_type, full_name(holder.node, options.action_name)
        )
        try:
            _run_goal(holder, client, goal, with_feedback=options.feedback)
        finally:
            holder.stop()
            client.destroy()


def _run_goal(holder: CommandNode, client: Any, goal: Any, *, with_feedback: bool) -> None:
    """Send the goal and print its result."""
    print('Waiting for an action server to become available...')
    holder.spin_until(client.server_is_ready)
    print(f'Sending goal:\n     {yaml_text(goal)}')
    sent = client.send_goal_async(goal, _print_feedback if with_feedback else None)
    try:
        _follow(holder, sent)
    except BaseException:
        _cancel(holder, sent)
        raise


def _follow(holder: CommandNode, sent: Any) -> None:
    """Print whether the goal was accepted, and its result."""
    handle = holder.answer(sent, 'sending goal')
    if not handle.accepted:
        print('Goal was rejected.')
        return
    print(f'Goal accepted with ID: {bytes(handle.goal_id.uuid).hex()}\n')
    response = holder.answer(handle.get_result_async(), 'getting result')
    print(f'Result:\n    {yaml_text(response.result)}')
    print(f'Goal finished with status: {STATUS_NAMES.get(response.status, "UNKNOWN")}')


def _print_feedback(message: Any) -> None:
    """Print one feedback."""
    print(f'Feedback:\n    {yaml_text(message.feedback)}')


def _cancel(holder: CommandNode, sent: Any) -> None:
    """Cancel a goal whose result nobody waits for any more, also one not yet accepted."""
    holder.spin_until(sent.done, CANCEL_LIMIT_S)
    handle = sent.result() if sent.done() else None
    if handle is None or not handle.accepted or handle.status in STATUS_NAMES:
        return
    print('Canceling goal...')
    response = holder.answer(handle.cancel_goal_async(), 'canceling goal', CANCEL_LIMIT_S)
    if not any(goal.goal_id == handle.goal_id for goal in response.goals_canceling):
        raise CommandError('Failed to cancel goal')
    print('Goal canceled.')


VERBS = (
    Verb(
        name='list',
        summary='Output a list of action names',
        arguments=(flag('-t', '--show-types', text='Show the types too'),),
        run=_list,
    ),
    Verb(
        name='send_goal',
        summary='Send an action goal',
        arguments=(
            argument('action_name', help="Name of the action (e.g. '/rav1/fly_route')"),
            argument('action_type', help='Type of the action (package/action/Name)'),
            argument('goal', nargs='?', default='{}', help="YAML (e.g. '{order: 10}')"),
            flag('-f', '--feedback', text='Show the feedback'),
        ),
        run=_send_goal,
    ),
)
