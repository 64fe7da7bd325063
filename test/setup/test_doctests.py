# SPDX-License-Identifier: Apache-2.0
"""The worked examples in the docstrings of functions that users call give what they say."""

import doctest
import importlib

import pytest

# Modules with what a user calls from Python.
MODULES = (
    'rocsafe_dispersion.estimation.locate',
    'rocsafe_dispersion.plume.steady_plume',
    'rocsafe_ground.drive.planning',
    'rocsafe_mapping.command_line.map_command',
    'rocsafe_planner.region_plan',
    'rocsafe_radiation.localization.localize',
    'rocsafe_radiation.physics.field',
    'rocsafe_scene.scene.scene_file',
)


@pytest.mark.slow
@pytest.mark.parametrize('name', MODULES)
def test_examples_in_docstrings_are_true(name):
    """Each module has one, and none fails."""
    result = doctest.testmod(importlib.import_module(name))
    assert result.attempted > 0
    assert result.failed == 0
