# SPDX-License-Identifier: Apache-2.0
"""Read a run without ROS: its summary, and every reading from the recording.

python examples/read_run.py runs/derailment-20261123-101500
"""

import json
import sys
from pathlib import Path

from mcap_ros2.reader import read_ros2_messages


def main(run: str) -> int:
    """Print the highest reading of each vehicle; return how many readings there are."""
    summary = json.loads(Path(run, 'summary.json').read_text())
    print(f'{summary["scenario"]}: {summary["outcome"]}, {summary["images_stored"]} photographs')
    highest: dict[str, float] = {}
    count = 0
    for item in read_ros2_messages(str(Path(run, 'mission.mcap'))):
        vehicle, _, topic = item.channel.topic.strip('/').partition('/')
        if topic == 'radiation':
            rate = float(item.ros_msg.dose_rate_usvh)
            highest[vehicle] = max(rate, highest.get(vehicle, 0.0))
            count += 1
    for vehicle, rate in sorted(highest.items()):
        print(f'{vehicle}: at most {rate:.1f} uSv/h')
    print(f'{count} readings')
    return count


if __name__ == '__main__':
    main(sys.argv[1])
