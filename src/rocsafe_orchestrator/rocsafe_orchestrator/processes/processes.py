# SPDX-License-Identifier: Apache-2.0
"""The table of processes: what runs, when it should, and how it shows that it is ready."""

from dataclasses import dataclass, field
from typing import Any

from rocsafe_orchestrator.mission.phase import ACTIVE_PHASES, Phase
from rocsafe_orchestrator.mission.situation import Crew
from rocsafe_orchestrator.processes import node_parameters
from rocsafe_orchestrator.processes.field_parameters import field_parameters
from rocsafe_orchestrator.processes.process_values import RestartPolicy
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros import topics
from rocsafe_scenario.scenario import Scenario

Spec = topics.TopicSpec | topics.CallSpec


@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """A topic published, or a service or action served, by a process that is ready."""

    spec: Spec
    vehicle: str = ''

    @property
    def kind(self) -> str:
        """``'topic'``, ``'service'`` or ``'action'``."""
        return self.spec.kind if isinstance(self.spec, topics.CallSpec) else 'topic'

    @property
    def name(self) -> str:
        """Name relative to the namespace of the suite."""
        return topics.name_of(self.spec, self.vehicle)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessSpec:
    """One process of a run.

    Attributes
    ----------
    name: in logs and messages, and of its log file.
    node: full name of the node, to which `parameters` belong.
    readiness: it can be used once all of these exist.
    runs_in: phases of the mission in which it should run.
    """

    name: str
    package: str
    executable: str
    node: str
    parameters: dict[str, Any]
    readiness: tuple[Endpoint, ...]
    runs_in: frozenset[Phase] = ACTIVE_PHASES
    restart: RestartPolicy = field(default_factory=RestartPolicy)

    @property
    def namespace(self) -> str:
        """Namespace of the node."""
        return self.node.rpartition('/')[0] or '/'


def process_table(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    """Return every process that flies `scenario`."""
    return (*_fleet_level(scenario, run), *_vehicles(scenario, run), *_bridge(scenario, run))


def crew_of(scenario: Scenario, table: tuple[ProcessSpec, ...]) -> Crew:
    """Return who takes part, as the mission needs to know it."""
    is_fleet = scenario.simulation.processes == 'fleet'
    simulated = (vehicle.name for vehicle in scenario.simulated)
    return Crew(
        vehicle_processes={
            **{name: node_parameters.FLEET if is_fleet else name for name in simulated},
            **{vehicle.name: node_parameters.BRIDGE for vehicle in scenario.linked},
        },
        processes=frozenset(spec.name for spec in table),
    )


def _fleet_level(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    return (*_flight_level(scenario, run), *_sensing_level(scenario, run))


def _flight_level(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    return (
        _process(
            'recorder',
            ('rocsafe_orchestrator', 'recorder'),
            node_parameters.recorder_parameters(scenario, run),
            Endpoint(spec=topics.STEP_DONE),
        ),
        _process(
            'planner',
            ('rocsafe_planner', 'planner'),
            node_parameters.planner_parameters(scenario, run),
            Endpoint(spec=topics.PLAN_SURVEY),
            Endpoint(spec=topics.PLAN),
        ),
        _process(
            'world',
            ('rocsafe_sim', 'world'),
            node_parameters.world_parameters(scenario),
            Endpoint(spec=topics.WORLD_RUN),
            Endpoint(spec=topics.CLOCK),
        ),
    )


def _sensing_level(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    radiation = tuple(
        Endpoint(spec=topics.RADIATION, vehicle=vehicle.name)
        for vehicle in scenario.with_simulated_detector
    )
    return (
        _process(
            'radiation_field',
            ('rocsafe_radiation', 'field'),
            field_parameters(scenario, run),
            *radiation,
        ),
        _process(
            'localizer',
            ('rocsafe_radiation', 'localizer'),
            node_parameters.localizer_parameters(scenario, run),
            Endpoint(spec=topics.HAZARD_SOURCES),
            Endpoint(spec=topics.SUGGEST_VIEWPOINTS),
        ),
        _process(
            'collector',
            ('rocsafe_mapping', 'collector'),
            node_parameters.collector_parameters(scenario, run),
            Endpoint(spec=topics.RECEIPTS),
        ),
        _process(
            'mosaic',
            ('rocsafe_mapping', 'mosaic'),
            node_parameters.mosaic_parameters(run),
            Endpoint(spec=topics.SAVE_MOSAIC),
        ),
    )


def _process(
    name: str,
    executable: tuple[str, str],
    parameters: dict[str, Any],
    *readiness: Endpoint,
    namespace: str = '',
    node: str = '',
) -> ProcessSpec:
    """Return the process `name` of (package, executable); its node is called so too."""
    return ProcessSpec(
        name=name,
        package=executable[0],
        executable=executable[1],
        node=f'{namespace}/{node or name}',
        parameters=parameters,
        readiness=readiness,
    )


def _bridge(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    """Return the one process of all real vehicles."""
    if not scenario.linked:
        return ()
    endpoints = (e for vehicle in scenario.linked for e in _vehicle_endpoints(vehicle.name))
    parameters = node_parameters.bridge_parameters(scenario, str(run.spool))
    return (
        _process(node_parameters.BRIDGE, ('rocsafe_mavlink', 'bridge'), parameters, *endpoints),
    )


def _vehicles(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    if scenario.simulation.processes == 'fleet' and scenario.simulated:
        endpoints = (e for vehicle in scenario.simulated for e in _vehicle_endpoints(vehicle.name))
        parameters = node_parameters.fleet_parameters(scenario, run)
        return (_process(node_parameters.FLEET, ('rocsafe_sim', 'fleet'), parameters, *endpoints),)
    return tuple(
        _process(
            vehicle.name,
            ('rocsafe_sim', 'rav'),
            node_parameters.rav_parameters(scenario, vehicle, run),
            *_vehicle_endpoints(vehicle.name),
            namespace=f'/{vehicle.name}',
            node='rav',
        )
        for vehicle in scenario.simulated
    )


def _vehicle_endpoints(vehicle: str) -> tuple[Endpoint, ...]:
    specs: tuple[Spec, ...] = (topics.FLY_ROUTE, topics.STATE, topics.SHOT)
    return tuple(Endpoint(spec=spec, vehicle=vehicle) for spec in specs)
