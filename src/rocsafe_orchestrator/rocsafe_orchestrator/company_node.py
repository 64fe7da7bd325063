# SPDX-License-Identifier: Apache-2.0
"""Search the ROS domain before a mission starts its nodes, in a process of its own.

ROS cannot be started in the process that starts the mission: its threads would prevent forking.
"""

import multiprocessing
import signal
from collections.abc import Iterable, Iterator
from contextlib import contextmanager, suppress
from multiprocessing.connection import Connection
from pathlib import Path
from typing import Any

import rclpy
from rclpy.node import Node, NodeNameNonExistentError
from rclpy.signals import SignalHandlerOptions

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.processes.company import Speaker, objections
from rocsafe_ros.domain.discovery import await_discovery
from rocsafe_ros.domain.mission_identity import MissionIdentity, identity_of
from rocsafe_ros.process.run import end_with

# Participants of other machines announce themselves several times within this time.
REMOTE_S = 1.0
# The answer of a process that hangs is not awaited for longer.
ANSWER_S = 20.0
# Every node publishes there unless its author has switched it off.
EVERYBODY = '/parameter_events'
# Fast DDS: vendor, machine and process begin the identifier of an endpoint (GuidPrefix_t).
FAST_DDS, VENDOR, MACHINE, PROCESS = b'\x01\x0f', slice(0, 2), slice(2, 4), slice(4, 6)


class Claim:
    """Claims a domain for a mission until its own nodes run, and reports who uses it already.

    Missions that begin at the same time see each other's claims. ROS reads the user's parameter
    file `config` here first, so that a wrong one starts nothing.
    """

    def __init__(
        self, mission: MissionIdentity, names: Iterable[str], config: Path | None = None
    ) -> None:
        self.mission = mission
        context = multiprocessing.get_context('fork')
        self._answer, told = context.Pipe(duplex=False)
        files = () if config is None else ('--params-file', str(config))
        arguments = ((*mission.ros_arguments, *files), mission.token, frozenset(names), told)
        self._process = context.Process(target=_claim, args=arguments, daemon=True)
        self._process.start()
        told.close()

    def require_alone(self) -> None:
        """Wait for the answer.

        Raises
        ------
        SetupError
            If somebody else has a name that the mission needs, or another mission is at work:
            one line each.
        """
        try:
            if not self._answer.poll(ANSWER_S):
                raise SetupError(f'the ROS domain: not looked at within {ANSWER_S:g} s')
            found = self._answer.recv()
        except EOFError as error:
            raise SetupError('the ROS domain: the process that looks at it has ended') from error
        if isinstance(found, str):
            raise SetupError(f'cannot start ROS: {found}')
        if lines := objections(self.mission, found):
            raise SetupError('\n'.join(lines))

    def close(self) -> None:
        """Give the claim up; the mission's own nodes hold the domain now."""
        self._process.kill()
        self._process.join()


@contextmanager
def claimed(
    mission: MissionIdentity, names: Iterable[str], config: Path | None = None
) -> Iterator[Claim]:
    """Hold a `Claim`, at most to the end of the block."""
    claim = Claim(mission, names, config)
    try:
        yield claim
    finally:
        claim.close()


def _claim(
    ros_arguments: tuple[str, ...], token: str, names: frozenset[str], told: Connection
) -> None:
    """Search the domain, print what was found, and stay visible until killed."""
    for number in (signal.SIGINT, signal.SIGHUP):
        signal.signal(number, signal.SIG_IGN)
    parent = multiprocessing.parent_process()
    if parent is not None and parent.pid is not None:
        end_with(parent.pid)
    try:
        # Its handlers would take the signal that ends this process with its parent.
        no_handlers = SignalHandlerOptions.NO
        rclpy.init(args=['--ros-args', *ros_arguments], signal_handler_options=no_handlers)
        node = LookoutNode(f'orchestrator_claim_{token}')
        await_discovery(node, REMOTE_S)
        told.send(node.speakers(names))
    except Exception as error:  # noqa: BLE001 - rclpy's own error classes are not public
        told.send((str(error).strip().splitlines() or [type(error).__name__])[0])
    signal.pause()


class LookoutNode(Node):
    """Sees the nodes of the domain, and which names each has. Publishes and serves nothing."""

    def __init__(self, name: str, **node_options: Any) -> None:
        super().__init__(
            name,
            enable_rosout=False,
            start_parameter_services=False,
            **node_options,
        )

    def speakers(self, names: frozenset[str]) -> list[Speaker]:
        """Return every other node, with what it publishes or serves of `names`."""
        places = self._places()
        spoken = self._published(names)
        for node, space, _enclave in self._others():
            spoken.setdefault((node, space), set()).update(self._served(node, space) & names)
        enclaves = {(node, space): enclave for node, space, enclave in self._others()}
        return [
            Speaker(
                node=f'{space.rstrip("/")}/{node}',
                place=places.get((node, space), ''),
                mission=identity_of(enclaves.get((node, space), '')),
                names=tuple(sorted(found)),
            )
            for (node, space), found in spoken.items()
        ]

    def _others(self) -> list[tuple[str, str, str]]:
        found = self.get_node_names_and_namespaces_with_enclaves()
        return [one for one in found if one[0] != self.get_name()]

    def _published(self, names: frozenset[str]) -> dict[tuple[str, str], set[str]]:
        """Return the topics of `names` that each node publishes."""
        published: dict[tuple[str, str], set[str]] = {}
        known = {topic.lstrip('/') for topic, _types in self.get_topic_names_and_types()}
        for name in names & known:
            for end in self.get_publishers_info_by_topic(f'/{name}'):
                published.setdefault((end.node_name, end.node_namespace), set()).add(name)
        return published

    def _served(self, node: str, space: str) -> set[str]:
        """Return the services and actions of a node."""
        with suppress(NodeNameNonExistentError):
            found = self.get_service_names_and_types_by_node(node, space)
            return {name.lstrip('/').partition('/_action/')[0] for name, _types in found}
        return set()

    def _places(self) -> dict[tuple[str, str], str]:
        """Return process and machine of each node."""
        ends = self.get_publishers_info_by_topic(EVERYBODY)
        gids = {(end.node_name, end.node_namespace): bytes(end.endpoint_gid) for end in ends}
        own = gids.get((self.get_name(), self.get_namespace()), b'')
        return {node: place_of(gid, own) for node, gid in gids.items()}


def place_of(gid: bytes, own: bytes) -> str:
    """Return process and machine of an endpoint as text, empty if unknown."""
    if gid[VENDOR] != FAST_DDS or own[VENDOR] != FAST_DDS:
        return ''
    if gid[MACHINE] != own[MACHINE]:
        return 'on another machine'
    # The identifier has the lower half of the process id only.
    low = int.from_bytes(gid[PROCESS], 'little')
    entries = (int(path.name) for path in Path('/proc').glob('[0-9]*'))
    found = [pid for pid in entries if pid & 0xFFFF == low]
    return f'process {found[0]} on this machine' if len(found) == 1 else 'on this machine'
