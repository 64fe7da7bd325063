# SPDX-License-Identifier: Apache-2.0
"""Bridge to the real vehicles of a scenario, and its real detectors, on the time of the wall.

    ros2 launch rocsafe_bringup hardware_launch.py scenario:=/path/to/scenario.yaml

The bridge arms nothing by itself: a vehicle flies when somebody calls its action `fly_route`. The
checks and the confirmation of `rocsafe run` are those of a mission and are not made here. Read
docs/real-drones.md before.
"""

from pathlib import Path

from launch.actions import IncludeLaunchDescription
from launch.launch_description_sources import PythonLaunchDescriptionSource

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    processes = PythonLaunchDescriptionSource(str(Path(__file__).with_name('sim_launch.py')))
    return LaunchDescription(
        [IncludeLaunchDescription(processes, launch_arguments=[('hardware', 'true')])]
    )
