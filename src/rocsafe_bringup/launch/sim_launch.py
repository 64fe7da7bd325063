# SPDX-License-Identifier: Apache-2.0
"""All processes of a scenario, without the mission: plan and fly by topics, services, actions.

ros2 launch rocsafe_bringup sim_launch.py scenario:=/path/to/scenario.yaml
ros2 service call /world/run std_srvs/srv/SetBool '{data: true}'     # time begins to run
"""

from pathlib import Path

from launch.actions import DeclareLaunchArgument, ExecuteProcess, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration

from launch import LaunchContext, LaunchDescription
from rocsafe_orchestrator.process_table.bringup import scenario_launches


def processes(context: LaunchContext) -> list[ExecuteProcess]:
    """Return the processes; the end of one ends all."""
    scenario = Path(LaunchConfiguration('scenario').perform(context))
    parent = Path(LaunchConfiguration('out').perform(context))
    is_hardware = LaunchConfiguration('hardware').perform(context) == 'true'
    starts, environment = scenario_launches(scenario, parent, is_hardware=is_hardware)
    return [
        ExecuteProcess(
            cmd=list(start.command), name=start.name, env=dict(environment), output='screen',
            sigterm_timeout='20',
            on_exit=Shutdown(reason=f'{start.name} has ended'),
        )
        for start in starts
    ]  # fmt: skip


def generate_launch_description() -> LaunchDescription:
    """Return what `ros2 launch` starts."""
    return LaunchDescription(
        [
            DeclareLaunchArgument('scenario', description='scenario file'),
            DeclareLaunchArgument('out', default_value='runs', description='where runs are kept'),
            DeclareLaunchArgument(
                'hardware', default_value='false', choices=['false', 'true'],
                description='only the bridge and real detectors, on the time of the wall',
            ),
            OpaqueFunction(function=processes),
        ]
    )  # fmt: skip
