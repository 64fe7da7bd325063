# SPDX-License-Identifier: Apache-2.0
"""Parameters of the agents' node."""

from dataclasses import dataclass

from rocsafe_geo.option import option


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentOptions:
    """Parameters of the node."""

    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles whose agents run here')
    real_vehicles: tuple[str, ...] = option((), 'those of the fleet that are no simulation')
    mission: str = option('', 'mission whose vehicles are flown')
    plan_file: str = option('', 'plan.json with which the survey begins, on this machine')
    terrain_file: str = option('', 'heights that the plan follows')
    batteries_file: str = option('', 'flight times of batteries; empty: those of the plan')
    search_file: str = option('', 'how agents search after the survey; empty: they do not')
    state_directory: str = option('', 'folder in which agents count their starts')
    link: str = option('dds', 'way of packets to agents of other processes: dds or zenoh')
    link_listen: str = option('', 'address of this process with zenoh, host:port')
    link_peers: tuple[str, ...] = option((), 'addresses of the other processes with zenoh')
    lock_step: bool = option(False, 'take part in simulated time')
    participants: tuple[str, ...] = option((), 'vehicles here that simulated time waits for')
    others: tuple[str, ...] = option((), 'who takes part in simulated time on other hosts')
    lost_after_s: float = option(
        12.0, 'wall time after which time stops to wait for a vehicle, s', 1.0
    )
    alone_after_s: float = option(5.0, 'the same once the orchestrator is gone, s', 1.0)

    def __post_init__(self) -> None:
        if not self.vehicles or len(set(self.vehicles)) < len(self.vehicles):
            raise ValueError(f'vehicles = {list(self.vehicles)}: must be one or more that differ')
        if not self.plan_file:
            raise ValueError('plan_file is empty: must name the plan of the survey')
        if self.link not in ('dds', 'zenoh'):
            raise ValueError(f'link = {self.link!r}: must be dds or zenoh')
        if bool(self.link_listen) != (self.link == 'zenoh'):
            raise ValueError('link_listen: must be given with link = zenoh, and only then')
