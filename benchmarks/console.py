# SPDX-License-Identifier: Apache-2.0
"""Measures the operator's page: ``python benchmarks/console.py [--vehicles 300] [--seconds 10]``.

A mission flies on a stage without ROS at 10 Hz, with dose map and mosaic; Chromium without a
graphics processor shows it. Prints each figure with its target. The machine should be idle.
"""

import argparse
import asyncio
import bisect
import json
import resource
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

import aiohttp
from playwright.sync_api import Page, sync_playwright

sys.path.insert(0, str(Path(__file__).resolve().parents[1] / 'test' / 'console'))

from caller import Caller, revisions_of
from forger import Forger, forge
from stage import TOKEN, Stage, served

WATCH = """() => {
  const seen = window.seen = { frames: 0, long: [], delays: [] };
  const count = () => { seen.frames += 1; requestAnimationFrame(count); };
  requestAnimationFrame(count);
  new PerformanceObserver((list) => {
    for (const one of list.getEntries()) seen.long.push(one.duration);
  }).observe({ type: 'longtask' });
  const draw = rocsafe.map.vehicleLayer.drawing;
  let newest = 0;
  rocsafe.link.addEventListener('frame', ({ detail }) => { newest = detail.wall; });
  rocsafe.map.vehicleLayer.drawing = (...all) => {
    draw(...all);
    if (newest) { seen.delays.push([newest, Date.now() / 1000]); newest = 0; }
  };
  const now = () => Date.now() / 1000;
  const play = rocsafe.sound.play.bind(rocsafe.sound);
  rocsafe.sound.play = (name) => { play(name); if (name === 'critical') seen.heard ??= now(); };
  const look = () => {
    if (!seen.visible && document.querySelector('.alarm.critical')) {
      seen.visible = -1;
      requestAnimationFrame(() => { seen.visible = now(); });
    }
  };
  new MutationObserver(look).observe(document.body, { childList: true, subtree: true });
}"""
PAINT = """() => ({
  paint: performance.getEntriesByName('first-contentful-paint')[0]?.startTime,
})"""


class Pilot:
    """Flies the stage at 10 Hz in a thread; tells the CPU time that the flight itself takes."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        self.cpu_s = 0.0
        self.times_s: list[float] = []
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._fly, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """End the flight."""
        self._stop.set()
        self._thread.join()

    def _fly(self) -> None:
        while not self._stop.wait(0.1):
            begun_s = time.thread_time()
            self.times_s.append(time.time())
            self.stage.step()
            self.cpu_s += time.thread_time() - begun_s


def tell(name: str, value: float, unit: str, target: str) -> None:
    """Print a figure."""
    print(f'{name:48} {value:10.3f} {unit:4} target {target}')


def cpu_s() -> float:
    """Return the CPU time of this process, which serves the page."""
    used = resource.getrusage(resource.RUSAGE_SELF)
    return used.ru_utime + used.ru_stime


async def _listen(address: str, cookie: str, count: int, seconds: float) -> int:
    """Read as many pages as `count` would; return the bytes of one."""
    headers = {'Cookie': cookie, 'Origin': address.rstrip('/')}
    url = f'{address.replace("http", "ws", 1)}api/live'
    end_s = time.monotonic() + seconds

    async def read(socket: Any) -> int:
        size = 0
        while time.monotonic() < end_s:
            size += len((await socket.receive()).data)
        return size

    async with aiohttp.ClientSession(headers=headers) as session:
        sockets = [await session.ws_connect(url, max_msg_size=0) for _ in range(count)]
        # Each by itself: a page that waited for another's message would answer no ping in time.
        sizes = await asyncio.gather(*map(read, sockets))
        for one in sockets:
            await one.close()
    return sizes[0]


def measure_server(stage: Stage, address: str, seconds: float) -> None:
    """Measure the CPU time of the server with ten pages that only read, in another process."""
    caller = Caller(address)
    caller.ask('/api/token', {'token': TOKEN})
    program = (
        f'import sys, asyncio; sys.path.insert(0, {str(Path(__file__).resolve().parent)!r}); '
        f'import console; print(asyncio.run(console._listen({address!r}, {caller.cookie!r}, 10, '
        f'{seconds})))'
    )
    pilot = Pilot(stage)
    before_s, begun_s = cpu_s(), time.monotonic()
    command = [sys.executable, '-c', program]
    done = subprocess.run(command, stdout=subprocess.PIPE, text=True, check=True)
    share = (cpu_s() - before_s - pilot.cpu_s) / (time.monotonic() - begun_s)
    pilot.stop()
    tell('server with 10 pages, of one core', 100 * share, '%', '<= 10')
    tell('bytes a second and page', int(done.stdout) / seconds / 1000, 'kB/s', '-')


def measure_page(page: Page, stage: Stage, address: str, seconds: float) -> None:
    """Measure drawing, delays, an alarm, and an order to all."""
    begun_s = time.monotonic()
    page.goto(f'{address}#token={TOKEN}')
    wait(page, 'document.querySelectorAll(".vehicle").length > 0')
    tell('usable', time.monotonic() - begun_s, 's', '<= 1.0')
    figures: dict[str, Any] = page.evaluate(PAINT)
    tell('first paint', figures['paint'] / 1000, 's', '<= 0.5')
    pilot = Pilot(stage)
    page.wait_for_timeout(2000)
    page.evaluate(WATCH)
    begun_s = time.monotonic()
    page.wait_for_timeout(seconds * 1000)
    passed_s = time.monotonic() - begun_s
    seen = page.evaluate('window.seen')
    tell('frames a second', seen['frames'] / passed_s, '', '>= 30')
    long = sorted(seen['long']) or [0.0]
    tell('p95 of long tasks', long[int(0.95 * (len(long) - 1))], 'ms', '<= 50')
    tell('long tasks a second', len(seen['long']) / passed_s, '', '-')
    tell_delays(seen['delays'], pilot.times_s)
    measure_alarm(page, stage)
    page.click('[data-verb="hold"]')
    page.wait_for_selector('.order-confirm')
    begun_s = time.monotonic()
    page.click('.order-confirm')
    page.wait_for_selector('.results li.done')
    tell('click to the list of results of all vehicles', time.monotonic() - begun_s, 's', '<= 1')
    pilot.stop()


def tell_delays(drawn: list[list[float]], told_s: list[float]) -> None:
    """Print how long a position takes to the screen, from the server and from its topic."""
    from_server = [drawn_s - wall_s for wall_s, drawn_s in drawn]
    times = [told_s[max(bisect.bisect(told_s, wall_s) - 1, 0)] for wall_s, _ in drawn]
    from_topic = [drawn_s - at_s for at_s, (_, drawn_s) in zip(times, drawn, strict=True)]
    tell('p95 from the server to the pixel', 1000 * _p95(from_server), 'ms', '-')
    tell('p95 from the topic to the pixel', 1000 * _p95(from_topic), 'ms', '<= 150')


def measure_alarm(page: Page, stage: Stage) -> None:
    """Measure from the alarm, as ROS tells it, to its first drawn frame and to its tone."""
    page.click('#sound')
    wait(page, 'rocsafe.sound.state === "on"')
    stage.state[stage.names[0]] = 9
    wait(page, 'window.seen.visible > 0 && window.seen.heard > 0')
    begun_s = page.evaluate(
        'rocsafe.link.sections.alarms.find((one) => one.severity === "critical").time_s'
    )
    for name, word in (('visible', 'visible'), ('heard', 'audible')):
        tell(
            f'alarm to {word}',
            1000 * (page.evaluate(f'window.seen.{name}') - begun_s),
            'ms',
            '<= 250',
        )


def _p95(values: list[float]) -> float:
    return statistics.quantiles(values, n=20)[-1] if len(values) > 1 else 0.0


def wait(page: Page, expression: str) -> None:
    """Wait until an expression of JavaScript is true; the page runs no text as a script."""
    end_s = time.monotonic() + 60.0
    while not page.evaluate(expression):
        if time.monotonic() > end_s:
            raise SystemExit(f'not within 60 s: {expression}')
        page.wait_for_timeout(10)


def measure_forgeries(stage: Stage, address: str, count: int) -> None:
    """Count forged, replayed and cross-site requests that are obeyed."""
    caller = Caller(address)
    caller.ask('/api/token', {'token': TOKEN})
    used = 'f' * 32
    order = {'request_id': used, 'verb': 'hold', 'revisions': revisions_of(stage)}
    caller.ask('/api/orders', order)
    caller.ask(f'/api/orders/{used}/confirm', {})
    sent, begun_s = len(stage.crew.sent), time.monotonic()
    forger = Forger(caller.address, caller.cookie, revisions_of(stage), used)
    statuses = asyncio.run(forge(forger, caller.address, count))
    print('answers by status:', dict(sorted(statuses.items())))
    tell(f'of {count} forged orders accepted', len(stage.crew.sent) - sent, '', '0')
    tell('forged orders a second', count / (time.monotonic() - begun_s), '', '-')


def main() -> None:
    """Measure."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('--vehicles', type=int, default=300)
    parser.add_argument('--seconds', type=float, default=10.0)
    parser.add_argument('--forgeries', type=int, default=100_000)
    parser.add_argument('--only-forgeries', action='store_true')
    parser.add_argument('--chromium', default='/usr/bin/chromium')
    given = parser.parse_args()
    print(json.dumps({'vehicles': given.vehicles, 'seconds': given.seconds}))
    with tempfile.TemporaryDirectory() as folder:
        stage = Stage(Path(folder), given.vehicles)
        stage.begin()
        with served(stage) as address:
            if not given.only_forgeries:
                with sync_playwright() as play:
                    options = ['--no-sandbox', '--disable-gpu']
                    browser = play.chromium.launch(executable_path=given.chromium, args=options)
                    page = browser.new_page(viewport={'width': 1440, 'height': 900})
                    measure_page(page, stage, address, given.seconds)
                    browser.close()
                measure_server(stage, address, given.seconds)
            measure_forgeries(stage, address, given.forgeries)


if __name__ == '__main__':
    main()
