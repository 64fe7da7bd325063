# SPDX-License-Identifier: Apache-2.0
"""Periods and limits of the bridge's topics."""

from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class NodeTiming:
    """How often the bridge reads, decides and publishes.

    Attributes
    ----------
    poll_s
        Period of reading the links, seconds: most of the time from a datagram to its topic.
    tick_s
        Period of what is due by time, seconds; messages of vehicles do not wait for it.
    supervisor_lease_s
        A mission without a ``mission/state`` for so long is over, seconds; a living one publishes
        it twice a second.
    slow_s
        Period of state, battery_state, path and predicted_fix, seconds.
    feedback_s
        Period of the feedback of fly_route, seconds.
    goal_wait_s
        A goal waits at most so long until a vehicle is read or its motors stand still, seconds.
    image_look_s
        Period of looking for new images, seconds.
    unseen_path_s
        Period of a path without a subscriber other than the recorder, seconds.
    path_length
        Positions of a path that are kept: the last two hours.
    texts_per_s
        Texts of a vehicle that are logged each second; all of them are published as events.
    """

    poll_s: float = 0.005
    tick_s: float = 0.02
    supervisor_lease_s: float = 3.0
    slow_s: float = 1.0
    feedback_s: float = 1.0
    goal_wait_s: float = 45.0
    image_look_s: float = 0.25
    unseen_path_s: float = 10.0
    path_length: int = 7200
    texts_per_s: int = 5


TIMING = NodeTiming()
