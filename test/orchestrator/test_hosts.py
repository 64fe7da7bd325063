# SPDX-License-Identifier: Apache-2.0
"""Missions over several hosts: what runs where, and how the hosts meet."""

import socket
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import pytest

from rocsafe_mapping.options import CollectorOptions
from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.mission_commands import join_command
from rocsafe_orchestrator.parameters.node_parameters import world_parameters
from rocsafe_orchestrator.process_table.launches import launches
from rocsafe_orchestrator.process_table.table import crew_of, process_table
from rocsafe_orchestrator.processes import hosts
from rocsafe_orchestrator.processes.hosts import (
    CLOCK_LIMIT_S,
    HostNews,
    HostServer,
    LinkLostError,
    Welcome,
    join,
    write_photographs_token,
)
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.domain.mission_identity import new_identity
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_file import read_scenario

AGENTS = {'fleet.agents': True, 'survey.separation.by': 'reserved'}
BASE = {'name': 'base', 'address': '127.0.0.1', 'vehicles': ['rav1']}
VAN = {'name': 'van', 'address': '127.0.0.2', 'vehicles': ['rav2'], 'runs': ['world']}
HOSTS: dict[str, Any] = {**AGENTS, 'hosts': [BASE, VAN]}
WELCOME = Welcome(mission='run-1', token='ab12', scenario='name: small')  # noqa: S106
DEADLINE_S = 20.0
Small = Callable[..., Path]


@pytest.mark.parametrize(
    ('changes', 'line'),
    [
        ({'hosts': [BASE]}, 'hosts = 1 of them: must be none, or at least 2'),
        ({'fleet.agents': False}, 'fleet.agents = False: must be true with hosts'),
        ({'simulation.processes': 'fleet'}, 'must be per_vehicle with hosts'),
        ({'hosts': [BASE, {**VAN, 'name': 'base'}]}, "name 'base' is given 2 times"),
        ({'hosts': [BASE, {**VAN, 'address': '127.0.0.1'}]}, "address '127.0.0.1' is given 2"),
        ({'hosts': [BASE, {**VAN, 'address': 'van.local'}]}, 'must be an IPv4 address'),
        ({'hosts': [BASE, {**VAN, 'vehicles': ['rav1']}]}, "vehicle 'rav1' is given 2 times"),
        ({'hosts': [BASE, {**VAN, 'vehicles': ['rav9']}]}, "has 'rav9': must be one of the"),
        ({'hosts': [BASE, {**VAN, 'vehicles': []}]}, 'hosts[1].vehicles: must name at least one'),
        ({'hosts': [BASE, {**VAN, 'runs': ['planner']}]}, 'hosts[1].runs[0]'),
    ],
)
def test_wrong_hosts_are_refused(changes: dict[str, Any], line: str, small: Small) -> None:
    """One line names key, value and limit."""
    with pytest.raises(ScenarioError) as caught:
        read_scenario(small({**HOSTS, **changes}))
    assert line in str(caught.value)


def names(scenario: Scenario, run: RunDirectory, host: str) -> set[str]:
    """Return the processes that run on a host."""
    return {spec.name for spec in process_table(scenario, run, host) if spec.is_here}


def test_each_process_runs_on_one_host(small: Small, tmp_path: Path) -> None:
    """All see the same processes; vehicles, agents and image stores are where they belong."""
    scenario, run = read_scenario(small(HOSTS)), RunDirectory(tmp_path)
    base, van = names(scenario, run, ''), names(scenario, run, 'van')
    everything = {spec.name for spec in process_table(scenario, run)}
    assert base | van == everything
    assert base & van == set()
    assert van == {'world', 'rav2', 'agents_van', 'collector_van'}
    assert crew_of(scenario, process_table(scenario, run)).processes == everything


def test_time_waits_for_the_agents_of_all_hosts_and_each_knows_the_others(
    small: Small, tmp_path: Path
) -> None:
    """Who is cut off can be left by those who are not."""
    scenario, run = read_scenario(small(HOSTS)), RunDirectory(tmp_path)
    everybody = set(world_parameters(scenario)['participants'])
    assert {'agents', 'agents_van', 'rav1', 'rav2', 'recorder', 'radiation_field'} == everybody
    for host, agents, own in (('', 'agents', 'rav1'), ('van', 'agents_van', 'rav2')):
        (spec,) = (s for s in process_table(scenario, run, host) if s.name == agents)
        assert spec.parameters['vehicles'] == [own]
        others = set(spec.parameters['others'])
        here = names(scenario, run, host)
        assert others == everybody - here


def test_photographs_of_a_host_are_copied_to_the_head(small: Small, tmp_path: Path) -> None:
    """Each store has its own vehicles; options of the collector fit; receipts are kept apart."""
    scenario, run = read_scenario(small(HOSTS)), RunDirectory(tmp_path)
    run.parameters.mkdir()
    stores = {s.name: s for s in process_table(scenario, run, 'van') if 'collector' in s.name}
    for spec in stores.values():
        values = {k: tuple(v) if isinstance(v, list) else v for k, v in spec.parameters.items()}
        CollectorOptions(**values)
    assert stores['collector'].parameters['serve_host'] == '127.0.0.1'
    assert stores['collector_van'].parameters['copy_to'] == 'http://127.0.0.1:47612'
    assert stores['collector_van'].parameters['vehicles'] == ['rav2']
    table = [s for s in process_table(scenario, run, 'van') if s.name == 'collector_van']
    (command, _report) = launches(table, run, new_identity('run'))
    assert 'collector:__node:=collector_van' in command.command
    assert '/shots/receipts:=/van/shots/receipts' in command.command


def test_without_hosts_nothing_is_renamed(small: Small, tmp_path: Path) -> None:
    """A mission on one machine has the names that it always had."""
    table = process_table(read_scenario(small(AGENTS)), RunDirectory(tmp_path))
    assert all(spec.is_here and spec.remappings == () for spec in table)
    assert {'collector', 'agents', 'rav1', 'rav2'} <= {spec.name for spec in table}


@pytest.fixture
def server(tmp_path: Path) -> Iterator[HostServer]:
    """Give a head on loopback that waits for the host `van`."""
    made = HostServer(('127.0.0.1', 0), {'van': '127.0.0.1'}, WELCOME, tmp_path / 'plan.json')
    yield made
    made.close()


def head_of(server: HostServer) -> tuple[str, int]:
    """Return where the server listens."""
    return '127.0.0.1', server.port


def test_host_gets_identity_plan_and_end(server: HostServer, tmp_path: Path) -> None:
    """The plan as soon as there is one; what it tells reaches the head."""
    lines, welcome = join('van', head_of(server), '127.0.0.1')
    assert welcome == WELCOME
    lines.send(text='rav2 started again', restarted='rav2')
    (tmp_path / 'plan').write_text('{"id": 1}')
    (tmp_path / 'plan').rename(tmp_path / 'plan.json')
    found: list[dict[str, Any]] = []
    end_s = time.monotonic() + DEADLINE_S
    while not any('plan' in one for one in found):
        assert time.monotonic() < end_s
        found.append(lines.receive(0.1))
    assert [one['plan'] for one in found if 'plan' in one] == ['{"id": 1}']
    told: list[HostNews] = []
    while not any(one.restarted for one in told):
        assert time.monotonic() < end_s
        # Threads of the server add to it: it is taken from, never looked through.
        while server.news:
            told.append(server.news.popleft())
        time.sleep(0.01)
    assert 'van has joined, its clock differs by' in told[0].text
    server.close()
    while 'end' not in (last := lines.receive(0.1)):
        assert time.monotonic() < end_s
    assert last['end'] is True


@pytest.mark.parametrize('name', ['boat', ''])
def test_stranger_is_refused(server: HostServer, name: str) -> None:
    """By name, or from another address than the scenario says."""
    with pytest.raises(SetupError, match='is no host of this mission'):
        join(name, head_of(server), '127.0.0.1')
    with pytest.raises(SetupError, match='is no host of this mission'):
        join('van', head_of(server), '127.0.0.3')


@pytest.mark.parametrize(('offset_s', 'how'), [(2.0, 'ahead of'), (-2.0, 'behind')])
def test_clocks_that_differ_are_refused(
    server: HostServer, offset_s: float, how: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """One line with the difference and the limit; less than the limit is taken."""
    look = hosts._clock_offset_s
    monkeypatch.setattr(hosts, '_clock_offset_s', lambda lines: look(lines) + offset_s)
    with pytest.raises(SetupError) as caught:
        join('van', head_of(server), '127.0.0.1')
    assert f'2.0 s {how} that of 127.0.0.1, at most {CLOCK_LIMIT_S:g} s' in str(caught.value)


def test_clock_of_the_other_side_is_measured(server: HostServer) -> None:
    """To some milliseconds: both are the same here, and one that is a second ahead shows it."""
    lines, _welcome = join('van', head_of(server), '127.0.0.1')
    ahead_s = hosts._clock_offset_s(lines, wall=lambda: time.time() + 1.0)
    assert ahead_s == pytest.approx(1.0, abs=0.2)
    lines.close()


def test_head_that_says_nothing_is_lost(monkeypatch: pytest.MonkeyPatch) -> None:
    """A connection alone is no sign of life."""
    monkeypatch.setattr(hosts, 'LOST_S', 0.3)
    with socket.create_server(('127.0.0.1', 0)) as silent, pytest.raises(LinkLostError):
        join('van', silent.getsockname(), '127.0.0.1')


def test_token_of_photographs_is_the_owners(tmp_path: Path) -> None:
    """All hosts of a mission derive the same; it is not that of the mission."""
    run = RunDirectory(tmp_path)
    write_photographs_token(run, 'ab12')
    assert run.photographs_token.stat().st_mode & 0o077 == 0
    assert 'ab12' not in run.photographs_token.read_text()


def test_host_flies_the_scenario_of_the_head(small: Small, tmp_path: Path) -> None:
    """Its seed and speed count; a file that says something else is refused with the key."""
    own = read_scenario(small(HOSTS))
    theirs = read_scenario(small(HOSTS), seed=99, speed=4.0)
    told = Welcome(mission='run-1', token='ab12', scenario=theirs.to_yaml())  # noqa: S106
    path = tmp_path / 'small.yaml'
    flown = join_command._scenario_of_head(own, told, path)
    assert (flown.seed, flown.clock.speed) == (99, 4.0)
    other = read_scenario(small({**HOSTS, 'survey.height_agl_m': 41.0}))
    told = Welcome(mission='run-1', token='ab12', scenario=other.to_yaml())  # noqa: S106
    with pytest.raises(SetupError, match=r'small.yaml: survey is not as on base: use the same'):
        join_command._scenario_of_head(own, told, path)
