# SPDX-License-Identifier: Apache-2.0
"""The topic cmd_vel of a simulated vehicle: followed with the lease, until another order."""

from typing import Any

import pytest

pytest.importorskip('rclpy', reason='no ROS 2 here: source it or run make setup')
from geometry_msgs.msg import TwistStamped
from std_srvs.srv import Trigger
from test.sim.node_stand import DEADLINE_S, Operator, point

from rocsafe_interfaces.msg import VehicleState
from rocsafe_interfaces.srv import Lease, Move, SetLight, SetWind
from rocsafe_ros.interfaces import topics


class Pilot:
    """Sends velocities while the nodes spin."""

    def __init__(self, operator: Operator) -> None:
        self.operator = operator
        self.odom = operator.listen(topics.ODOM)
        self.states = operator.listen(topics.STATE)
        self._velocities = topics.create_publisher(operator.node, topics.CMD_VEL, 'rav1')
        self.frame = 'map'

    def fly_until(self, is_done: Any) -> None:
        """Send 2 m/s to the east, or ahead, until something is so."""

        def sent() -> bool:
            message = TwistStamped()
            message.header.frame_id, message.twist.linear.x = self.frame, 2.0
            self._velocities.publish(message)
            return bool(is_done())

        self.operator.ros.spin_until(sent, DEADLINE_S)

    @property
    def speed(self) -> float:
        """Speed to the east, in the frame of the mission."""
        return float(self.odom[-1].twist.twist.linear.x) if self.odom else 0.0

    @property
    def state(self) -> int:
        """Number of its state."""
        return int(self.states[-1].state) if self.states else 0


def test_velocities_are_followed_under_the_lease(operator: Operator, rav: Any) -> None:
    """Nothing moves before move says so, nor after hold, nor when the lease is another's."""
    rav(lock_step=False, fix_rate_hz=20.0, climb_rate_mps=5.0)
    pilot = Pilot(operator)
    place = point((0.0, 0.0, 0.0))
    on_ground = operator.order(Move, 'move', kind=Move.Request.FOLLOW, duration_s=0.5)
    assert on_ground.message == 'rav1: cannot follow velocities: disarmed'
    along = {'kind': Move.Request.ALONG, 'places': [place], 'heights_m': [3.0]}
    assert operator.order(Move, 'move', **along).success
    operator.ros.spin_until(lambda: pilot.state == VehicleState.HOLDING, DEADLINE_S)
    before = len(pilot.odom)
    pilot.fly_until(lambda: len(pilot.odom) > before + 10)
    assert pilot.speed == pytest.approx(0.0, abs=1e-6)
    follow = {'kind': Move.Request.FOLLOW, 'duration_s': 0.5}
    assert operator.order(Move, 'move', **follow).success
    pilot.fly_until(lambda: pilot.speed > 1.0)
    # The stream ends: it stands at the deadline.
    operator.ros.spin_until(lambda: pilot.state == VehicleState.HOLDING, DEADLINE_S)
    pilot.fly_until(lambda: pilot.speed > 1.0)
    assert operator.call('rav1/hold', Trigger.Request()).success
    pilot.fly_until(lambda: abs(pilot.speed) < 1e-3)
    assert operator.order(Move, 'move', **follow).success
    pilot.fly_until(lambda: pilot.speed > 0.5)
    taken = Lease.Request(holder='other', duration_s=60.0, take_over=True)
    assert operator.ask(Lease, 'rav1/lease', taken).success
    pilot.fly_until(lambda: abs(pilot.speed) < 1e-3)


def test_no_order_is_followed_before_time_begins(operator: Operator, rav: Any) -> None:
    """It would count from time 0, and decades would pass in it at the first step."""
    rav()
    away = {'kind': Move.Request.ALONG, 'places': [point((0.0, 0.0, 0.0))], 'heights_m': [3.0]}
    assert operator.order(Move, 'move', **away).message == 'rav1: its time has not begun'


def test_wind_and_light_are_set_or_refused_by_reason(operator: Operator, rav: Any) -> None:
    """Too much wind, and a ground that is a photograph."""
    rav(lock_step=False)
    wind = SetWind.Request(east_mps=3.0, north_mps=-2.0)
    assert operator.ask(SetWind, 'rav1/set_wind', wind).success
    refused = operator.ask(SetWind, 'rav1/set_wind', SetWind.Request(east_mps=80.0))
    assert 'rav1: wind_mps is 80 m/s: must be up to' in refused.message
    light = SetLight.Request(fog=0.5, sun_as_scenario=True)
    refused = operator.ask(SetLight, 'rav1/set_light', light)
    assert 'the flat ground is a photograph' in refused.message
