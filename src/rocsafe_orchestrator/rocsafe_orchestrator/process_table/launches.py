# SPDX-License-Identifier: Apache-2.0
"""Commands of the processes: finds executables and writes parameter files."""

import os
import sys
from collections.abc import Iterable, Mapping
from pathlib import Path

from rocsafe_orchestrator.mission.closing import REPORT
from rocsafe_orchestrator.parameters.node_parameters import write_parameters
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.process_table.table import ProcessSpec
from rocsafe_orchestrator.process_table.values import NEVER, Launch
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_ros.domain.mission_identity import MissionIdentity
from rocsafe_ros.process.run import FLEET_LOCK_VARIABLE, SUPERVISOR_LOCK_VARIABLE

# Read by rocsafe_ros.process.run: a node ends when the process with this id does.
SUPERVISOR_VARIABLE = 'ROCSAFE_SUPERVISOR_PID'


def require_executables(table: Iterable[ProcessSpec]) -> list[Path]:
    """Return the executable of every process of `table` on this host.

    Raises
    ------
    SetupError
        If an executable is missing.
    """
    return [find_executable(spec.package, spec.executable) for spec in table if spec.is_here]


def launches(
    table: Iterable[ProcessSpec],
    run: RunDirectory,
    identity: MissionIdentity,
    config: Path | None = None,
) -> tuple[Launch, ...]:
    """Write the parameter files of this host and return how to start each, and the report.

    Parameters
    ----------
    identity
        The mission that every process tells that it belongs to.
    config
        A parameter file for all nodes; the scenario's values take precedence.

    Raises
    ------
    SetupError
        If an executable is missing.
    """
    here = (_launch(spec, run, identity, config) for spec in table if spec.is_here)
    return (*here, _report_launch(run))


def child_environment(run: RunDirectory, *, has_agents: bool = False) -> Mapping[str, str]:
    """Return the environment of every process of the run.

    With agents, the processes go on without their supervisor as long as the agents do.
    """
    locks = {
        FLEET_LOCK_VARIABLE: str(run.agents_lock),
        SUPERVISOR_LOCK_VARIABLE: str(run.lock),
    }
    return {
        **os.environ,
        **(locks if has_agents else {}),
        SUPERVISOR_VARIABLE: str(os.getpid()),
        # ROS writes one log file for each process, by default in the user's home.
        'ROS_LOG_DIR': str(run.logs / 'ros'),
        'PYTHONUNBUFFERED': '1',
        # Many processes share few cores, so that threads of each would only compete.
        'OPENBLAS_NUM_THREADS': '1',
    }


def _launch(
    spec: ProcessSpec, run: RunDirectory, identity: MissionIdentity, config: Path | None
) -> Launch:
    executable = find_executable(spec.package, spec.executable)
    parameters = run.parameters_of(spec.name)
    write_parameters(parameters, spec.node, spec.parameters)
    files = [str(path) for path in (config, parameters) if path is not None]
    # Every process uses simulated time.
    arguments = ['--ros-args', '-r', f'__ns:={spec.namespace}', '-p', 'use_sim_time:=true']
    arguments += identity.ros_arguments
    for remapping in spec.remappings:
        arguments += ['-r', remapping]
    for file in files:
        arguments += ['--params-file', file]
    return Launch(
        name=spec.name,
        command=(str(executable), *arguments),
        log=run.log_of(spec.name),
    )


def _report_launch(run: RunDirectory) -> Launch:
    """Return how to make the products, in a separate process that can be killed."""
    command = (sys.executable, '-m', 'rocsafe_orchestrator.report_process', str(run.path))
    return Launch(
        name=REPORT, command=command, log=run.log_of(REPORT), restart=NEVER, is_task=True
    )
