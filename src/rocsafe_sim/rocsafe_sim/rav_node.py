# SPDX-License-Identifier: Apache-2.0
"""The node ``rav``: one simulated vehicle, named after its namespace."""

from pathlib import Path
from typing import Any

from diagnostic_msgs.msg import DiagnosticStatus

from rocsafe_geo.position import GeoPosition
from rocsafe_ros.conversions import diagnostic
from rocsafe_ros.interfaces.vehicle_scope import VehicleScopeNode
from rocsafe_ros.lockstep import Participant
from rocsafe_ros.parameters import ParameterError, declare_options
from rocsafe_ros.process.run import run
from rocsafe_scene.errors import ViewError
from rocsafe_sim.clock.cadence import floor_to
from rocsafe_sim.errors import SimError
from rocsafe_sim.options import RavOptions
from rocsafe_sim.rav.assembly import make_rav
from rocsafe_sim.rav.rav import Rav
from rocsafe_sim.rav.shared_parts import make_shared
from rocsafe_sim.vehicle_node import VehicleInterface


class RavNode(VehicleScopeNode):
    """Simulates the vehicle named by its namespace, see `VehicleInterface`.

    In lock-step it is a participant with the name of the vehicle. Otherwise it steps at its fix
    rate by its own clock.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('rav', **node_options)
        options = declare_options(self, RavOptions)
        if not self.vehicle_name:
            raise ParameterError('rav: must stand in the namespace of a vehicle, e.g. __ns:=/rav1')
        self._period_ns = options.fix_period_ns
        self._participant: Participant | None = None
        self._interface = VehicleInterface(
            self, _rav(options, self.vehicle_name), options.fix_period_ns, self._on_busy
        )
        if options.lock_step:
            self._participant = Participant(
                self,
                self.vehicle_name,
                self._interface.step,
                has_news=lambda: self._interface.has_news,
            )
        else:
            self.create_timer(1.0 / options.fix_rate_hz, self._on_timer)
            self._on_timer()

    def health(self) -> list[DiagnosticStatus]:
        """Return its own status and that of the vehicle."""
        return [diagnostic('runs'), *filter(None, [self._interface.health()])]

    def _on_busy(self) -> None:
        if self._participant is not None:
            self._participant.report(is_idle=False)

    def _on_timer(self) -> None:
        self._interface.step(floor_to(self.get_clock().now().nanoseconds, self._period_ns))


def _rav(options: RavOptions, name: str) -> Rav:
    home = GeoPosition(options.home_latitude_deg, options.home_longitude_deg, 0.0)
    spool = Path(options.spool_directory) if options.spool_directory else None
    try:
        return make_rav(options, name, home, make_shared(options), spool)
    except (SimError, ViewError, ValueError, OSError) as error:
        raise ParameterError(f'{name}: {error}') from error


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(RavNode)


if __name__ == '__main__':
    raise SystemExit(main())
