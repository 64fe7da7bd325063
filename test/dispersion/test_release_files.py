# SPDX-License-Identifier: Apache-2.0
"""Files of an earlier estimate do not outlive it."""

from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

from rocsafe_dispersion.mission_gas import release_files
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition

OF_A_RELEASE = ('threat_zones.geojson', 'threat_zones.kml', 'plume.tif')


def test_zones_of_a_release_that_was_given_up_are_removed(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Nobody finds the zones of an old estimate beside the newest, which has none."""
    monkeypatch.setattr(release_files, 'gas_figure', lambda _assessment: '<svg/>')
    for name in OF_A_RELEASE:
        (tmp_path / name).write_text('of the estimate before')
    nothing: Any = SimpleNamespace(plume=None)
    frame = LocalFrame(GeoPosition(53.28, -9.06, 57.0))
    release_files.write_release_files(tmp_path, {'releases': []}, nothing, frame)
    assert sorted(path.name for path in tmp_path.iterdir()) == ['gas.svg', 'release.json']
