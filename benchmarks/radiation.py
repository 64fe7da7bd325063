# SPDX-License-Identifier: Apache-2.0
"""What the radiation nodes cost: targets and measured values.

    python benchmarks/radiation.py

The workspace must be sourced: the executable `field` is started and fed.
"""

import os

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import yaml
from radiation_surveys import Row, print_table

VEHICLES, RATE_HZ, WARM_S, MEASURED_S = 10, 10.0, 3.0, 10.0


def node(_: int) -> Iterator[Row]:
    """Yield the processor time of the field for ten vehicles at ten fixes a second."""
    import rclpy
    from rclpy.node import Node
    from sensor_msgs.msg import NavSatFix, NavSatStatus

    from rocsafe_ros.conversions import stamp_of_ns
    from rocsafe_ros.interfaces import topics

    names = [f'rav{number + 1}' for number in range(VEHICLES)]
    rclpy.init()
    drones = Node('drones')
    publishers = [
        (
            topics.create_publisher(drones, topics.GROUND_TRUTH_FIX, name),
            topics.create_publisher(drones, topics.FIX, name),
        )
        for name in names
    ]
    with tempfile.TemporaryDirectory() as folder:
        process = _started_field(Path(folder), names)
        try:
            fix = NavSatFix(latitude=53.28, longitude=-9.06, altitude=98.0)
            fix.status.status = NavSatStatus.STATUS_FIX
            begin_s, used_s = 0.0, 0.0
            start = time.monotonic()
            for step in range(round((WARM_S + MEASURED_S) * RATE_HZ)):
                fix.header.stamp = stamp_of_ns(1_748_772_000_000_000_000 + step * 100_000_000)
                for pair in publishers:
                    for publisher in pair:
                        publisher.publish(fix)
                if step == round(WARM_S * RATE_HZ):
                    begin_s, used_s = time.monotonic(), _processor_s(process.pid)
                time.sleep(max(0.0, start + (step + 1) / RATE_HZ - time.monotonic()))
            share = (_processor_s(process.pid) - used_s) / (time.monotonic() - begin_s)
        finally:
            process.terminate()
            process.wait(timeout=10.0)
    drones.destroy_node()
    rclpy.shutdown()
    yield 'field, 10 vehicles at 10 Hz: share of a core', '<= 0.05', f'{share:.3f}'


def _started_field(folder: Path, names: list[str]) -> 'subprocess.Popen[bytes]':
    """Start the field with five sources in air, a counting detector and an uneven background."""
    sources = [
        {'name': f's{number}', 'position': [53.28 + 2e-4 * number, -9.06], 'sigma_usvps': 2.57}
        for number in range(5)
    ]
    settings = {
        'sources': sources,
        'ground_altitude_m': 66.0,
        'background': {'dose_rate_usvh': 0.06, 'variation': 0.2},
    }
    (folder / 'settings.yaml').write_text(yaml.safe_dump(settings), encoding='utf-8')
    parameters = {
        'model': 'air',
        'vehicles': names,
        'field_file': str(folder / 'settings.yaml'),
        'detector': 'csi_33cm3',
        'lock_step': False,
    }
    path = folder / 'field.yaml'
    path.write_text(yaml.safe_dump({'/**': {'ros__parameters': parameters}}), encoding='utf-8')
    command = shutil.which('field') or _installed('rocsafe_radiation', 'field')
    return subprocess.Popen([command, '--ros-args', '--params-file', str(path)])


def _installed(package: str, executable: str) -> str:
    for prefix in os.environ.get('AMENT_PREFIX_PATH', '').split(os.pathsep):
        path = Path(prefix) / 'lib' / package / executable
        if path.is_file():
            return str(path)
    raise SystemExit(f'{executable} of {package} is not installed: source the workspace')


def _processor_s(pid: int) -> float:
    """Return the processor time that a process has used."""
    fields = Path(f'/proc/{pid}/stat').read_text().rpartition(')')[2].split()
    return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')


PARTS: dict[str, Callable[[int], Iterator[Row]]] = {'node': node}


if __name__ == '__main__':
    print_table('Measure what the radiation nodes cost.', PARTS)
