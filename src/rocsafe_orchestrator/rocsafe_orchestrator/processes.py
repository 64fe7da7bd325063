# SPDX-License-Identifier: Apache-2.0
"""The table of processes: what runs, when it should, and how it shows that it is ready."""

from dataclasses import dataclass, field
from typing import Any

from rocsafe_orchestrator import node_parameters
from rocsafe_orchestrator.mission import Crew
from rocsafe_orchestrator.phase import ACTIVE_PHASES, Phase
from rocsafe_orchestrator.process_values import RestartPolicy
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_orchestrator.scenario import Scenario
from rocsafe_ros import topics

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
    return (*_fleet_level(scenario, run), *_vehicles(scenario, run))


def crew_of(scenario: Scenario, table: tuple[ProcessSpec, ...]) -> Crew:
    """Return who takes part, as the mission needs to know it."""
    is_fleet = scenario.simulation.processes == 'fleet'
    names = scenario.vehicle_names
    return Crew(
        vehicle_processes={name: node_parameters.FLEET if is_fleet else name for name in names},
        processes=frozenset(spec.name for spec in table),
    )


def _fleet_level(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    radiation = tuple(
        Endpoint(spec=topics.RADIATION, vehicle=name) for name in scenario.vehicle_names
    )
    step_done = (Endpoint(spec=topics.STEP_DONE),)
    return (
        ProcessSpec(
            name='recorder',
            package='rocsafe_orchestrator',
            executable='recorder',
            node='/recorder',
            parameters=node_parameters.recorder_parameters(scenario, run),
            readiness=step_done,
        ),
        ProcessSpec(
            name='planner',
            package='rocsafe_planner',
            executable='planner',
            node='/planner',
            parameters=node_parameters.planner_parameters(scenario, run),
            readiness=(Endpoint(spec=topics.PLAN_SURVEY), Endpoint(spec=topics.PLAN)),
        ),
        ProcessSpec(
            name='world',
            package='rocsafe_sim',
            executable='world',
            node='/world',
            parameters=node_parameters.world_parameters(scenario),
            readiness=(Endpoint(spec=topics.WORLD_RUN), Endpoint(spec=topics.CLOCK)),
        ),
        ProcessSpec(
            name='radiation_field',
            package='rocsafe_radiation',
            executable='field',
            node='/radiation_field',
            parameters=node_parameters.field_parameters(scenario),
            readiness=radiation,
        ),
        ProcessSpec(
            name='collector',
            package='rocsafe_mapping',
            executable='collector',
            node='/collector',
            parameters=node_parameters.collector_parameters(scenario, run),
            readiness=(Endpoint(spec=topics.RECEIPTS),),
        ),
        ProcessSpec(
            name='mosaic',
            package='rocsafe_mapping',
            executable='mosaic',
            node='/mosaic',
            parameters=node_parameters.mosaic_parameters(run),
            readiness=(Endpoint(spec=topics.SAVE_MOSAIC),),
        ),
    )


def _vehicles(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    if scenario.simulation.processes == 'fleet':
        name = node_parameters.FLEET
        return (
            ProcessSpec(
                name=name,
                package='rocsafe_sim',
                executable='fleet',
                node=f'/{name}',
                parameters=node_parameters.fleet_parameters(scenario, run),
                readiness=tuple(e for v in scenario.vehicle_names for e in _vehicle_endpoints(v)),
            ),
        )
    return tuple(
        ProcessSpec(
            name=vehicle.name,
            package='rocsafe_sim',
            executable='rav',
            node=f'/{vehicle.name}/rav',
            parameters=node_parameters.rav_parameters(scenario, vehicle, run),
            readiness=_vehicle_endpoints(vehicle.name),
        )
        for vehicle in scenario.vehicles
    )


def _vehicle_endpoints(vehicle: str) -> tuple[Endpoint, ...]:
    specs: tuple[Spec, ...] = (topics.FLY_ROUTE, topics.STATE, topics.SHOT)
    return tuple(Endpoint(spec=spec, vehicle=vehicle) for spec in specs)
