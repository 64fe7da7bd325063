# SPDX-License-Identifier: Apache-2.0
"""Random kills over all processes and phases: a part of the campaign of tools/kill_campaign.py.

``ROCSAFE_MISSION_KILLS=200`` kills more often.
"""

import os
import subprocess
import sys
from pathlib import Path

import pytest

CAMPAIGN = Path(__file__).parents[2] / 'tools' / 'kill_campaign.py'
KILLS = int(os.environ.get('ROCSAFE_MISSION_KILLS', '12'))
# Of one blow, with its share of a mission, on a busy machine.
BLOW_S = 30.0

pytestmark = [pytest.mark.system, pytest.mark.all]


@pytest.mark.timeout(60.0 + 2.0 * KILLS * BLOW_S)
def test_random_kills_lose_nothing(ros_domain_id: int, rocsafe: Path, tmp_path: Path) -> None:
    """No acknowledged photograph, traceback, orphan or product without a word; ends in time."""
    command = [
        sys.executable, str(CAMPAIGN), '--kills', str(KILLS), '--minutes', str(KILLS),
        '--results', str(tmp_path / 'kills.jsonl'), '--folder', str(tmp_path),
    ]  # fmt: skip
    path = f'{rocsafe.parent}{os.pathsep}{os.environ["PATH"]}'
    environment = {**os.environ, 'ROS_DOMAIN_ID': str(ros_domain_id), 'PATH': path}
    done = subprocess.run(command, env=environment, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert ' 0 faults' in done.stdout
