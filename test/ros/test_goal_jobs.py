# SPDX-License-Identifier: Apache-2.0
"""A server of long work waits for it without work of its own."""

from threading import Event

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')

from rclpy.action import ActionClient
from rclpy.node import Node

from rocsafe_interfaces.action import PlanGroundRoute
from rocsafe_ros.background_job import BackgroundJob
from rocsafe_ros.goal_jobs_node import GoalJobs
from rocsafe_ros.interfaces.calls import PLAN_GROUND_ROUTE

DEADLINE_S = 30.0
FEEDBACKS = 10
# Each feedback is a timer, a message and its reception: a coroutine that waits takes thousands.
SPINS_A_FEEDBACK = 20


def test_waiting_for_a_job_takes_no_processor(ros):
    """The executor is woken by timers and messages alone, while a job is under way."""
    finish = Event()
    server, client_node = Node('server', context=ros.context), Node('client', context=ros.context)

    def answer(goal, job):
        goal.succeed()
        return PlanGroundRoute.Result(error_msg=job.result())

    def work(_report):
        finish.wait(DEADLINE_S)
        return 'done'

    jobs = GoalJobs(
        server,
        PLAN_GROUND_ROUTE,
        lambda _goal: BackgroundJob(work, 'waiting', None),
        answer,
        lambda job: PlanGroundRoute.Feedback(elapsed_s=job.elapsed_s),
    )
    client = ActionClient(client_node, PlanGroundRoute, PLAN_GROUND_ROUTE.name)
    for node in (server, client_node):
        ros.executor.add_node(node)
    feedbacks, spins = [], 0
    try:
        ros.spin_until(client.server_is_ready, DEADLINE_S)
        sent = client.send_goal_async(PlanGroundRoute.Goal(), feedback_callback=feedbacks.append)
        ros.spin_until(sent.done, DEADLINE_S)
        while len(feedbacks) < FEEDBACKS and spins < FEEDBACKS * SPINS_A_FEEDBACK:
            ros.executor.spin_once(timeout_sec=1.0)
            spins += 1
        assert len(feedbacks) >= FEEDBACKS
        finish.set()
        result = sent.result().get_result_async()
        ros.spin_until(result.done, DEADLINE_S)
        assert result.result().result.error_msg == 'done'
    finally:
        finish.set()
        client.destroy()
        jobs.destroy()
        for node in (server, client_node):
            node.destroy_node()
