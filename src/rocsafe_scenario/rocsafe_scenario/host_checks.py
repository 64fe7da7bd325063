# SPDX-License-Identifier: Apache-2.0
"""Checks of the machines of a mission."""

from collections import Counter
from collections.abc import Iterator

from rocsafe_scenario.scenario import Scenario


def host_mistakes(scenario: Scenario) -> Iterator[str]:
    """Yield one line for each mistake of the hosts of a scenario."""
    hosts, processes = scenario.hosts, scenario.simulation.processes
    if not hosts:
        if scenario.fleet.link != 'dds':
            yield f'fleet.link = {scenario.fleet.link}: must be dds without hosts'
        return
    if len(hosts) == 1:
        yield 'hosts = 1 of them: must be none, or at least 2'
    if not scenario.fleet.agents:
        yield 'fleet.agents = False: must be true with hosts'
    if processes != 'per_vehicle':
        yield f'simulation.processes = {processes}: must be per_vehicle with hosts'
    for key in ('name', 'address'):
        yield from _repeated(f'hosts: {key}', [getattr(host, key) for host in hosts])
    yield from _repeated('hosts: vehicle', [name for host in hosts for name in host.vehicles])
    yield from _repeated('hosts: runs', [name for host in hosts for name in host.runs])
    yield from _wrong_vehicles(scenario)


def _wrong_vehicles(scenario: Scenario) -> Iterator[str]:
    for index, host in enumerate(scenario.hosts):
        if index and not host.vehicles:
            yield f'hosts[{index}].vehicles: must name at least one, {host.name} is not the first'
        for name in sorted(set(host.vehicles) - set(scenario.vehicle_names)):
            yield f'hosts[{index}].vehicles has {name!r}: must be one of the vehicles'
    for index, vehicle in enumerate(scenario.vehicles):
        if not vehicle.has_home and scenario.host_of(vehicle.name) != scenario.head:
            yield f'vehicles[{index}].home: must be given, its link is on another host'


def _repeated(what: str, values: list[str]) -> Iterator[str]:
    for value, count in Counter(values).items():
        if count > 1:
            yield f'{what} {value!r} is given {count} times, must be unique'
