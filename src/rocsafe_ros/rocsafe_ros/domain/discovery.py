# SPDX-License-Identifier: Apache-2.0
"""Waits until a new node has discovered the others; no daemon keeps the graph.

A fixed wait (0.5 s in the real command) is often too long and sometimes too short: a participant
answers the first announcement once, that answer is lost if it arrives too early, and the next one
comes 3 s later. On Linux the participants of this machine can be counted by the UDP ports that
they hold, so the wait ends when as many have answered. Participants of other machines cannot be
counted; they get a short fixed time.
"""

import os
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

OTHERS_LIMIT_S = 3.3
"""Longest wait for a name that may not exist: participants announce themselves every 3 s."""

COUNTED_LIMIT_S = 6.5
"""Longest wait for participants of this machine, whose number is known.

On a busy machine the first announcement may be late or lost.
"""

REMOTE_WAIT_S = 0.3
"""Wait for participants of other machines, which answer the first announcement."""

QUIET_S = 0.1
"""Topics and services of a participant follow within this time of each other."""

POLL_S = 0.02
NAME_UNKNOWN = '_NODE_NAME_UNKNOWN_'
UDP_TABLE = Path('/proc/net/udp')

# Well-known ports, RTPS 2.5 section 9.6.2.3: 7400 + 250 domain + 10 + 2 participant.
PORT_BASE = 7400
PORTS_PER_DOMAIN = 250
DISCOVERY_OFFSET = 10


def await_discovery(node: Any, remote_s: float = REMOTE_WAIT_S) -> None:
    """Wait until the node knows the others, at most `COUNTED_LIMIT_S`.

    Where other machines can be reached it waits for them, `remote_s` seconds.
    """
    start = time.monotonic()
    minimum_s = remote_s if may_reach_other_machines() else 0.0
    domain_id = int(os.environ.get('ROS_DOMAIN_ID') or 0)
    seen, changed = None, start
    while time.monotonic() - start < COUNTED_LIMIT_S:
        now, graph = time.monotonic(), _graph(node)
        if graph != seen:
            seen, changed = graph, now
        is_quiet = now - changed >= QUIET_S and now - start >= minimum_s
        if is_quiet and _has_met_all(node, domain_id):
            return
        time.sleep(POLL_S)


def wait_for(is_true: Callable[[], bool], limit_s: float) -> bool:
    """Wait until `is_true()`, at most `limit_s` seconds; return whether it became true."""
    end = time.monotonic() + limit_s
    while not is_true():
        if time.monotonic() > end:
            return False
        time.sleep(POLL_S)
    return True


def may_reach_other_machines() -> bool:
    """Return whether discovery goes beyond this machine."""
    discovery_range = os.environ.get('ROS_AUTOMATIC_DISCOVERY_RANGE', 'SUBNET')
    return discovery_range not in ('LOCALHOST', 'OFF') or bool(os.environ.get('ROS_STATIC_PEERS'))


def local_participants(udp_table: str, domain_id: int) -> int:
    """Count the participants of a domain on this machine.

    Parameters
    ----------
    udp_table
        Text of `/proc/net/udp`: a head, then one line per socket, its local port in hexadecimal.
    domain_id
        Domain whose participants are counted.
    """
    first = PORT_BASE + PORTS_PER_DOMAIN * domain_id + DISCOVERY_OFFSET
    last = PORT_BASE + PORTS_PER_DOMAIN * (domain_id + 1) - 1
    addresses = (line.split()[1] for line in udp_table.splitlines()[1:])
    ports = {int(address.split(':')[1], 16) for address in addresses}
    return len(ports.intersection(range(first, last, 2)))


def _has_met_all(node: Any, domain_id: int) -> bool:
    """Return whether every participant of this machine is known, its nodes by name."""
    endpoints = node.get_publishers_info_by_topic('/parameter_events')
    if any(endpoint.node_name == NAME_UNKNOWN for endpoint in endpoints):
        return False
    participants = {bytes(endpoint.endpoint_gid[:12]) for endpoint in endpoints}
    try:
        expected = local_participants(UDP_TABLE.read_text(), domain_id)
    except OSError:
        expected = 0
    return len(participants) >= expected


def _graph(node: Any) -> tuple[Any, ...]:
    """Return the graph as it is known now, to be compared with a later one."""
    return (
        node.get_node_names_and_namespaces(),
        node.get_topic_names_and_types(),
        node.get_service_names_and_types(),
    )
