# SPDX-License-Identifier: Apache-2.0
"""AirSim's server turns the gimbal of a simulated vehicle, and answers when it rests."""

import asyncio
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
from test.sim.node_stand import DEADLINE_S, Operator

from rocsafe_airsim.errors import AirsimError
from rocsafe_airsim.gimbals_node import Gimbals
from rocsafe_ros.interfaces import topics

CAMERAS = (
    {
        'name': 'camera',
        'image_width_px': 64,
        'image_height_px': 48,
        'gimbal': True,
        'gimbal_rate_dps': 90.0,
        'horizontal_fov_deg': 40,
        'gimbal_highest_deg': -60,
    },
)


def test_a_gimbal_is_pointed_and_awaited(operator: Operator, rav: Any) -> None:
    """The state that is heard then is that of the new direction; a fixed camera is refused."""
    rav(lock_step=False, fix_rate_hz=20.0, cameras=CAMERAS)
    states = operator.listen(topics.GIMBAL_STATE)
    gimbals = Gimbals(operator.node, 'rav1')
    gimbals.add('camera')
    operator.ros.spin_until(lambda: len(states) > 1, DEADLINE_S)
    with ThreadPoolExecutor(1) as pool:
        done = pool.submit(asyncio.run, gimbals.point('camera', -1.3, 0.5))
        operator.ros.spin_until(done.done, DEADLINE_S)
        assert done.result() is None
    last = states[-1]
    assert last.is_settled
    assert (last.pitch_rad, last.yaw_rad) == pytest.approx((-1.3, 0.5))
    with pytest.raises(AirsimError, match='has no gimbal'):
        asyncio.run(gimbals.point('other', -1.0, 0.5))
