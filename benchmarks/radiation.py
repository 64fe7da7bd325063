# SPDX-License-Identifier: Apache-2.0
"""What the radiation nodes cost, and how often a search ends wrongly: targets and measured values.

    python benchmarks/radiation.py [--trials N] [--only NAME ...]

The part `node` needs the workspace to be sourced: it starts the executable `field` and feeds it.
"""

import argparse
import os

os.environ.setdefault('OPENBLAS_NUM_THREADS', '1')

import shutil
import subprocess
import tempfile
import time
from collections.abc import Callable, Iterator
from pathlib import Path

import numpy as np
import yaml
from localisation import (
    CAESIUM_USVH_PER_GBQ,
    OPTIONS,
    PITCH_M,
    World,
    drawn,
    flown,
)

from rocsafe_radiation.likelihood import Setting
from rocsafe_radiation.sequential_test import sequential_evidence
from rocsafe_radiation.stopping import ABSENT, CONTINUE, PRESENT, StoppingRule
from rocsafe_radiation.survey import Survey

Row = tuple[str, str, str]
VEHICLES, RATE_HZ, WARM_S, MEASURED_S = 10, 10.0, 3.0, 10.0
LINES_A_LOOK = 3
# The smallest source that matters, and one three times as strong.
SMALLEST_GBQ = 1.0


def stopping(count: int) -> Iterator[Row]:
    """Yield how often the test decides wrongly, looked at after each three lines of a survey."""
    rule = StoppingRule(smallest_usvh=SMALLEST_GBQ * CAESIUM_USVH_PER_GBQ)
    for name, gbq, wrong in (
        ('no source', 0.0, PRESENT),
        ('a source of 1 GBq', SMALLEST_GBQ, ABSENT),
        ('a source of 3 GBq', 3.0 * SMALLEST_GBQ, ABSENT),
    ):
        ends, looks = [], []
        for index in range(count):
            generator = np.random.default_rng([11, int(10 * gbq), index])
            truth = drawn(generator, int(gbq > 0.0), max(gbq, 1.0), max(gbq, 1.0) * 1.0001)
            verdict, line = _searched(flown(generator, World(), truth), rule)
            ends.append(verdict)
            looks.append(line)
        errors = ends.count(wrong) / count
        yield f'sequential test, {name}, {count} trials: wrong', '<= 0.01', f'{errors:.3f}'
        decided = 1.0 - ends.count(CONTINUE) / count
        yield f'sequential test, {name}: decided', '', f'{decided:.2f}'
        share = float(np.mean(looks)) / (300.0 / PITCH_M + 1.0)
        yield f'sequential test, {name}: share of the survey used', '', f'{share:.2f}'


def _searched(survey: Survey, rule: StoppingRule) -> tuple[str, int]:
    """Return how a survey, read line by line, is decided, and after how many lines.

    The ground is known from the start: what is not read yet has readings of next to no exposure.
    """
    setting = Setting(kernel=OPTIONS.kernel, source_up_m=OPTIONS.source_up_m)
    lines = np.round(survey.positions_enu_m[:, 1] / PITCH_M).astype(int)
    last = int(lines.max())
    for line in range(LINES_A_LOOK - 1, last + 1, LINES_A_LOOK):
        seen = lines <= line
        part = Survey(
            positions_enu_m=survey.positions_enu_m,
            counts=np.where(seen, survey.counts, 0.0),
            exposures=np.where(seen, survey.exposures, 1e-6),
        )
        decision = rule.decision(sequential_evidence(part, setting, rule.smallest_usvh))
        if decision != CONTINUE:
            return decision, line + 1
    return CONTINUE, last + 1


def node(_: int) -> Iterator[Row]:
    """Yield the processor time of the field for ten vehicles at ten fixes a second."""
    import rclpy
    from rclpy.node import Node
    from sensor_msgs.msg import NavSatFix, NavSatStatus

    from rocsafe_ros import topics
    from rocsafe_ros.conversions import stamp_of_ns

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
    count = 5
    parameters = {
        'model': 'air',
        'vehicles': names,
        'source_names': [f's{number}' for number in range(count)],
        'source_latitudes_deg': [53.28 + 2e-4 * number for number in range(count)],
        'source_longitudes_deg': [-9.06] * count,
        'source_altitudes_m': [66.0] * count,
        'source_sigmas_usvps': [2.57] * count,
        'detector': 'csi_33cm3',
        'background_usvh': 0.06,
        'background_variation': 0.2,
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


PARTS: dict[str, Callable[[int], Iterator[Row]]] = {'stopping': stopping, 'node': node}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description='Measure nodes and stopping against targets.')
    parser.add_argument('--trials', type=int, default=200, metavar='N', help='surveys a row')
    parser.add_argument('--only', nargs='+', choices=list(PARTS), default=list(PARTS))
    arguments = parser.parse_args()
    print(f'{"what":62} {"target":>10} {"measured":>10}')
    for part in arguments.only:
        for what, target, measured in PARTS[part](arguments.trials):
            print(f'{what:62} {target:>10} {measured:>10}', flush=True)


if __name__ == '__main__':
    main()
