# SPDX-License-Identifier: Apache-2.0
"""The node ``advisor``: which agent, from detectors and reports, while the vehicles fly."""

from collections.abc import Callable
from functools import partial
from typing import Any

from rclpy.node import Node

from rocsafe_dispersion.advice_conversions import advice_message, report_of
from rocsafe_dispersion.advisor_options import AdvisorOptions
from rocsafe_dispersion.identification.advice import Advice, advice
from rocsafe_dispersion.identification.evidence import Evidence
from rocsafe_dispersion.identification.evidence_log import EvidenceLog, ReportSpool
from rocsafe_dispersion.identification.procedures import read_sections
from rocsafe_dispersion.mission_gas.gas_spool import GasSpool
from rocsafe_dispersion.release_conversions import gas_flight_reading_of
from rocsafe_hazard.fit_cycle_node import FitCycle, FitSteps
from rocsafe_interfaces.msg import AgentReport, GasReading
from rocsafe_ros.interfaces import topics
from rocsafe_ros.parameters import declare_options
from rocsafe_ros.process.run import run


class AdvisorNode(Node):
    """Names the agent from the detectors of all vehicles and what people report.

    Subscribes: for each vehicle ``gas``, and ``hazard/reports``. Publishes: ``hazard/agent``
    (latched), after new evidence.

    A node that is started again has the reports in its spool directory, and the readings that the
    estimator keeps there.
    """

    def __init__(self, **node_options: Any) -> None:
        super().__init__('advisor', **node_options)
        self._options = declare_options(self, AdvisorOptions)
        self._log = EvidenceLog()
        self._spool = ReportSpool(self._options.spool_directory)
        self._spool.restore(self._log)
        for reading in GasSpool(self._options.spool_directory).gas():
            self._log.add_gas(reading)
        self._advice = topics.create_publisher(self, topics.AGENT)
        steps = FitSteps(
            prepare=self._prepare,
            refusals=(ValueError, OSError),
            publish=self._publish,
            period_s=self._options.period_s,
        )
        self._fits = FitCycle(self, self._log, steps)
        for vehicle in self._options.vehicles:
            topics.create_subscription(self, topics.GAS, partial(self._on_gas, vehicle), vehicle)
        topics.create_subscription(self, topics.AGENT_REPORTS, self._on_report)

    def _on_gas(self, vehicle: str, message: GasReading) -> None:
        self._log.add_gas(gas_flight_reading_of(vehicle, message))

    def _on_report(self, message: AgentReport) -> None:
        try:
            said = report_of(message)
            is_new = self._log.add_said(said)
        except ValueError as error:
            self.get_logger().warning(f'report refused: {error}')
            return
        if is_new:
            self._spool.keep(said)

    def _prepare(self) -> Callable[[], Advice]:
        return partial(self._advise, self._log.evidence())

    def _advise(self, evidence: Evidence) -> Advice:
        sections = read_sections(self._options.procedures())
        return advice(evidence, sections, self._options.most_procedures)

    def _publish(self, given: Advice, time_ns: int) -> None:
        self._advice.publish(advice_message(given, time_ns))


def main() -> int:
    """Run the node until it is asked to stop."""
    return run(AdvisorNode)


if __name__ == '__main__':
    raise SystemExit(main())
