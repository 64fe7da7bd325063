# SPDX-License-Identifier: Apache-2.0
"""A short-lived node that commands all vehicles through the node ``fleet_verbs``."""

import os
import time
from collections.abc import Sequence
from typing import Any

import rclpy
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from rocsafe_interfaces.srv import FleetCommand
from rocsafe_orchestrator.errors import (
    EXIT_COMPLETE,
    EXIT_FAILED,
    OrchestratorError,
)
from rocsafe_orchestrator.processes.ros_reach import stay_on_this_machine
from rocsafe_ros.interfaces import calls
from rocsafe_ros.interfaces.interface_spec import CallSpec

SPECS = {
    'hold': calls.FLEET_HOLD,
    'resume': calls.FLEET_RESUME,
    'return': calls.FLEET_RETURN_HOME,
    'land': calls.FLEET_LAND,
}
# The node that serves the fleet must be found, and must answer, within these times.
FOUND_S = 5.0
ANSWERED_S = 5.0


def command_fleet(verb: str, vehicles: Sequence[str]) -> int:
    """Command the vehicles, all if none is named, and print their answers; return the exit code.

    Raises
    ------
    OrchestratorError
        If there is no fleet in this ROS domain, or no answer.
    """
    stay_on_this_machine()
    rclpy.init(args=[])
    node = Node('fleet_command', start_parameter_services=False, enable_rosout=False)
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    try:
        response = _response(node, executor, SPECS[verb], vehicles)
    finally:
        executor.shutdown()
        node.destroy_node()
        rclpy.try_shutdown()
    for answer in response.answers:
        print(answer.message or f'{answer.vehicle}: {verb}')
    return EXIT_COMPLETE if response.success else EXIT_FAILED


def _response(
    node: Node, executor: SingleThreadedExecutor, spec: CallSpec, vehicles: Sequence[str]
) -> Any:
    client = node.create_client(spec.call_type, spec.name)
    end_s = time.monotonic() + FOUND_S
    while not client.service_is_ready():
        if time.monotonic() > end_s:
            domain = os.environ.get('ROS_DOMAIN_ID') or '0'
            raise OrchestratorError(f'no mission is running in ROS domain {domain}')
        executor.spin_once(timeout_sec=0.02)
    answer = client.call_async(FleetCommand.Request(vehicles=list(vehicles)))
    executor.spin_until_future_complete(answer, timeout_sec=ANSWERED_S)
    if not answer.done():
        raise OrchestratorError(f'{spec.name}: no answer within {ANSWERED_S:g} s')
    return answer.result()
