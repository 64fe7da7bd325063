# SPDX-License-Identifier: Apache-2.0
"""Space on the disk of a run: an estimate before the flight, a reserve during it."""

import shutil
from pathlib import Path

from rocsafe_orchestrator.errors import SetupError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.survey_size import fewest_viewpoints

MIB = 2**20
# The image store refuses photographs below this (its parameter reserve_mb): recording, map and
# report need room for what has been measured.
RESERVE_BYTES = 64 * MIB
# What a run writes besides, such as scenes, logs and report.
BASE_BYTES = 16 * MIB
# For each pixel of a photograph: copies of the vehicle, the store and the recording, and the map.
# 3.1 and 4.0 in the shipped missions derailment and five_vertex_field.
BYTES_A_PIXEL = 4


def needed_bytes(scenario: Scenario) -> int:
    """Return about how many bytes a run writes."""
    camera = scenario.camera
    count = fewest_viewpoints(scenario.area(), scenario.survey, camera)
    pixels = camera.image_width_px * camera.image_height_px * (1 + len(scenario.other_cameras))
    return BASE_BYTES + count * pixels * BYTES_A_PIXEL


def require_space(folder: Path, scenario: Scenario) -> None:
    """Make sure that a run of `scenario` fits on the disk of `folder`, which need not exist.

    Raises
    ------
    SetupError
        With what is free, and about what is needed.
    """
    there = next(path for path in (folder.absolute(), *folder.absolute().parents) if path.is_dir())
    free, needed = shutil.disk_usage(there).free, needed_bytes(scenario) + RESERVE_BYTES
    if free < needed:
        raise SetupError(
            f'disk of {folder}: {free // MIB} MiB are free, must be about {needed // MIB} MiB for '
            'this mission: free some, or name another folder with --out'
        )


def shortage(folder: Path) -> str:
    """Return that the disk of a run is as good as full, empty if it is not."""
    free = shutil.disk_usage(folder).free
    if free >= RESERVE_BYTES:
        return ''
    return (
        f'the disk of {folder} is full: {free // MIB} MiB are free, must be at least '
        f'{RESERVE_BYTES // MIB} MiB'
    )
