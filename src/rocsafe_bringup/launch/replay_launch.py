# SPDX-License-Identifier: Apache-2.0
"""Localizer and map fed from a recorded run again.

ros2 launch rocsafe_bringup replay_launch.py run:=/path/to/runs/derailment-20261123-101500
"""

from launch.actions import DeclareLaunchArgument, ExecuteProcess, Shutdown
from launch.substitutions import LaunchConfiguration

from launch import LaunchDescription


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription(
        [
            DeclareLaunchArgument('run', description='folder of the run'),
            ExecuteProcess(
                cmd=['rocsafe', 'replay', LaunchConfiguration('run')],
                name='replay',
                output='screen',
                on_exit=Shutdown(reason='replayed'),
            ),
        ]
    )
