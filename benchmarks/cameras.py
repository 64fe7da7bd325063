# SPDX-License-Identifier: Apache-2.0
"""Measure the streams of cameras inside a mission: pictures a second that reach a viewer.

    python benchmarks/cameras.py                    # three vehicles, a camera of 640 x 480 px each
    python benchmarks/cameras.py --seconds 60 --width 960 --height 600

The mission is that of config/scenarios/derailment_engine.yaml, started by `rocsafe run` as a user
starts it, as fast as the machine can. A viewer beside it watches the raw pictures of all vehicles
while they fly. Pictures a second are of wall time; simulated time waits for every picture, so that
none is dropped or torn. The processor time of the vehicles' process says more on a loaded machine.
"""

import argparse
import os
import signal
import subprocess
import sys
import tempfile
import time
from dataclasses import dataclass, field
from pathlib import Path

import rclpy
import yaml
from rclpy.node import Node
from rich.console import Console
from rich.table import Table
from sensor_msgs.msg import Image

from rocsafe_interfaces.msg import VehicleState
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import topics

SCENARIO = Path(__file__).resolve().parents[1] / 'config/scenarios/derailment_engine.yaml'
START_DEADLINE_S = 240.0
STOP_DEADLINE_S = 60.0
STREAM_RATE_HZ = 5.0
PERIOD_NS = round(1e9 / STREAM_RATE_HZ)
GOAL_HZ = 5.0


@dataclass(slots=True)
class Watched:
    """What a viewer has seen of one vehicle: wall times and stamps of pictures, and its state."""

    wall_s: list[float] = field(default_factory=list)
    stamps_ns: list[int] = field(default_factory=list)
    state: int = VehicleState.UNKNOWN

    def rate_hz(self) -> float:
        """Return pictures a second of wall time; 0 of fewer than two."""
        if len(self.wall_s) < 2:
            return 0.0
        return (len(self.wall_s) - 1) / (self.wall_s[-1] - self.wall_s[0])

    def missing(self) -> int:
        """Return how many pictures of the stream did not come between the first and the last."""
        if len(self.stamps_ns) < 2:
            return 0
        # photographs of viewpoints, which come between, are not of the stream
        streamed = [stamp for stamp in self.stamps_ns if stamp % PERIOD_NS == 0]
        return (streamed[-1] - streamed[0]) // PERIOD_NS + 1 - len(streamed)


def main() -> int:
    """Run, watch and print; 1 if the goal is missed or the mission did not fly."""
    arguments = _arguments()
    with tempfile.TemporaryDirectory(prefix='rocsafe-bench-') as folder:
        scenario, vehicles = _scenario(arguments, Path(folder))
        command = ['rocsafe', 'run', str(scenario), '--out', str(Path(folder) / 'run'), '--quiet']
        process = subprocess.Popen(command, stdout=subprocess.DEVNULL)
        try:
            watched, cpu_s = _watch(vehicles, arguments.seconds, process)
        finally:
            process.send_signal(signal.SIGINT)
            process.wait(STOP_DEADLINE_S)
    _print(watched, cpu_s, arguments)
    return 0 if min(each.rate_hz() for each in watched.values()) >= GOAL_HZ else 1


def _arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(description='Measure the streams of cameras in a mission.')
    parser.add_argument('--seconds', type=float, default=30.0, help='of flight to watch [30]')
    parser.add_argument('--width', type=int, default=640, help='of a picture, px [640]')
    parser.add_argument('--height', type=int, default=480, help='of a picture, px [480]')
    return parser.parse_args()


def _scenario(arguments: argparse.Namespace, folder: Path) -> tuple[Path, list[str]]:
    """Return the scenario that streams, and its vehicles."""
    content = yaml.safe_load(SCENARIO.read_text())
    camera = content['camera']
    camera['scene_file'] = str((SCENARIO.parent / camera['scene_file']).resolve())
    camera.update(
        stream_rate_hz=STREAM_RATE_HZ,
        image_width_px=arguments.width,
        image_height_px=arguments.height,
    )
    path = folder / 'streams.yaml'
    path.write_text(yaml.safe_dump(content))
    return path, [vehicle['name'] for vehicle in content['vehicles']]


def _watch(
    vehicles: list[str], seconds: float, run: 'subprocess.Popen[bytes]'
) -> tuple[dict[str, Watched], float]:
    """Return what a viewer sees of the vehicles for some seconds of flight.

    And the processor time that their process takes meanwhile, s.
    """
    rclpy.init()
    node = Node('viewer')
    watched = {name: Watched() for name in vehicles}
    for name, seen in watched.items():
        _listen(node, name, seen)
    end = time.monotonic() + START_DEADLINE_S
    while run.poll() is None and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
        if all(seen.state == VehicleState.FLYING for seen in watched.values()):
            break
    for seen in watched.values():
        seen.wall_s.clear()
        seen.stamps_ns.clear()
    before_s, end = _fleet_cpu_s(run.pid), time.monotonic() + seconds
    while run.poll() is None and time.monotonic() < end:
        rclpy.spin_once(node, timeout_sec=0.1)
    used_s = _fleet_cpu_s(run.pid) - before_s
    node.destroy_node()
    rclpy.shutdown()
    return watched, used_s


def _fleet_cpu_s(run: int) -> float:
    """Return the processor time that the vehicles' process of a run has taken, s; 0 if none."""
    for status in Path('/proc').glob('[0-9]*/stat'):
        try:
            name, _, rest = status.read_text().partition(' (')[2].rpartition(') ')
        except OSError:
            continue
        words = rest.split()
        if int(words[1]) == run and name == 'fleet':
            return (int(words[11]) + int(words[12])) / os.sysconf('SC_CLK_TCK')
    return 0.0


def _listen(node: Node, vehicle: str, seen: Watched) -> None:
    def on_image(message: Image) -> None:
        seen.wall_s.append(time.monotonic())
        seen.stamps_ns.append(ns_of_stamp(message.header.stamp))

    def on_state(message: VehicleState) -> None:
        seen.state = message.state

    topics.create_subscription(node, topics.CAMERA_IMAGE, on_image, vehicle)
    topics.create_subscription(node, topics.STATE, on_state, vehicle)


def _print(watched: dict[str, Watched], cpu_s: float, arguments: argparse.Namespace) -> None:
    table = Table('vehicle', 'pictures', 'a second', 'goal', 'missing', 'simulated s')
    for name, seen in watched.items():
        stamps = seen.stamps_ns
        span_s = (stamps[-1] - stamps[0]) / 1e9 if stamps else 0.0
        table.add_row(
            name, str(len(stamps)), f'{seen.rate_hz():.1f}', f'>= {GOAL_HZ:g}',
            str(seen.missing()), f'{span_s:.1f}',
        )  # fmt: skip
    console = Console()
    console.print(
        f'{arguments.width} x {arguments.height} px, {os.cpu_count()} processors, '
        f'load {os.getloadavg()[0]:.1f}'
    )
    console.print(table)
    count = sum(len(seen.stamps_ns) for seen in watched.values())
    if cpu_s and count:
        console.print(f'{1e3 * cpu_s / count:.0f} ms of a processor a picture')


if __name__ == '__main__':
    sys.exit(main())
