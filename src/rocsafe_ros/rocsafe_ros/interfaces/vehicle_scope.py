# SPDX-License-Identifier: Apache-2.0
"""Nodes in the namespace of a vehicle."""

from rclpy.node import Node


class VehicleScopeNode(Node):
    """A node in a vehicle's namespace, such as ``/rav1``; fleet names are in that above."""

    @property
    def vehicle_name(self) -> str:
        """Name of the vehicle: the last part of the namespace."""
        return self.get_namespace().rsplit('/', 1)[1]

    @property
    def fleet_namespace(self) -> str:
        """Namespace of the fleet, without a slash at its end; empty for the root."""
        return self.get_namespace().rsplit('/', 1)[0]
