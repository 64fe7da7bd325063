# SPDX-License-Identifier: Apache-2.0
"""The fixes of a vehicle with its true positions, for sensors that are simulated there."""

from collections.abc import Callable

from rclpy.node import Node
from sensor_msgs.msg import NavSatFix

from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.pairing import StampPairing


class FixPairs:
    """Calls back with each fix of a vehicle and its true position, in the order of stamps.

    Parameters
    ----------
    node
        Node that subscribes.
    vehicle
        Namespace of the vehicle.
    is_at_its_fix
        Whether no true position is published: the fix is then taken for it.
    on_pair
        Called with a fix and the true position of equal stamp.
    """

    def __init__(
        self,
        node: Node,
        vehicle: str,
        *,
        is_at_its_fix: bool,
        on_pair: Callable[[NavSatFix, NavSatFix], None],
    ) -> None:
        self._log, self._vehicle = node.get_logger(), vehicle
        self._on_pair = on_pair
        self._pairing: StampPairing[NavSatFix, NavSatFix] = StampPairing()
        self._reported_lost = 0
        pair = ((topics.GROUND_TRUTH_FIX, self._on_truth), (topics.FIX, self._on_fix))
        lone = ((topics.FIX, self._on_lone_fix),)
        self._fixes = [
            topics.create_subscription(node, spec, callback, vehicle)
            for spec, callback in (lone if is_at_its_fix else pair)
        ]

    @property
    def is_ready(self) -> bool:
        """Whether the vehicle's fixes arrive when it sends them."""
        return all(fixes.get_publisher_count() for fixes in self._fixes)

    def _on_fix(self, fix: NavSatFix) -> None:
        self._answer(self._pairing.add_left(ns_of_stamp(fix.header.stamp), fix))

    def _on_truth(self, truth: NavSatFix) -> None:
        self._answer(self._pairing.add_right(ns_of_stamp(truth.header.stamp), truth))

    def _on_lone_fix(self, fix: NavSatFix) -> None:
        self._on_fix(fix)
        self._on_truth(fix)

    def _answer(self, pair: tuple[NavSatFix, NavSatFix] | None) -> None:
        if self._pairing.lost > self._reported_lost:
            self._reported_lost = self._pairing.lost
            self._log.warning(f'{self._vehicle}: {self._pairing.lost} fixes lost their partner')
        if pair is not None:
            self._on_pair(*pair)
