# SPDX-License-Identifier: Apache-2.0
"""The machines of a mission, and what runs on each."""

import ipaddress
from collections import Counter
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import AfterValidator, Field

from rocsafe_scenario.scenario_blocks import Block

if TYPE_CHECKING:
    from rocsafe_scenario.scenario import Scenario

MOST_HOSTS = 16


def _ipv4(value: str) -> str:
    try:
        return str(ipaddress.IPv4Address(value))
    except ValueError:
        raise ValueError('must be an IPv4 address') from None


class HostBlock(Block):
    """A machine of the mission. `rocsafe run` is on the first, `rocsafe join` on the others.

    Vehicles that no host has, and all other processes, run on the first.
    """

    name: Annotated[str, Field(pattern=r'^[a-z][a-z0-9_]*$', max_length=32)]
    address: Annotated[str, AfterValidator(_ipv4)]
    vehicles: tuple[str, ...] = ()
    runs: tuple[Literal['world', 'radiation_field'], ...] = ()


def host_mistakes(scenario: 'Scenario') -> Iterator[str]:
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


def _wrong_vehicles(scenario: 'Scenario') -> Iterator[str]:
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
