# SPDX-License-Identifier: Apache-2.0
"""Make the moving picture of the console for the README, of a mission that flies.

    rocsafe run config/scenarios/derailment.yaml --console --speed 12     # prints the address
    python tools/moving_console.py http://127.0.0.1:8080/#token=... docs/console.webp

A picture is taken each second, by Chromium and Playwright, until the mission has ended.
"""

import io
import shutil
import sys
import time
from pathlib import Path

from PIL import Image
from playwright.sync_api import sync_playwright

SIZE_PX = {'width': 1440, 'height': 900}
FRAME_MS, LAST_MS, QUALITY = 400, 4000, 45
LIMIT_S = 300.0
ENDED = ('complete', 'partial', 'failed')


def main(address: str, out: str) -> int:
    """Take pictures until the mission has ended, and write them as one."""
    frames = []
    with sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path=shutil.which('chromium'), args=['--no-sandbox', '--disable-gpu']
        )
        page = browser.new_page(viewport=SIZE_PX, color_scheme='light')
        page.goto(address)
        end = time.monotonic() + LIMIT_S
        while time.monotonic() < end:
            # The page allows no text to be run as a script: it is asked from outside.
            if not page.evaluate('globalThis.rocsafe?.map?.isFitted'):
                page.wait_for_timeout(100)
                continue
            frames.append(Image.open(io.BytesIO(page.screenshot())).convert('RGB'))
            # The server of a mission ends with it.
            if page.evaluate('rocsafe.link.sections.mission?.phase') in ENDED:
                break
            page.wait_for_timeout(1000)
        browser.close()
    durations = [FRAME_MS] * (len(frames) - 1) + [LAST_MS]
    frames[0].save(out, save_all=True, append_images=frames[1:], loop=0, duration=durations,
                   quality=QUALITY, method=6)  # fmt: skip
    print(f'{out}: {len(frames)} pictures, {Path(out).stat().st_size / 1e6:.2f} MB')
    return 0


if __name__ == '__main__':
    sys.exit(main(*sys.argv[1:]))
