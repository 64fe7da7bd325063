# SPDX-License-Identifier: Apache-2.0
"""The solids of a scenario's scenes, written by the command ``rocsafe scene solids``.

The radiation nodes read these files; no node needs to know how a scene is made.
"""

import subprocess

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.processes.executables import find_executable
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.scenario import Scenario

# A large scene takes ten seconds to make on a busy machine.
DEADLINE_S = 300.0


def export_scenes(scenario: Scenario, run: RunDirectory) -> None:
    """Write the files of solids that the nodes of a run read, unless they are there.

    Raises
    ------
    SetupError
        In one line, if a scene cannot be made in time or at all.
    """
    for scene in dict.fromkeys((scenario.engine_scene, scenario.radiation.scene_file)):
        if scene and not run.solids_of(scene).is_file():
            _export(scene, scenario, run)


def _export(scene: str, scenario: Scenario, run: RunDirectory) -> None:
    origin = scenario.origin_position()
    place = (origin.latitude_deg, origin.longitude_deg, origin.altitude_m)
    command = (
        str(find_executable('rocsafe_scene', 'scene')),
        'solids',
        scene,
        f'--out={run.solids_of(scene)}',
        f'--origin={",".join(map(repr, place))}',
        f'--seed={scenario.seed}',
    )
    try:
        done = subprocess.run(
            command, check=False, capture_output=True, text=True, timeout=DEADLINE_S
        )
    except subprocess.TimeoutExpired as error:
        raise SetupError(f'{scene}: making it took longer than {DEADLINE_S:g} s') from error
    if done.returncode:
        reason = (done.stderr.strip() or f'ended with {done.returncode}').splitlines()[-1]
        raise SetupError(f'{scene}: {reason.removeprefix("rocsafe: ")}')
