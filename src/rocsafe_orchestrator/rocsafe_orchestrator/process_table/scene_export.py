# SPDX-License-Identifier: Apache-2.0
"""Files of a scenario's scenes that the nodes of a run read, written by other commands.

``rocsafe scene solids`` writes the solids, ``rocsafe site-wind`` the wind around them; no node
needs to know how a scene is made.
"""

import subprocess

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.process_table.executables import find_executable
from rocsafe_orchestrator.run_directory import RunDirectory
from rocsafe_scenario.scenario import Scenario

# A large scene takes ten seconds to make on a busy machine.
DEADLINE_S = 300.0


def export_scenes(scenario: Scenario, run: RunDirectory) -> None:
    """Write the files of solids and wind that the nodes of a run read, unless they are there.

    Raises
    ------
    SetupError
        In one line, if a scene cannot be made in time or at all.
    """
    windy = scenario.air.wind.scene_file
    for scene in dict.fromkeys((scenario.engine_scene, scenario.radiation.scene_file, windy)):
        if scene and not run.solids_of(scene).is_file():
            _write_solids(scene, scenario, run)
    if windy and not run.site_wind.is_file():
        _write_wind(windy, scenario, run)


def _write_solids(scene: str, scenario: Scenario, run: RunDirectory) -> None:
    origin = scenario.origin_position()
    place = (origin.latitude_deg, origin.longitude_deg, origin.altitude_m)
    options = (
        f'--out={run.solids_of(scene)}',
        f'--origin={",".join(map(repr, place))}',
        f'--seed={scenario.seed}',
    )
    _make(scene, 'rocsafe_scene', 'scene', 'solids', scene, *options)


def _write_wind(scene: str, scenario: Scenario, run: RunDirectory) -> None:
    wind = scenario.air.wind
    options = (
        f'--out={run.site_wind}',
        f'--height={wind.height_m!r}',
        f'--roughness={wind.roughness_m!r}',
        f'--stability={wind.stability}',
        '--towards',
        *(f'{value:.6f}' for value in scenario.survey.airspace.wind_mps),
    )
    _make(scene, 'rocsafe_dispersion', 'site-wind', str(run.solids_of(scene)), *options)


def _make(scene: str, package: str, executable: str, *arguments: str) -> None:
    """Run a command that makes something of a scene."""
    command = (str(find_executable(package, executable)), *arguments)
    try:
        done = subprocess.run(
            command, check=False, capture_output=True, text=True, timeout=DEADLINE_S
        )
    except subprocess.TimeoutExpired as error:
        raise SetupError(f'{scene}: making it took longer than {DEADLINE_S:g} s') from error
    if done.returncode:
        reason = (done.stderr.strip() or f'ended with {done.returncode}').splitlines()[-1]
        raise SetupError(f'{scene}: {reason.removeprefix("rocsafe: ")}')
