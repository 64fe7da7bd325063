# SPDX-License-Identifier: Apache-2.0
"""A full disk is told before a flight and during it."""

import shutil
from collections.abc import Callable
from pathlib import Path
from types import SimpleNamespace

import pytest

from rocsafe_orchestrator.errors import EXIT_SETUP, SetupError
from rocsafe_orchestrator.processes.disk_space import (
    MIB,
    RESERVE_BYTES,
    needed_bytes,
    require_space,
    shortage,
)
from rocsafe_scenario.scenario_file import read_scenario


@pytest.fixture
def free_mib(monkeypatch: pytest.MonkeyPatch) -> Callable[[int], None]:
    """Give a function that sets what is free."""

    def leave(mib: int) -> None:
        answer = SimpleNamespace(free=mib * MIB)
        monkeypatch.setattr(shutil, 'disk_usage', lambda _folder: answer)

    return leave


def test_need_grows_with_the_photographs(small: Callable[..., Path]) -> None:
    """Twice as wide pictures, and a second camera, need more."""
    plain = needed_bytes(read_scenario(small()))
    wide = needed_bytes(read_scenario(small({'camera.image_width_px': 1280})))
    double = needed_bytes(
        read_scenario(small({'other_cameras': [{'name': 'b', 'pitch_deg': 0.0}]}))
    )
    assert plain < wide
    assert plain < double


def test_mission_that_does_not_fit_is_refused(
    small: Callable[..., Path], tmp_path: Path, free_mib: Callable[[int], None]
) -> None:
    """One line with what is free and what is needed, for a folder that is still to be made."""
    scenario = read_scenario(small())
    free_mib(10_000)
    require_space(tmp_path / 'a' / 'b', scenario)
    free_mib(RESERVE_BYTES // MIB)
    words = r'disk of .*/a/b: 64 MiB are free, must be about \d+ MiB'
    with pytest.raises(SetupError, match=words) as caught:
        require_space(tmp_path / 'a' / 'b', scenario)
    assert caught.value.exit_code == EXIT_SETUP
    assert '\n' not in str(caught.value)


def test_reserve_is_told_once_it_is_used(tmp_path: Path, free_mib: Callable[[int], None]) -> None:
    """Below it nothing more is measured."""
    free_mib(64)
    assert shortage(tmp_path) == ''
    free_mib(63)
    assert 'is full: 63 MiB are free, must be at least 64 MiB' in shortage(tmp_path)
