# SPDX-License-Identifier: Apache-2.0
"""The report's script runs in a real browser without network, under the report's own policy."""

import re
import shutil
import subprocess
from html import escape

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


# Names what is wider than the window; scrolled tables and the map clip what they hold themselves.
MEASURE = """<script>
const wide = [...document.querySelectorAll('main *, header *')].filter((e) =>
  !e.closest('svg, .table-scroll, .gallery, .visually-hidden') &&
  e.getBoundingClientRect().right > innerWidth + 0.5 && e.getBoundingClientRect().width > 0);
const told = parent.document.body.dataset;
told.width = innerWidth;
told.wide = wide.map((e) => e.tagName + '.' + e.className).join(' ');
told.scrolled = [...document.querySelectorAll('.table-scroll')].filter((e) =>
  e.scrollWidth > e.clientWidth + 1).map((e) => e.className).join(' ');
const values = [...document.querySelectorAll('.tile-value')];
values.at(-2).innerHTML = '4\u00a0800<span class="unit">particles/l</span>';
told.cut = values.filter((e) => e.scrollWidth > e.clientWidth + 1).map((e) => e.innerText);
</script></body>"""


@pytest.mark.all
@pytest.mark.system
@pytest.mark.skipif(CHROMIUM is None, reason='no chromium on this machine')
def test_nothing_is_clipped_on_a_phone(flown_run, tmp_path):
    """At 390 pixels nothing is wider than the window or its tile, no table must be scrolled."""
    run = tmp_path / 'run'
    shutil.copytree(flown_run, run)
    write_products(run)
    page = (run / 'report.html').read_text(encoding='utf-8')
    # The policy of the page admits its own script alone.
    page = re.sub(r'<meta http-equiv="Content-Security-Policy"[^>]*>', '', page)
    frame = (
        f'<iframe width="390" height="800" srcdoc="{escape(page.replace("</body>", MEASURE))}">'
    )
    (run / 'phone.html').write_text(f'<body>{frame}</iframe></body>', encoding='utf-8')
    done = subprocess.run(
        [CHROMIUM, *OPTIONS, f'--user-data-dir={tmp_path / "profile"}', f'file://{run}/phone.html'],
        capture_output=True, text=True, timeout=TIMEOUT_S, check=True,
    )  # fmt: skip
    body = re.search(r'<body[^>]*>', done.stdout)[0]
    assert 'data-width="390"' in body
    assert 'data-wide=""' in body
    assert 'data-scrolled=""' in body
    assert 'data-cut=""' in body
