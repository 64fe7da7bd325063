# SPDX-License-Identifier: Apache-2.0
"""A replay of a run gives the products of the run."""

import json
import os
import subprocess
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import rasterio
from mcap.reader import make_reader

from .conftest import DEADLINE_S

pytestmark = pytest.mark.system
# Photographs that come in another order are placed and blended in another one.
MOST_DIFFERENCE = 0.5


def test_replay_gives_the_products_of_the_run(
    complete: Any, rocsafe: Path, ros_domain_id: int, tmp_path: Path
) -> None:
    """Estimates of the localizer, the map and the photographs are those of the flight."""
    done = subprocess.run(
        [rocsafe, 'replay', complete.run.path, '--out', tmp_path],
        capture_output=True, text=True, timeout=DEADLINE_S, check=False,
        env={**os.environ, 'ROS_DOMAIN_ID': str(ros_domain_id)},
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    assert 'the same as recorded' in done.stdout
    (made,) = tmp_path.iterdir()
    for name in ('sources.json', 'dose_map.tif', 'readings.csv'):
        assert (made / name).read_bytes() == (complete.run.path / name).read_bytes(), name
    assert mean_difference(made / 'mosaic.tif', complete.run.mosaic) < MOST_DIFFERENCE
    assert images(made) == images(complete.run.path)
    assert json.loads((made / 'summary.json').read_text())['outcome'] == 'complete'


def mean_difference(made: Path, flown: Path) -> float:
    """Return the mean difference of two maps of the same place, grey levels."""
    with rasterio.open(made) as ours, rasterio.open(flown) as theirs:
        assert ours.transform == theirs.transform
        assert ours.crs == theirs.crs
        return float(np.abs(ours.read().astype(float) - theirs.read()).mean())


def images(run: Path) -> dict[str, Any]:
    """Return the records of the stored photographs, without what the store adds."""
    records = {}
    for path in sorted((run / 'images').glob('*-*.json')):
        record = json.loads(path.read_text())
        # Tags are written into the file, so that its hash is not that of the vehicle.
        records[path.stem] = {k: v for k, v in record.items() if 'sha256' not in k and k != 'lens'}
        records[path.stem].pop('stored_bytes')
    return records


def test_recording_is_whole(complete: Any) -> None:
    """Readings and doses, the clock, the log, decisions and receipts."""
    with complete.run.recording.open('rb') as stream:
        summary = make_reader(stream).get_summary()
    counts = {
        channel.topic: summary.statistics.channel_message_counts.get(channel.id, 0)
        for channel in summary.channels.values()
    }
    assert counts['/rav1/radiation'] >= counts['/rav1/accumulated_dose'] > 0
    for topic in ('/clock', '/rosout', '/decisions', '/shots/receipts', '/rav1/path'):
        assert counts[topic] > 0, topic
