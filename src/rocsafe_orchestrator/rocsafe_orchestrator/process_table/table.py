# SPDX-License-Identifier: Apache-2.0
"""The table of processes: executable, parameters, and the endpoints that show readiness."""

from collections.abc import Iterator
from dataclasses import dataclass, replace
from typing import Any

from rocsafe_orchestrator.mission_state.situation import Crew
from rocsafe_orchestrator.parameters import node_parameters as parameters
from rocsafe_orchestrator.parameters.air_parameters import (
    ADVISOR,
    ESTIMATOR,
    advisor_parameters,
    air_parameters,
    estimator_parameters,
)
from rocsafe_orchestrator.parameters.field_parameters import field_parameters
from rocsafe_orchestrator.parameters.ground_parameters import (
    ROUTER,
    rgv_parameters,
    router_parameters,
)
from rocsafe_orchestrator.parameters.node_parameters import AGENTS, AIR, BRIDGE, FLEET
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import CallSpec, TopicSpec, name_of
from rocsafe_scenario.blocks.ground_vehicle import GroundVehicleBlock
from rocsafe_scenario.blocks.vehicles import DetectorBlock, VehicleBlock
from rocsafe_scenario.scenario import Scenario

AIRSIM, AIRSIM_PACKAGE = 'airsim', 'rocsafe_airsim'
Spec = TopicSpec | CallSpec
VEHICLE_SPECS: tuple[Spec, ...] = (calls.FLY_ROUTE, topics.STATE, topics.SHOT)


@dataclass(frozen=True, slots=True, kw_only=True)
class Endpoint:
    """A topic published, or a service or action served, by a process that is ready."""

    spec: Spec
    vehicle: str = ''

    @property
    def kind(self) -> str:
        """``'topic'``, ``'service'`` or ``'action'``."""
        return self.spec.kind if isinstance(self.spec, CallSpec) else 'topic'

    @property
    def name(self) -> str:
        """Name relative to the namespace of the suite."""
        return name_of(self.spec, self.vehicle)


@dataclass(frozen=True, slots=True, kw_only=True)
class ProcessSpec:
    """One process of a run.

    Attributes
    ----------
    name
        Name in logs and messages, and of its log file.
    node
        Full name of the node, to which `parameters` belong.
    readiness
        It can be used once all of these exist.
    remappings
        Names of ROS that it changes.
    is_here
        Whether it runs on this host; the others are those of other hosts of the mission.
    """

    name: str
    package: str
    executable: str
    node: str
    parameters: dict[str, Any]
    readiness: tuple[Endpoint, ...]
    remappings: tuple[str, ...] = ()
    is_here: bool = True

    @property
    def namespace(self) -> str:
        """Namespace of the node."""
        return self.node.rpartition('/')[0] or '/'


def process_table(
    scenario: Scenario, run: RunDirectory, host: str = ''
) -> tuple[ProcessSpec, ...]:
    """Return every process that flies `scenario`, as seen on a host; without a name: the head."""
    own = host or scenario.head
    shared = _placed(_shared_processes(scenario, run), scenario, own)
    return (*shared, *_host_processes(scenario, run, own))


def _placed(specs: tuple[ProcessSpec, ...], scenario: Scenario, own: str) -> Iterator[ProcessSpec]:
    """Yield the processes of the whole mission, each of them on one host."""
    places: dict[str, str] = {name: host.name for host in scenario.hosts for name in host.runs}
    for spec in specs:
        yield replace(spec, is_here=places.get(spec.name, scenario.head) == own)


def _host_processes(scenario: Scenario, run: RunDirectory, own: str) -> Iterator[ProcessSpec]:
    """Yield vehicles, agents and image store of each host.

    A vehicle hands its photographs to the store of its host. Receipts have names of their own on
    the hosts that join: for the head a photograph counts when its copy has come.
    """
    for host in parameters.host_names(scenario):
        vehicles = tuple(v for v in scenario.vehicles if scenario.host_of(v.name) == host)
        names = (f'/{topics.RECEIPTS.name}:=/{host}/{topics.RECEIPTS.name}',)
        is_head = host == scenario.head
        specs = (
            *_collector_processes(scenario, run, host),
            *_agent_processes(scenario, run, host),
            *_vehicle_processes(scenario, run, vehicles),
            *_bridge_processes(scenario, run, vehicles, host),
        )
        for spec in specs:
            renamed = () if is_head else (*names, *spec.remappings)
            yield replace(spec, is_here=host == own, remappings=renamed)


def _shared_processes(scenario: Scenario, run: RunDirectory) -> tuple[ProcessSpec, ...]:
    """Return the processes that a mission has once."""
    detectors = _of_each(scenario.with_simulated_detector, topics.RADIATION)
    return (
        _process('recorder', 'rocsafe_orchestrator/recorder',
                 parameters.recorder_parameters(scenario, run), *_shared(topics.STEP_DONE)),
        _process('planner', 'rocsafe_planner/planner',
                 parameters.planner_parameters(scenario, run),
                 *_shared(calls.PLAN_SURVEY, topics.PLAN)),
        _process('world', 'rocsafe_sim/world',
                 parameters.world_parameters(scenario),
                 *_shared(calls.WORLD_RUN, topics.CLOCK)),
        _process('radiation_field', 'rocsafe_radiation/field',
                 field_parameters(scenario, run), *detectors),
        _process('localizer', 'rocsafe_radiation/localizer',
                 parameters.localizer_parameters(scenario, run),
                 *_shared(topics.HAZARD_SOURCES, calls.SUGGEST_VIEWPOINTS)),
        _process('mosaic', 'rocsafe_mapping/mosaic',
                 parameters.mosaic_parameters(run), *_shared(calls.SAVE_MOSAIC)),
        _process('fleet_verbs', 'rocsafe_orchestrator/fleet_verbs',
                 parameters.fleet_verbs_parameters(scenario, run), *_shared(calls.FLEET_HOLD)),
        *_air_processes(scenario, run),
        *_ground_processes(scenario, run),
    )  # fmt: skip


def airsim_process(scenario: Scenario, host: str, port: int) -> ProcessSpec:
    """Return the process that serves scripts of AirSim's API."""
    values = parameters.airsim_parameters(scenario, host, port)
    executable = f'{AIRSIM_PACKAGE}/airsim'
    return _process(AIRSIM, executable, values, *_shared(topics.DRAWINGS))


def crew_of(scenario: Scenario, table: tuple[ProcessSpec, ...]) -> Crew:
    """Return who takes part, as the mission needs to know it."""
    is_fleet = scenario.simulation.processes == 'fleet'
    return Crew(
        vehicle_processes={
            **{v.name: FLEET if is_fleet else v.name for v in scenario.simulated},
            **{
                v.name: parameters.name_on(scenario, BRIDGE, scenario.host_of(v.name))
                for v in scenario.linked
            },
        },
        processes=frozenset(spec.name for spec in table),
        in_lockstep=frozenset(vehicle.name for vehicle in scenario.simulated),
        driver=scenario.driver_name,
    )


def _collector_processes(
    scenario: Scenario, run: RunDirectory, host: str
) -> Iterator[ProcessSpec]:
    values = parameters.collector_parameters(scenario, run, host)
    yield _of_host('collector', 'rocsafe_mapping/collector', values, host, scenario)


def _agent_processes(scenario: Scenario, run: RunDirectory, host: str) -> Iterator[ProcessSpec]:
    """Yield one process for the agents of the vehicles of a host, if they have any."""
    values = parameters.agent_parameters(scenario, run, host)
    if scenario.fleet.agents and values['vehicles']:
        yield _of_host(AGENTS, 'rocsafe_fleet/agent', values, host, scenario)


def _of_host(
    name: str, executable: str, values: dict[str, Any], host: str, scenario: Scenario
) -> ProcessSpec:
    """Return a process that several hosts have; its node is called after its host."""
    ready = {AGENTS: topics.AGENTS}.get(name, topics.RECEIPTS)
    if host == scenario.head:
        return _process(name, executable, values, *_shared(ready))
    own = parameters.name_on(scenario, name, host)
    return replace(_process(own, executable, values), remappings=(f'{name}:__node:={own}',))


def _air_processes(scenario: Scenario, run: RunDirectory) -> Iterator[ProcessSpec]:
    if scenario.air.is_used:
        sensors = (
            Endpoint(spec=topics.ANEMOMETER, vehicle=name) for name in scenario.metered_names
        )
        yield _process(AIR, 'rocsafe_dispersion/air', air_parameters(scenario, run), *sensors)
        yield _process(
            ESTIMATOR,
            'rocsafe_dispersion/estimator',
            estimator_parameters(scenario, run),
            *_shared(topics.RELEASES, calls.SUGGEST_GAS_VIEWPOINTS),
        )
        advisor = advisor_parameters(scenario, run)
        yield _process(ADVISOR, 'rocsafe_dispersion/advisor', advisor, *_shared(topics.AGENT))


def _vehicle_processes(
    scenario: Scenario, run: RunDirectory, vehicles: tuple[VehicleBlock, ...]
) -> Iterator[ProcessSpec]:
    """Yield one process or several for the simulated vehicles of a host."""
    simulated = tuple(vehicle for vehicle in vehicles if not vehicle.link)
    if simulated and scenario.simulation.processes == 'fleet':
        values = parameters.fleet_parameters(scenario, run)
        yield _process(FLEET, 'rocsafe_sim/fleet', values, *_of_each(simulated, *VEHICLE_SPECS))
    else:
        for vehicle in simulated:
            values = parameters.rav_parameters(scenario, vehicle, run)
            ready = _of_each((vehicle,), *VEHICLE_SPECS)
            yield _process(
                vehicle.name, 'rocsafe_sim/rav', values, *ready, node=f'/{vehicle.name}/rav'
            )


def _bridge_processes(
    scenario: Scenario, run: RunDirectory, vehicles: tuple[VehicleBlock, ...], host: str
) -> Iterator[ProcessSpec]:
    """Yield one process for all real vehicles of a host, and those of their detectors."""
    linked = tuple(vehicle for vehicle in vehicles if vehicle.link)
    block = scenario.ground_vehicle
    driver = block if block and block.link and host == scenario.head else None
    ready = [*_of_each(linked, *VEHICLE_SPECS), *(_of_driver(driver) if driver else ())]
    if ready:
        values = parameters.bridge_parameters(scenario, str(run.spool), linked, driver)
        bridge = parameters.name_on(scenario, BRIDGE, host)
        spec = _process(bridge, 'rocsafe_mavlink/bridge', values, *ready)
        yield (
            spec if bridge == BRIDGE else replace(spec, remappings=(f'{BRIDGE}:__node:={bridge}',))
        )
    detected: list[VehicleBlock | GroundVehicleBlock] = [*linked]
    for vehicle in [*detected, *([driver] if driver else [])]:
        if isinstance(vehicle.drone.detector, DetectorBlock):
            yield _process(
                f'detector_{vehicle.name}', 'rocsafe_radiation/detector',
                vehicle.drone.detector.model_dump(),
                Endpoint(spec=topics.RADIATION, vehicle=vehicle.name),
                node=f'/{vehicle.name}/detector',
            )  # fmt: skip


def _ground_processes(scenario: Scenario, run: RunDirectory) -> Iterator[ProcessSpec]:
    block = scenario.ground_vehicle
    if block is None:
        return
    yield _process(
        ROUTER, 'rocsafe_ground/router', router_parameters(scenario, block, run),
        *_shared(calls.PLAN_GROUND_ROUTE, topics.GROUND_ROUTE),
    )  # fmt: skip
    if not block.link:
        yield _process(
            block.name, 'rocsafe_sim/rgv', rgv_parameters(scenario, block, run),
            *_of_driver(block), node=f'/{block.name}/rgv',
        )  # fmt: skip


def _of_driver(block: GroundVehicleBlock) -> Iterator[Endpoint]:
    specs = (calls.DRIVE_ROUTE, topics.STATE, topics.SHOT)
    return (Endpoint(spec=spec, vehicle=block.name) for spec in specs)


def _shared(*specs: Spec) -> Iterator[Endpoint]:
    return (Endpoint(spec=spec) for spec in specs)


def _of_each(vehicles: tuple[VehicleBlock, ...], *specs: Spec) -> Iterator[Endpoint]:
    return (Endpoint(spec=spec, vehicle=vehicle.name) for vehicle in vehicles for spec in specs)


def _process(
    name: str, executable: str, values: dict[str, Any], *readiness: Endpoint, node: str = ''
) -> ProcessSpec:
    """Return the process `name` of ``package/executable``; its node is called so too."""
    package, _, program = executable.partition('/')
    return ProcessSpec(
        name=name,
        package=package,
        executable=program,
        node=node or f'/{name}',
        parameters=values,
        readiness=readiness,
    )
