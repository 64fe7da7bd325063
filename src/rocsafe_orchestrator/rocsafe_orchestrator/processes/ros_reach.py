# SPDX-License-Identifier: Apache-2.0
"""How far ROS searches for other participants."""

import os

# Variables that limit it; one that is set is respected.
REACH_VARIABLES = (
    'ROS_AUTOMATIC_DISCOVERY_RANGE',
    'ROS_STATIC_PEERS',
    'ROS_DISCOVERY_SERVER',
    'ROS_LOCALHOST_ONLY',
)


def stay_on_this_machine() -> None:
    """Limit ROS discovery to this machine unless the user has set a range."""
    if not any(os.environ.get(name) for name in REACH_VARIABLES):
        os.environ['ROS_AUTOMATIC_DISCOVERY_RANGE'] = 'LOCALHOST'
