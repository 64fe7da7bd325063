# SPDX-License-Identifier: Apache-2.0
"""Range in which ROS searches for other participants, and the way to them."""

import os

from rocsafe_orchestrator.errors import SetupError
from rocsafe_ros.domain.network import bind_interfaces
from rocsafe_ros.domain.shared_memory import remove_torn_ports
from rocsafe_ros.parameters import ParameterError

# Variables that limit it; one that is set is respected.
REACH_VARIABLES = (
    'ROCSAFE_INTERFACES',
    'ROS_AUTOMATIC_DISCOVERY_RANGE',
    'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER',
    'ROS_LOCALHOST_ONLY',
)


def stay_on_this_machine() -> None:
    """Limit ROS discovery to this machine unless the user has set a range.

    What a killed process left half made in shared memory is removed.

    Raises
    ------
    SetupError
        If an interface that the user has named is wrong.
    """
    remove_torn_ports()
    if not any(os.environ.get(name) for name in REACH_VARIABLES):
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    try:
        bind_interfaces(os.environ)
    except ParameterError as error:
        raise SetupError(str(error)) from error
