# SPDX-License-Identifier: Apache-2.0
"""The report's script runs in a real browser without network, under the report's own policy."""

import re
import shutil
import subprocess

import pytest

from rocsafe_orchestrator.write_products import write_products

CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser')
TIMEOUT_S = 60
OPTIONS = (
    '--headless', '--no-sandbox', '--disable-gpu', '--disable-quic', '--no-first-run',
    '--disable-background-networking', '--virtual-time-budget=2000', '--window-size=1200,1500',
    '--host-resolver-rules=MAP * ~NOTFOUND', '--dump-dom',
)  # fmt: skip


@pytest.mark.all
@pytest.mark.system
@pytest.mark.skipif(CHROMIUM is None, reason='no chromium on this machine')
def test_script_runs_and_fills_the_page(flown_run, tmp_path):
    """The policy admits the script; map, scale bar, replay and details are alive."""
    run = tmp_path / 'run'
    shutil.copytree(flown_run, run)
    write_products(run)
    done = subprocess.run(
        [CHROMIUM, *OPTIONS, f'--user-data-dir={tmp_path / "profile"}', f'file://{run}/report.html'],
        capture_output=True, text=True, timeout=TIMEOUT_S, check=True,
    )  # fmt: skip
    page = done.stdout
    assert re.search(r'<html[^>]* class="has-script"', page)
    assert re.search(r'class="scale-text">\d+ k?m<', page)
    assert re.search(r'id="details"[^>]*><b>[\d.]+ µSv/h</b>', page)
    assert 'aria-pressed="true"' in page
