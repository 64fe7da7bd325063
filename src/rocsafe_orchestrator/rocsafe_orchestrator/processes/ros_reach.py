# SPDX-License-Identifier: Apache-2.0
"""Range in which ROS searches for other participants, and the way to them."""

import os

from rocsafe_orchestrator.errors import SetupError
from rocsafe_ros.domain.network import INTERFACES, PEERS, bind_interfaces
from rocsafe_ros.parameters import ParameterError
from rocsafe_scenario.scenario import Scenario

# Variables that limit it; one that is set is respected.
REACH_VARIABLES = (
    'ROCSAFE_INTERFACES',
    'ROS_AUTOMATIC_DISCOVERY_RANGE',
    'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER',
    'ROS_LOCALHOST_ONLY',
)


def reach(scenario: Scenario, host: str = '') -> None:
    """Limit ROS discovery to the hosts of a scenario unless the user has set a range.

    Each host asks those before it in the scenario by address, without multicast. A scenario
    without hosts stays on this machine.

    Parameters
    ----------
    host
        Name of this host; empty: the head.

    Raises
    ------
    SetupError
        If the address of this host is none of this machine.
    """
    if scenario.hosts and not any(os.environ.get(name) for name in REACH_VARIABLES):
        names = [one.name for one in scenario.hosts]
        asked = scenario.hosts[: names.index(host or scenario.head) + 1]
        os.environ[INTERFACES] = asked[-1].address
        os.environ[PEERS] = ','.join(one.address for one in asked)
    stay_on_this_machine()


def stay_on_this_machine() -> None:
    """Limit ROS discovery to this machine unless the user has set a range.

    Raises
    ------
    SetupError
        If an interface that the user has named is wrong.
    """
    if not any(os.environ.get(name) for name in REACH_VARIABLES):
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
    try:
        bind_interfaces(os.environ)
    except ParameterError as error:
        raise SetupError(str(error)) from error
