# SPDX-License-Identifier: Apache-2.0
"""Bytes on the wire of packets between hosts, over DDS and over Zenoh.

Each host of three is a network namespace with one process for its agents. Each agent sends one
packet a second, as in steady flight. All packets on the interface count, those of discovery too.
Needs root and `ip`: ``sudo -E python benchmarks/fleet_link.py [--agents 3] [--seconds 30]``.
"""

import argparse
import os
import subprocess
import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rocsafe_fleet.link.fleet_link import FleetLink

HOSTS = 3
# A heartbeat of an agent of ten; see `python benchmarks/fleet.py bytes`.
PACKET_BYTES = 67
START_S = 8.0
PORT = 47613


def talk(link: str, number: int, agents: int, seconds: float) -> None:
    """Send and receive on one host, and print the bytes on the wire of start and steady time."""
    addresses = [f'10.92.0.{k + 1}' for k in range(HOSTS)]
    os.environ['ROCSAFE_INTERFACES'] = addresses[number]
    os.environ['ROCSAFE_PEERS'] = ','.join(addresses[: number + 1])
    way: FleetLink
    if link == 'dds':
        import rclpy
        from rclpy.node import Node

        from rocsafe_fleet.dds_link_node import DdsLink
        from rocsafe_ros.domain.network import bind_interfaces

        bind_interfaces(os.environ)
        rclpy.init()
        node = Node(f'agents_{number}', start_parameter_services=False, enable_rosout=False)
        way = DdsLink(node)
    else:
        from rocsafe_fleet.link.zenoh_link import ZenohLink

        ends = [f'{address}:{PORT}' for address in addresses]
        way = ZenohLink('bench', ends[number], [end for end in ends if end != ends[number]])
        node = None
    counted, begin_s, sent = [wire()], time.monotonic(), 0
    while (now_s := time.monotonic() - begin_s) < START_S + seconds:
        if len(counted) == 1 and now_s >= START_S:
            counted.append(wire())
        if now_s * agents >= sent:
            sent += 1
            way.send(os.urandom(PACKET_BYTES))
        if node is not None:
            rclpy.spin_once(node, timeout_sec=0.02)
        else:
            time.sleep(0.02)
        way.receive()
    counted.append(wire())
    start, steady = counted[1] - counted[0], counted[2] - counted[1]
    received = way.bytes_received // PACKET_BYTES
    print(start, steady / seconds, received, flush=True)
    os._exit(0)


def wire() -> int:
    """Return the bytes that this host has sent."""
    return int(Path('/sys/class/net/eth0/statistics/tx_bytes').read_text())


@contextmanager
def namespaces() -> Iterator[list[str]]:
    """Make the hosts and a switch."""
    spaces = [f'rfl{os.getpid()}{k}' for k in range(HOSTS)]
    switch = f'rfl{os.getpid()}s'
    for space in (*spaces, switch):
        ip('netns', 'add', space)
    try:
        ip('-n', switch, 'link', 'add', 'bridge', 'up', 'type', 'bridge')
        for k, space in enumerate(spaces):
            veth = ('type', 'veth', 'peer', 'name', 'eth0', 'netns', space)
            ip('-n', switch, 'link', 'add', f'v{k}', *veth)
            ip('-n', switch, 'link', 'set', f'v{k}', 'master', 'bridge', 'up')
            ip('-n', space, 'link', 'set', 'lo', 'up')
            ip('-n', space, 'addr', 'add', f'10.92.0.{k + 1}/24', 'dev', 'eth0')
            ip('-n', space, 'link', 'set', 'eth0', 'up', 'multicast', 'off')
        yield spaces
    finally:
        for space in (*spaces, switch):
            ip('netns', 'del', space)


def ip(*words: str) -> None:
    """Run `ip`."""
    subprocess.run(['ip', *words], check=True)


def main() -> None:
    """Measure both links, or be one host of a measurement."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--agents', type=int, default=3, help='on each host [3]')
    parser.add_argument('--seconds', type=float, default=30.0)
    parser.add_argument('--host', type=int, default=-1, help=argparse.SUPPRESS)
    parser.add_argument('--link', default='', help=argparse.SUPPRESS)
    options = parser.parse_args()
    if options.host >= 0:
        talk(options.link, options.host, options.agents, options.seconds)
    print('link   start, kB a host   steady, B/s an agent   received')
    for link in ('dds', 'zenoh'):
        with namespaces() as spaces:
            own = [sys.executable, __file__, '--agents', str(options.agents)]
            own += ['--seconds', str(options.seconds), '--link', link]
            # A host has its own mounts and memory, a namespace has not.
            alone = [
                'unshare',
                '-m',
                'sh',
                '-c',
                'mount -t tmpfs tmpfs /dev/shm && exec "$@"',
                'sh',
            ]
            hosts = [
                subprocess.Popen(
                    ['ip', 'netns', 'exec', space, *alone, *own, '--host', str(k)],
                    stdout=subprocess.PIPE,
                    text=True,
                )
                for k, space in enumerate(spaces)
            ]
            rows = [[float(x) for x in host.communicate()[0].split()] for host in hosts]
        start, steady, received = (sum(column) / HOSTS for column in zip(*rows, strict=True))
        sent = options.agents * (START_S + options.seconds) * (HOSTS - 1 + (link == 'dds'))
        share = received / sent
        print(f'{link:5}  {start / 1e3:15.1f}   {steady / options.agents:20.0f}   {share:8.0%}')


if __name__ == '__main__':
    main()
