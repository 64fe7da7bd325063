# SPDX-License-Identifier: Apache-2.0
"""Nodes that stand in the namespace of a vehicle."""

from rclpy.node import Node


class VehicleScopeNode(Node):
    """A node in a vehicle's namespace, say ``/rav1``: fleet names live in the one above, ``/``."""

    @property
    def vehicle_name(self) -> str:
        """Name of the vehicle: the last part of the namespace."""
        return self.get_namespace().rsplit('/', 1)[1]

    @property
    def fleet_namespace(self) -> str:
        """Namespace of the suite, without a slash at its end; empty for the root."""
        return self.get_namespace().rsplit('/', 1)[0]
