# SPDX-License-Identifier: Apache-2.0
"""The page in a browser: live, grey when old, orders by clicks, no word to another host."""

import json
import re
import shutil
import socket
import stat
import subprocess
import sys
import threading
import time
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import pytest
from test.console.stage import ORIGIN, TOKEN, Stage, place_of, served
from test.console.test_video import jpeg_of

from rocsafe_console.orders import order_book
from rocsafe_console.people.roles import Action, Role
from rocsafe_console.people.session_file import load_sessions
from rocsafe_console.people.sessions import Sessions
from rocsafe_console.picture.picture import PHASES
from rocsafe_console.web.server import ServerThread
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition

CHROMIUM = shutil.which('chromium') or shutil.which('chromium-browser')
playwright = pytest.importorskip('playwright.sync_api', reason='playwright is not installed')
pytestmark = [
    pytest.mark.skipif(CHROMIUM is None, reason='no chromium on this machine'),
    pytest.mark.all,
]
WAIT_MS = 20_000
SIZES = {'desktop': (1440, 900), 'laptop': (1280, 720), 'phone': (390, 844), 'wall': (2560, 1440)}
AXE_RULES = ['wcag2a', 'wcag2aa', 'wcag21a', 'wcag21aa', 'best-practice']


@pytest.fixture(scope='module')
def browser() -> Iterator[object]:
    """Return a browser without a graphics processor."""
    with playwright.sync_playwright() as play:
        browser = play.chromium.launch(
            executable_path=CHROMIUM, args=['--no-sandbox', '--disable-gpu']
        )
        yield browser
        browser.close()


class Pilot:
    """A mission that flies on its stage at the pace of the wall, in a thread of its own."""

    def __init__(self, stage: Stage) -> None:
        self.stage = stage
        self._stop = threading.Event()
        self._thread = threading.Thread(target=self._fly, daemon=True)
        self._thread.start()

    def stop(self) -> None:
        """Let all fall silent."""
        self._stop.set()
        self._thread.join()

    def _fly(self) -> None:
        while not self._stop.wait(0.1):
            self.stage.step()


class View:
    """A page that is open, with everything that it must not do."""

    def __init__(
        self, browser, address: str, size: str = 'desktop', *, token: str = TOKEN, **options
    ) -> None:
        width, height = SIZES[size]
        self.page = browser.new_page(viewport={'width': width, 'height': height}, **options)
        self.page.set_default_timeout(WAIT_MS)
        self.faults: list[str] = []
        self.page.on('pageerror', lambda error: self.faults.append(str(error)))
        self.page.on('console', self._on_console)
        self.page.on('request', lambda request: self._on_request(request.url, address))
        self.page.goto(f'{address}#token={token}')

    def _on_console(self, message) -> None:
        # A server that is gone is told by the browser, too.
        if message.type == 'error' and 'ERR_CONNECTION_REFUSED' not in message.text:
            self.faults.append(message.text)

    def _on_request(self, url: str, address: str) -> None:
        inside = (address, address.replace('http', 'ws', 1), 'data:', 'blob:')
        if not url.startswith(inside):
            self.faults.append(f'a request to {url}')

    def wait(self, expression: str) -> None:
        """Wait until an expression of JavaScript is true.

        The page allows no text to be run as a script, so that it is asked from outside.
        """
        end_s = time.monotonic() + WAIT_MS / 1000
        while not self.page.evaluate(expression):
            assert time.monotonic() < end_s, f'not within {WAIT_MS} ms: {expression}'
            self.page.wait_for_timeout(30)


@pytest.fixture
def flight(tmp_path) -> Iterator[tuple[Stage, Pilot, str]]:
    """Return a mission of three vehicles that flies, and the address of its page."""
    stage = Stage(tmp_path)
    stage.begin()
    with served(stage) as address:
        pilot = Pilot(stage)
        yield stage, pilot, address
        pilot.stop()


def test_what_nobody_knows_the_age_of_is_marked_as_old(browser, flight):
    """The stage tells zones without a time: the word alone looked like a part of the sentence."""
    *_, address = flight
    view = View(browser, address)
    view.wait('document.querySelector(".fact-zones .note .age") !== null')
    mark = view.page.locator('.fact-zones .note .age')
    assert mark.inner_text() == 'stale'
    assert mark.get_attribute('class') == 'age old'
    view.page.close()


def test_without_a_mission_nothing_is_said_to_be_harmless(browser, tmp_path):
    """The page had a green "live", and "no ground above a level", before anything had flown."""
    with served(Stage(tmp_path)) as address:
        view = View(browser, address)
        view.wait('document.querySelector("#pulse").textContent === "no mission"')
        for fact in ('sources', 'zones'):
            assert 'not estimated yet' in view.page.inner_text(f'.fact-{fact}')
        view.page.close()


def test_vehicles_stand_in_the_order_of_their_names(browser, tmp_path):
    """However they were heard; map, list and replay give each the same colour."""
    stage = Stage(tmp_path, vehicles=11)
    stage.names.reverse()
    stage.begin()
    with served(stage) as address:
        view = View(browser, address)
        view.wait('document.querySelectorAll(".vehicle").length === 11')
        names = view.page.locator('.vehicle-name').all_inner_texts()
        assert names == [f'rav{number + 1}' for number in range(11)]
        colours = (
            '[...rocsafe.link.vehicles.values()].map(v => rocsafe.map.colourOf(v)).slice(0, 2)'
        )
        assert view.page.evaluate(colours) == ['#0a7bbf', '#d55e00']
        view.page.close()


# Whether all words in an element that tell a fact have the grey of what is old.
IS_GREY = """selector => {
    const grey = document.createElement('p');
    grey.className = 'grey';
    document.body.append(grey);
    const colour = getComputedStyle(grey).color;
    grey.remove();
    const all = [...document.querySelectorAll(selector)];
    return all.length > 0 && all.every((one) => getComputedStyle(one).color === colour);
}"""
# By what falls silent: where a fact is told, and who else is still live.
SILENT = {
    'detector': ('.fact-worst .big, .fact-worst .line', '.fact-vehicles .vehicle'),
    'mission': ('.fact-coverage .big, .fact-coverage .line, .badge', '.fact-worst .big'),
    'fix': ('.vehicle [data-fact="way_home"]', '.fact-worst .big'),
    'dose': ('.vehicle [data-fact="dose"]', '.fact-worst .big'),
}
OLD_SECTIONS = {
    'sources': '.fact-sources .line:first-child',
    'releases': '.fact-sources .line:last-child',
    'cordons_heard_s': '.fact-zones ul',
    'wind': '.fact-zones p.line',
    'photograph': '.fact-picture p.line:nth-of-type(1)',
    'mosaic': '.fact-picture p.line:nth-of-type(2)',
}


def test_each_fact_is_grey_when_it_is_old_and_no_other(browser, flight, monkeypatch):
    """A receiver, a detector, the mission, or an estimate that falls silent alone."""
    monkeypatch.setattr('rocsafe_console.picture.vehicle.DOSE_STALE_S', 3.0)
    stage, _, address = flight
    view = View(browser, address, 'wall')
    view.wait('document.querySelectorAll(".vehicle:not(.grey)").length === 3')
    grey = lambda selector: view.page.evaluate(IS_GREY, selector)  # noqa: E731
    for what, (shown, other) in SILENT.items():
        view.page.wait_for_timeout(600)
        assert not grey(shown), what
        stage.silent = {what}
        view.wait(f'({IS_GREY})({shown!r})')
        assert not grey(other), what
        if what == 'fix':
            assert 'its place is old' in view.page.inner_text('.vehicle-text >> nth=0')
            assert view.page.evaluate(
                '[...rocsafe.link.vehicles.values()].every((one) => rocsafe.map.isOld(one))'
            )
        stage.silent = set()
        view.wait(f'!({IS_GREY})({shown!r})')
    put, value = stage.context.live.picture.sections.put, stage.context.live.picture.sections.value
    put('zones', [])
    now_s = time.time()
    put('photograph', {'shot_id': 'rav1-1', 'vehicle': 'rav1', 'heard_s': now_s})
    for what in OLD_SECTIONS:
        put(what, now_s if what.endswith('_s') else {**value(what), 'heard_s': now_s})
    for what, shown in OLD_SECTIONS.items():
        view.wait(f'!({IS_GREY})({shown!r})')
        old_s = time.time() - 100.0
        put(what, old_s if what.endswith('_s') else {**value(what), 'heard_s': old_s})
        view.wait(f'({IS_GREY})({shown!r})')
        assert not grey('.fact-worst .big'), what
    assert view.page.locator('.fact-picture .old-picture').count() == 1
    view.page.close()


def test_a_mission_is_shown_live_and_grey_when_it_falls_silent(browser, flight):
    """Vehicles move and are not grey; after three seconds of silence all of them are."""
    _, pilot, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle:not(.grey)").length === 3')
    view.wait('document.querySelector("#pulse").textContent === "live"')
    assert 'token' not in view.page.url
    assert 'µSv/h' in view.page.inner_text('.fact-worst .big')
    before = view.page.evaluate('rocsafe.link.vehicles.get("rav1").frame.longitude')
    view.wait(f'rocsafe.link.vehicles.get("rav1").frame.longitude !== {before}')
    pilot.stop()
    view.wait('document.querySelectorAll(".vehicle.grey").length === 3')
    assert 'No word from the mission' in view.page.inner_text('#banner')
    assert view.page.inner_text('#pulse') == 'not live'
    assert not view.faults
    view.page.close()


def test_a_server_that_ends_is_told_and_comes_back(browser, tmp_path):
    """Nothing looks live meanwhile; the page goes on by itself, as the same user."""
    stage = Stage(tmp_path)
    stage.begin()
    pilot = Pilot(stage)
    with socket.create_server(('127.0.0.1', 0)) as free:
        port = free.getsockname()[1]
    stage.context.options = replace(stage.context.options, port=port)
    server = ServerThread(stage.context, print)
    view = View(browser, server.address)
    view.wait('document.querySelectorAll(".vehicle:not(.grey)").length === 3')
    server.close()
    view.wait('document.documentElement.classList.contains("not-live")')
    assert view.page.locator('.vehicle:not(.grey)').count() == 0
    assert 'The console has ended' in view.page.inner_text('#banner')
    stage.context.sessions = Sessions()
    load_sessions(tmp_path, stage.context.sessions, {'anna': Role.COMMANDER})
    server = ServerThread(stage.context, print)
    view.wait('document.querySelectorAll(".vehicle:not(.grey)").length === 3')
    view.wait('document.querySelector("#banner").hidden')
    view.page.close()
    pilot.stop()
    server.close()


def test_an_end_is_told_and_the_report_stays(browser, flight, tmp_path):
    """Of the mission, then of the console: neither looks live, nor like a fault."""
    stage, pilot, address = flight
    run = tmp_path / 'yard-20260601-100000'
    run.mkdir()
    (run / 'scenario.yaml').write_text('name: yard')
    (run / 'report.html').write_text('<title>Report</title>all is told')
    view = View(browser, address)
    view.wait('document.querySelector("#pulse").textContent === "live"')
    stage.phase = PHASES.index('complete')
    view.wait('document.querySelector("#pulse").textContent === "ended"')
    pilot.stop()
    view.wait('document.querySelectorAll(".vehicle.grey").length === 3')
    assert 'The mission has ended: complete' in view.page.inner_text('#banner')
    with view.page.context.expect_page() as opened:
        view.page.click('#banner a')
    assert 'all is told' in opened.value.inner_text('body')
    view.page.click('#banner button')
    view.page.wait_for_selector('#runs:not([hidden]) :text("yard-20260601-100000")')
    assert not view.faults
    view.page.close()


SPEAKER = """
import sys, time
import rclpy
from rclpy.node import Node
from rocsafe_interfaces.msg import MissionState, VehicleState
from rocsafe_ros.interfaces import topics
rclpy.init()
node = Node('speaker')
mission = topics.create_publisher(node, topics.MISSION_STATE)
state = topics.create_publisher(node, topics.STATE, 'rav1')
def speak():
    stamp = node.get_clock().now().to_msg()
    a, b = MissionState(mission_id='m1', phase=2), VehicleState(vehicle='rav1', state=4)
    a.header.stamp = b.header.stamp = stamp
    mission.publish(a)
    state.publish(b)
timer = node.create_timer(0.2, speak)
print('speaks', flush=True)
end = time.time() + 120
while time.time() < end:
    rclpy.spin_once(node, timeout_sec=0.1)
    if sys.stdin in __import__('select').select([sys.stdin], [], [], 0)[0] and timer is not None:
        sys.stdin.readline()
        timer.cancel()
        print('silent', flush=True)
        timer = None
"""
# Counts, each 20 ms, whether a vehicle or the mission's coverage is shown as live.
WATCH = """() => { window.seenLive = 0; setInterval(() => {
    window.seenLive += document.querySelectorAll('.vehicle:not(.grey)').length;
    window.seenLive += document.querySelectorAll('html:not(.not-live):not(.mission-old)').length;
    }, 20); }"""


class RealServer:
    """`rocsafe console` in a process of its own, always at the same port."""

    def __init__(self, runs: Path) -> None:
        with socket.create_server(('127.0.0.1', 0)) as free:
            self.port = free.getsockname()[1]
        self.runs = runs
        self.process = None

    def begin(self) -> str:
        """Start it, and return the address that it prints."""
        self.process = subprocess.Popen(
            [sys.executable, '-m', 'rocsafe_console.serve_node', '--runs', str(self.runs),
             '--port', str(self.port)], stdout=subprocess.PIPE, text=True,
        )  # fmt: skip
        return self.process.stdout.readline().removeprefix('console: ').strip()

    def kill(self) -> None:
        """End it without a word."""
        self.process.kill()
        self.process.wait()


def test_a_server_that_is_killed_comes_back_and_shows_nothing_old_as_live(
    browser, tmp_path, ros_domain_id, monkeypatch
):
    """SIGKILL, twice: the mission goes on, then it has fallen silent meanwhile."""
    pytest.importorskip('rclpy', reason='no ROS 2 here')
    # Vehicles of other missions on this machine would be shown, too.
    monkeypatch.setenv('ROS_DOMAIN_ID', str(ros_domain_id))
    speaker = subprocess.Popen(
        [sys.executable, '-c', SPEAKER], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True
    )
    server = RealServer(tmp_path)
    try:
        assert speaker.stdout.readline().strip() == 'speaks'
        address, token = server.begin().split('#token=')
        view = View(browser, address, token=token)
        shown = 'document.querySelectorAll(".vehicle:not(.grey)").length === 1'
        view.wait(shown)
        server.kill()
        view.wait('document.documentElement.classList.contains("not-live")')
        assert view.page.locator('.vehicle:not(.grey)').count() == 0
        assert 'Not live' in view.page.inner_text('#banner')
        server.begin()
        view.wait(shown)
        assert view.page.inner_text('#pulse') == 'live'
        # Logged in as before, with another token.
        assert view.page.evaluate('rocsafe.link.sections.session.role') == 'commander'
        speaker.stdin.write('be silent\n')
        speaker.stdin.flush()
        assert speaker.stdout.readline().strip() == 'silent'
        view.wait('document.querySelectorAll(".vehicle.grey").length === 1')
        server.kill()
        view.wait('document.documentElement.classList.contains("not-live")')
        view.page.evaluate(WATCH)
        server.begin()
        # What DDS has kept for late subscribers is heard, and is old.
        view.wait('rocsafe.link.isLive && rocsafe.link.sections.mission?.id === "m1"')
        view.wait('!document.querySelector("#banner").hidden')
        assert view.page.evaluate('window.seenLive') == 0
        view.page.close()
    finally:
        speaker.kill()
        speaker.wait()
        server.kill()


def test_an_order_needs_two_presses_and_its_results_are_shown(browser, flight):
    """The first sends nothing; Escape takes it back; keys do the same as the mouse."""
    stage, _, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    view.page.click('[data-verb="hold"]')
    view.page.wait_for_selector('.order-confirm')
    view.page.keyboard.press('Escape')
    view.page.wait_for_selector('[data-verb="hold"]')
    assert not stage.crew.sent
    view.page.keyboard.press('h')
    view.page.wait_for_selector('.order-confirm')
    view.page.keyboard.press('Enter')
    view.page.wait_for_selector('.results li.done')
    assert [(order.verb, len(names)) for order, names in stage.crew.sent] == [(Action.HOLD, 3)]
    view.page.check('#pick-rav2')
    stage.crew.refusal = 'rav2: led by the pilot'
    view.page.click('[data-verb="land"]')
    view.page.click('.order-confirm')
    view.page.wait_for_selector('.results li.bad')
    assert 'led by the pilot' in view.page.inner_text('.results')
    assert stage.crew.sent[1][1] == ('rav2',)
    assert not view.faults
    view.page.close()


def test_who_does_not_answer_in_time_is_seen_to_obey(browser, flight):
    """The list told "no answer" of vehicles that had held a moment later, until it was closed."""
    stage, _, address = flight
    stage.crew.is_silent = True
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    view.page.keyboard.press('h')
    view.page.wait_for_selector('.order-confirm')
    view.page.keyboard.press('Enter')
    view.wait('document.querySelector("[data-silent=rav2]")?.innerText === "(now: flying)"')
    names = view.page.locator('.results li').all_inner_texts()
    assert [words.split()[1] for words in names] == ['rav1', 'rav2', 'rav3']
    stage.state['rav2'] = 5
    view.wait('document.querySelector("[data-silent=rav2]").innerText === "(now: holding)"')
    assert view.page.inner_text('[data-silent="rav1"]') == '(now: flying)'
    assert not view.faults
    view.page.close()


# What each of the ten facts of the console is told by; six, to hold and return all, are orders.
TEN_FACTS = {
    'worst reading': '.fact-worst .big:not(.second), .fact-worst .link, .fact-worst .line',
    'sources': '.fact-sources li, .fact-sources .note',
    'zones, wind and access': '.fact-zones li, .fact-zones p.line',
    'coverage and time': '.fact-coverage .big, .fact-coverage .line, .fact-coverage .meter',
    'vehicles': '.fleet, .vehicle .state, .vehicle [data-fact]',
    'hold and return all': '.order-hold, .order-return',
    'newest picture and mosaic': '.fact-picture img, .fact-picture .line, #video-vehicle',
    'alarms': '.alarm .alarm-text, .alarm .small',
    'whether it is live': '#pulse',
    'incident report': '.fact-coverage .report',
}
# Parts of them that are not wholly in the window and in each box that scrolls; and the least
# contrast of their words with what lies behind.
SEEN = """selector => {
    const linear = (one) => one <= 0.04045 ? one / 12.92 : ((one + 0.055) / 1.055) ** 2.4;
    const channel = (one) => linear(one / 255);
    const light = ([r, g, b]) => 0.2126 * channel(r) + 0.7152 * channel(g) + 0.0722 * channel(b);
    const parts = (text) => text.match(/[\\d.]+/g).map(Number);
    const behind = (one) => {
        for (; one; one = one.parentElement) {
            const colour = parts(getComputedStyle(one).backgroundColor);
            if (colour[3] !== 0) return colour;
        }
    };
    let least = Infinity;
    const hidden = [...document.querySelectorAll(selector)].filter((one) => {
        const words = light(parts(getComputedStyle(one).color));
        const [low, high] = [words, light(behind(one))].sort((a, b) => a - b);
        if (one.innerText?.trim()) least = Math.min(least, (high + 0.05) / (low + 0.05));
        const box = one.getBoundingClientRect();
        let room = { left: 0, top: 0, right: innerWidth, bottom: innerHeight };
        for (let outer = one.parentElement; outer; outer = outer.parentElement) {
            if (getComputedStyle(outer).overflowY === 'visible') continue;
            const edge = outer.getBoundingClientRect();
            room = { left: Math.max(room.left, edge.left), right: Math.min(room.right, edge.right),
                top: Math.max(room.top, edge.top), bottom: Math.min(room.bottom, edge.bottom) };
        }
        return !box.width || box.left < room.left - 1 || box.right > room.right + 1
            || box.top < room.top - 1 || box.bottom > room.bottom + 1;
    });
    const count = document.querySelectorAll(selector).length;
    return [count, hidden.map((one) => one.outerHTML.slice(0, 120)), least];
}"""
LEAST_CONTRAST = 7.0


@pytest.mark.parametrize('theme', ['light', 'dark'])
@pytest.mark.parametrize('size', ['desktop', 'laptop', 'wall'])
def test_all_ten_facts_are_seen_at_a_glance(browser, tmp_path, flight, size, theme):
    """Without a scroll, a click or a hover, beside a map of half the window."""
    stage, _, address = flight
    live = stage.context.live
    photograph = tmp_path / 'rav1-00021.jpg'
    photograph.write_bytes(jpeg_of(640))
    with live.lock:
        live.note_photograph(photograph.stem, photograph)
        live.picture.alarm(time.time(), 'critical', 'rav1', 'rav1: 127 uSv/h reached the cordon')
        now_s = time.time()
        newest = {'shot_id': photograph.stem, 'vehicle': 'rav1', 'stamp_s': 1.0, 'heard_s': now_s}
        live.picture.sections.put('photograph', newest)
        for name in ('cordons_heard_s', 'zones_heard_s'):
            live.picture.sections.put(name, now_s)
    view = View(browser, address, size, color_scheme=theme)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    view.wait('document.querySelector(".alarm") !== null')
    view.page.wait_for_timeout(700)
    for fact, selector in TEN_FACTS.items():
        count, hidden, contrast = view.page.evaluate(SEEN, selector)
        assert count, fact
        assert not hidden, fact
        assert contrast >= LEAST_CONTRAST, fact
    width, height = SIZES[size]
    room = view.page.locator('.map-box').bounding_box()
    assert room['width'] * room['height'] >= 0.38 * width * height
    view.page.close()


def test_the_worst_of_many_vehicles_is_seen_at_a_glance(browser, tmp_path):
    """Who must turn home first, whose link is oldest, whose dose is highest, and who is silent."""
    stage = Stage(tmp_path, 60)
    stage.begin()
    with served(stage) as address:
        pilot = Pilot(stage)
        view = View(browser, address, 'laptop')
        view.wait('document.querySelectorAll(".vehicle").length > 20')
        live = stage.context.live
        with live.lock:
            live.picture.on_dose('rav41', 44.0, time.time(), time.time(), is_lower_limit=False)
            stage.silent.add('dose')
        view.wait('document.querySelector(".fleet").innerText.includes("most dose: rav41, 44")')
        count, hidden, contrast = view.page.evaluate(SEEN, '.fleet')
        assert (count, hidden) == (1, [])
        assert contrast >= LEAST_CONTRAST
        for words in (
            r'60 flying',
            r'first to turn home: rav\d+, in \d+ min',
            r'oldest link: rav\d+',
        ):
            view.wait(f'/{words}/.test(document.querySelector(".fleet").innerText)')
        pilot.stop()
        view.wait('/60 stale/.test(document.querySelector(".fleet .old")?.innerText)')
        view.page.close()


def test_a_translated_refusal_is_told_in_its_words(browser, flight):
    """Values are filled in, and translated themselves where they are texts of the server."""
    *_, address = flight
    view = View(browser, address)
    told = view.page.evaluate(
        """async () => {
            const { addTexts, told } = await import('/static/texts.js?again');
            addTexts({ 'not planned anew: {0}': 'kein neuer Plan: {0}',
                '{0} has changed since you looked: look again': 'zu spät für {0}' });
            return ['not planned anew: rav2 has changed since you looked: look again',
                'a text that nobody knows'].map(told);
        }"""
    )
    assert told == ['kein neuer Plan: zu spät für rav2', 'a text that nobody knows']
    view.page.close()


def test_the_map_stays_where_somebody_has_moved_it(browser, flight):
    """Whatever the mission says, and after a break of the link; another mission moves it."""
    stage, pilot, address = flight
    view = View(browser, address)
    view.wait('rocsafe.map.isFitted')
    view.page.evaluate('rocsafe.map.map.setView([53.3, -9.1], 18, { animate: false })')
    centre = 'rocsafe.map.map.getCenter().lat.toFixed(4)'
    put = stage.context.live.picture.sections.put
    pilot.stop()
    mission = {'id': 'yard-20260601-100000', 'phase': 'collecting', 'text': 'rav2 is home'}
    put('mission', mission)
    view.wait('rocsafe.link.sections.mission.phase === "collecting"')
    view.page.evaluate('rocsafe.link.socket.close()')
    view.wait('rocsafe.link.socket.readyState === 1 && rocsafe.link.silence < 1')
    view.page.wait_for_timeout(300)
    assert view.page.evaluate(centre) == '53.3000'
    put('mission', {**mission, 'id': 'another'})
    view.wait(f'{centre} !== "53.3000"')
    assert not view.faults
    view.page.close()


def test_one_press_is_no_two_steps(browser, flight):
    """Neither a double click, nor Enter that is kept down, sends what it has prepared."""
    stage, _, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    page = view.page
    page.click('[data-verb="hold"]')
    page.wait_for_selector('.order-confirm')
    box = page.locator('.order-confirm').bounding_box()
    page.mouse.move(box['x'] + 5, box['y'] + 5)
    page.mouse.down(click_count=2)
    page.mouse.up(click_count=2)
    page.keyboard.press('Escape')
    page.wait_for_selector('[data-verb="land"]')
    page.focus('[data-verb="land"]')
    for _ in range(40):
        # The first is a press, all others say that the key is still down.
        page.keyboard.down('Enter')
        page.wait_for_timeout(30)
    assert page.locator('.order-confirm').count() == 1
    page.keyboard.up('Enter')
    assert not stage.crew.sent
    page.keyboard.press('Enter')
    page.wait_for_selector('.results li.done')
    assert len(stage.crew.sent) == 1
    assert not view.faults
    view.page.close()


def test_an_answer_that_is_lost_is_no_refusal(browser, flight):
    """It is asked for again, and the order is sent once; without any, nobody says *refused*."""
    stage, _, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    lost = []

    def lose(route) -> None:
        lost.append(route.fetch().status)
        route.abort()

    view.page.route('**/confirm', lose, times=2)
    view.page.click('[data-verb="return"]')
    view.page.click('.order-confirm')
    view.page.wait_for_selector('.results li.done')
    assert (len(lost), len(stage.crew.sent)) == (2, 1)
    view.page.route('**/confirm', lose)
    view.page.click('[data-verb="land"]')
    view.page.click('.order-confirm')
    view.wait('document.querySelector(".results").textContent.includes("may have obeyed")')
    assert len(stage.crew.sent) == 2
    view.page.close()


def test_the_focus_stays_where_ages_are_counted(browser, flight):
    """A place in the facts can be reached and pressed by keys, also seconds later."""
    stage, _, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".fact-sources button").length === 2')
    picture = stage.context.live.picture
    for box in ('.fact-sources', '.fact-worst'):
        view.page.focus(f'{box} button')
        before = view.page.inner_text(f'{box} .age')
        wind = picture.sections.value('wind')
        picture.sections.put('wind', {**wind, 'heard_s': time.time() - 70.0})
        picture.worst = replace(picture.worst, dose_rate_usvh=1e9)
        value = picture.sections.value('sources')
        picture.sections.put('sources', {**value, 'heard_s': time.time() - 70.0})
        view.page.wait_for_timeout(2500)
        assert view.page.inner_text(f'{box} .age') != before
        assert view.page.evaluate(f'document.activeElement.closest("{box}") !== null')
    assert view.page.locator('.fact-zones p.line.grey').count() == 1
    assert 'ago' in view.page.inner_text('.fact-zones p.line')
    assert not view.faults
    view.page.close()


def test_a_ground_vehicle_is_sent_by_clicks(browser, tmp_path):
    """Its drive is shown with time and dose before it is confirmed; it is drawn on the map."""
    stage = Stage(tmp_path, has_rover=True)
    stage.begin()
    with served(stage) as address:
        pilot = Pilot(stage)
        view = View(browser, address)
        view.wait('document.querySelectorAll(".vehicle").length === 4')
        assert 'driving' in view.page.text_content('.vehicles')
        latitude, longitude = place_of(-60.0, -40.0)
        point = view.page.evaluate(
            f'rocsafe.map.map.latLngToContainerPoint([{latitude}, {longitude}])'
        )
        view.page.click('#map', position={'x': point['x'], 'y': point['y']})
        view.page.click('[data-send="rgv1"]')
        view.page.wait_for_selector('.order-confirm')
        assert '95 of 100 cases below 61' in view.page.inner_text('.order-offer')
        assert view.page.evaluate('rocsafe.map.offered.vehicle') == 'rgv1'
        assert not stage.crew.sent
        view.page.click('.order-confirm')
        view.page.wait_for_selector('.results li.done')
        ((order, names),) = stage.crew.sent
        assert (order.verb, names) == (Action.SEND, ('rgv1',))
        assert order.target.latitude_deg == pytest.approx(latitude, abs=1e-5)
        assert view.page.evaluate('rocsafe.map.offered') is None
        view.page.keyboard.press('p')
        view.page.click('.order-confirm')
        view.wait('document.querySelector(".results-head").textContent.includes("Plan anew")')
        assert (stage.crew.sent[1][0].verb, len(stage.crew.sent[1][1])) == (Action.REPLAN, 4)
        assert not view.faults
        view.page.close()
        pilot.stop()


def test_a_touch_must_last(browser, flight):
    """A brush of the glass confirms nothing."""
    stage, _, address = flight
    view = View(browser, address, 'phone', has_touch=True, is_mobile=True)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    view.page.tap('[data-verb="hold"]')
    view.page.wait_for_selector('.order-confirm')
    view.page.tap('.order-confirm')
    assert not stage.crew.sent
    pressed = 'new PointerEvent("pointerdown", {pointerType: "touch", bubbles: true})'
    view.page.evaluate(f'document.querySelector(".order-confirm").dispatchEvent({pressed})')
    view.page.wait_for_selector('.results li.done')
    assert len(stage.crew.sent) == 1
    view.page.close()


def test_an_alarm_is_seen_at_once_and_until_somebody_says_so(browser, flight):
    """It is counted, and its button tells who has seen it."""
    stage, _, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    stage.state['rav3'] = 9
    view.page.wait_for_selector('.alarm.critical')
    assert 'rav3 is lost' in view.page.inner_text('.alarm.critical')
    view.page.keyboard.press('a')
    view.page.wait_for_selector('.alarm.seen')
    assert 'seen by anna' in view.page.inner_text('.alarm.seen')
    assert not view.faults
    view.page.close()


def test_places_are_told_in_the_form_that_is_chosen(browser, flight):
    """Degrees, then DMS, then MGRS, of the worst reading; the choice is kept."""
    _, _, address = flight
    view = View(browser, address)
    view.page.wait_for_selector('.fact-worst .link')
    for form in (r'^53\.\d{6}, -9\.\d{6}$', r'^53°16.*N 9°03.*W$', r'^29U MV \d{5} \d{5}$'):
        assert re.search(form, view.page.inner_text('.fact-worst .link')), form
        view.page.click('#places')
        view.page.wait_for_timeout(50)
    assert view.page.inner_text('#places') == 'Deg'
    assert not view.faults
    view.page.close()


def test_a_camera_is_looked_at_and_left(browser, flight):
    """Its pictures have their age; old ones are grey; nothing is sent while nobody looks."""
    stage, _, address = flight
    video = stage.context.live.video
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    assert not video.wanted
    view.page.select_option('#video-vehicle', 'rav2')
    view.wait('rocsafe.video.socket?.readyState === 1')
    assert video.wanted == {'rav2'}
    with stage.context.live.lock:
        video.put('rav2', jpeg_of(200), time.time())
    view.wait('document.querySelector(".fact-camera img").naturalWidth === 64')
    assert 'taken' in view.page.inner_text('.fact-camera')
    view.wait('document.querySelector(".fact-camera img").classList.contains("old-picture")')
    assert 'old' in view.page.inner_text('.fact-camera .line')
    view.page.select_option('#video-vehicle', '')
    end_s = time.monotonic() + WAIT_MS / 1000
    while video.wanted:
        assert time.monotonic() < end_s
        view.page.wait_for_timeout(30)
    assert not view.faults
    view.page.close()


def test_an_alarm_is_heard_after_the_first_click_and_until_it_is_seen(browser, flight):
    """Before, the button says that nothing is heard; critical alarms repeat; mute is silent."""
    stage, pilot, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    stage.state['rav2'] = 9
    view.page.wait_for_selector('.alarm.critical')
    assert view.page.evaluate('rocsafe.sound.played') == []
    assert 'No sound' in view.page.inner_text('#sound')
    view.page.click('#sound')
    view.wait('document.querySelector("#sound").textContent === "Sound on"')
    # The alarm from before is still open.
    view.wait('rocsafe.sound.played.length >= 2')
    assert set(view.page.evaluate('rocsafe.sound.played')) == {'critical'}
    stage.state['rav3'] = 9
    view.wait('rocsafe.link.sections.alarms.length === 2')
    view.page.keyboard.press('a')
    view.wait('document.querySelectorAll(".alarm.seen").length === 1')
    view.page.keyboard.press('a')
    view.wait('rocsafe.sound.open.length === 0')
    heard = view.page.evaluate('rocsafe.sound.played.length')
    view.page.evaluate('rocsafe.sound.repeat()')
    assert view.page.evaluate('rocsafe.sound.played.length') == heard
    view.page.click('#sound')
    assert view.page.inner_text('#sound') == 'Sound off'
    stage.state['rav1'] = 9
    view.wait('rocsafe.link.sections.alarms.length === 3')
    assert view.page.evaluate('rocsafe.sound.played.length') == heard
    view.page.click('#sound')
    view.page.keyboard.press('a')
    view.wait('rocsafe.sound.open.length === 0')
    heard = view.page.evaluate('rocsafe.sound.played.length')
    # A mission that falls silent is heard once.
    pilot.stop()
    view.wait(f'rocsafe.sound.played.length === {heard + 1}')
    assert view.page.inner_text('#banner')
    assert not view.faults
    view.page.close()


def faults_of_axe(axe, view: View, shown: str) -> list[tuple[str, ...]]:
    """Return what axe finds in a page, with a contrast of 7 to 1."""
    rules = {'color-contrast-enhanced': {'enabled': True}}
    options = {'runOnly': AXE_RULES, 'rules': rules}
    violations = axe.Axe().run(view.page, options=options).response['violations']
    return [
        (shown, one['id'], node['html'][:120], node['failureSummary'][:300])
        for one in violations
        for node in one['nodes']
    ]


@pytest.mark.parametrize(('width', 'height'), [(844, 390), (320, 640)])
def test_a_phone_shows_map_facts_and_orders_however_it_is_held(browser, flight, width, height):
    """The page scrolls under the orders; no part of the map lies over them."""
    *_, address = flight
    view = View(browser, address)
    page = view.page
    page.set_viewport_size({'width': width, 'height': height})
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    assert page.evaluate('document.documentElement.scrollWidth') <= width
    assert page.locator('#map').bounding_box()['height'] >= 180
    # The scale of the map is moved under the orders.
    scale, order = (
        page.locator(one).bounding_box()
        for one in ('.leaflet-control-scale', '[data-verb="hold"]')
    )
    page.evaluate(f'scrollBy(0, {scale["y"] - order["y"]})')
    top = page.evaluate(
        """() => { const { x, y, height } = document.querySelector('.leaflet-control-scale')
            .getBoundingClientRect();
        return document.elementFromPoint(x + 30, y + height / 2).closest('.orders') !== null; }"""
    )
    assert top
    page.locator('.fact-zones').scroll_into_view_if_needed()
    # What became of an order leaves nearly half of an upright window to the facts.
    names = [f'rav{number}' for number in range(50)]
    told = [{'vehicle': name, 'outcome': 'done', 'text': ''} for name in names]
    page.evaluate('told => rocsafe.orders.tell(told, "Hold")', told)
    least = 0.45 if width < height else 0.25
    assert page.locator('.orders').bounding_box()['y'] >= least * height
    assert not view.faults
    page.close()


@pytest.mark.parametrize('theme', ['light', 'dark'])
def test_what_opens_over_the_page_and_what_is_old_can_be_read(
    browser, tmp_path, flight, theme, monkeypatch
):
    """A place, an order and its results, keys, rights on a mission, a replay, a silent mission."""
    axe = pytest.importorskip('axe_playwright_python.sync_playwright')
    stage, pilot, address = flight
    # Axe may look longer at the armed order than a person.
    monkeypatch.setattr(order_book, 'CONFIRM_S', 120.0)
    make_run(tmp_path / 'yard-1')
    view = View(browser, address, color_scheme=theme)
    page = view.page
    view.wait('document.querySelectorAll(".vehicle:not(.grey)").length === 3')
    faults = []

    def look(shown: str, selector: str) -> None:
        page.wait_for_selector(selector)
        faults.extend(faults_of_axe(axe, view, shown))

    page.focus('#map')
    page.check('#pick-rav1')
    page.evaluate('rocsafe.map.onPlace({ lat: 53.28, lng: -9.0633 })')
    look('place', '#place form')
    page.keyboard.press('h')
    look('armed', '.order-confirm')
    stage.crew.refusal = 'rav1: led by the pilot'
    page.keyboard.press('Enter')
    look('results', '.results li.bad')
    page.keyboard.press('?')
    look('help', '#help[open]')
    page.keyboard.press('Escape')
    page.click('[data-view="runs"]')
    page.locator('.run').get_by_role('button', name='People').click()
    look('access', '#access[open]')
    page.keyboard.press('Escape')
    page.locator('.run .run-buttons button').first.click()
    look('replay', '#replay input')
    page.click('[data-view="live"]')
    stage.silent = {'mission', 'fix', 'dose', 'detector'}
    look('old facts', '.mission-old .fact-worst .grey')
    pilot.stop()
    look('old vehicles', '.vehicle.grey')
    assert faults == []
    page.close()


@pytest.mark.parametrize('theme', ['light', 'dark'])
@pytest.mark.parametrize('size', SIZES)
def test_everybody_can_read_and_use_it(browser, flight, size, theme):
    """Axe finds nothing, with a contrast of 7 to 1; nothing is wider than the page."""
    axe = pytest.importorskip('axe_playwright_python.sync_playwright')
    _, _, address = flight
    view = View(browser, address, size, color_scheme=theme)
    view.wait('document.querySelectorAll(".vehicle:not(.grey)").length === 3')
    for shown in ('live', 'runs', 'draft', 'people'):
        if shown == 'people':
            view.page.click('#who')
            view.page.wait_for_selector('#people[open]')
        else:
            view.page.click(f'button[data-view="{shown}"]')
        if shown == 'draft':
            view.wait('document.querySelector("#draft-text")?.value.length > 100')
        assert faults_of_axe(axe, view, shown) == []
    width = view.page.evaluate('document.documentElement.scrollWidth')
    assert width <= SIZES[size][0]
    view.page.close()


def test_a_mission_is_drawn_planned_approved_and_launched_by_clicks(browser, tmp_path):
    """In at most 12 interactions; a stand-in of the command `rocsafe` tells what was asked."""
    stage = Stage(tmp_path)
    stage.begin()
    told = tmp_path / 'told'
    tools = tmp_path / 'bin'
    tools.mkdir()
    command = tools / 'rocsafe'
    plan = '{"type":"FeatureCollection","features":[]}'
    command.write_text(
        f'#!/bin/sh\necho "$@" >> {told}\n'
        f'if [ "$1" = plan ]; then mkdir -p "$4/x"; echo \'{plan}\' > "$4/x/plan.geojson"; '
        'echo "{}" > "$4/x/plan.json"; fi\necho "$1 is done"\n'
    )
    command.chmod(command.stat().st_mode | stat.S_IXUSR)
    stage.context.environment['PATH'] = f'{tools}:{stage.context.environment["PATH"]}'
    with served(stage) as address:
        view = View(browser, address)
        view.wait('document.querySelectorAll(".vehicle").length === 3')
        count = draw_and_launch(view)
        view.wait('document.documentElement.dataset.view === "live"')
        assert view.page.evaluate('document.activeElement.dataset.view') == 'live'
        # What is drawn anew has no plan yet, and nobody flies the former one.
        view.page.click('[data-view="draft"]')
        assert view.page.evaluate('Boolean(rocsafe.draft.plan)')
        view.page.click('#draft-add')
        assert not view.page.evaluate('Boolean(rocsafe.draft.plan)')
        # The name of a draft is checked by the browser, too.
        view.page.click('[data-view="draft"]')
        view.page.fill('#draft-name', 'no name')
        assert not view.page.eval_on_selector('#draft-name', 'input => input.checkValidity()')
    assert count <= 12
    words = [line.split()[0] for line in told.read_text().splitlines()]
    assert words == ['check', 'plan', 'run']
    scenario = (tmp_path / 'drafts' / 'mission.yaml').read_text()
    assert 'name: mission' in scenario
    assert not view.faults
    view.page.close()


def test_a_mistake_stands_beside_its_field(browser, tmp_path):
    """On the line of the text and in a list that leads there; a change of the text clears both."""
    stage = Stage(tmp_path)
    stage.begin()
    tools = tmp_path / 'bin'
    tools.mkdir()
    command = tools / 'rocsafe'
    words = 'rocsafe: mission.yaml: seed = abc: must be a number'
    command.write_text(f'#!/bin/sh\necho "{words}"\nexit 2\n')
    command.chmod(command.stat().st_mode | stat.S_IXUSR)
    stage.context.environment['PATH'] = f'{tools}:{stage.context.environment["PATH"]}'
    with served(stage) as address:
        view = View(browser, address)
        view.page.click('[data-view="draft"]')
        view.page.click('#draft summary')
        view.page.fill('#draft-text', 'name: x\nseed: abc\n')
        view.page.click('#draft-check')
        view.page.wait_for_selector('.draft-mark')
        assert 'must be a number' in view.page.inner_text('.draft-mark')
        mark = view.page.locator('.draft-mark').bounding_box()
        text = view.page.locator('#draft-text').bounding_box()
        assert 20 <= mark['y'] - text['y'] <= 40, 'beside the second line'
        view.page.click('.draft-faults button')
        chosen = 't => t.value.slice(t.selectionStart, t.selectionEnd)'
        assert view.page.eval_on_selector('#draft-text', chosen) == 'seed: abc'
        view.page.fill('#draft-text', 'name: x\nseed: [1\n')
        assert view.page.locator('.draft-mark').count() == 0
        view.page.click('#draft-check')
        view.page.wait_for_selector('.draft-mark')
        assert not [fault for fault in view.faults if '400' not in fault]
        view.page.close()


def test_a_region_is_drawn_and_evidence_marked_by_keys_alone(browser, tmp_path):
    """A place is typed, the map is moved by arrows, and Enter chooses its middle."""
    stage = Stage(tmp_path)
    with served(stage) as address:
        view = View(browser, address)
        view.wait('rocsafe.link.isLive')
        page = view.page
        page.keyboard.press('g')
        page.keyboard.type('29U MV 29125 03560')
        page.keyboard.press('Enter')
        page.wait_for_selector('#place form')
        assert page.evaluate('rocsafe.map.map.getZoom()') >= 17
        page.focus('#place form input')
        page.keyboard.type('a drum')
        page.keyboard.press('Enter')
        view.wait('rocsafe.link.sections.marks?.length === 1')
        page.keyboard.press('Escape')
        page.keyboard.press('3')
        view.wait('document.querySelector("#draft-text")?.value.length > 100')
        page.focus('#draw-region')
        page.keyboard.press('Enter')
        # The focus goes to the map by itself, and on to the next step.
        focus = 'document.activeElement.id'
        assert page.evaluate(focus) == 'map'
        for key in ('ArrowUp', 'ArrowRight', 'ArrowDown'):
            page.keyboard.press('Enter')
            before = page.evaluate('rocsafe.map.map.getCenter().toString()')
            page.keyboard.press(key)
            view.wait(f'rocsafe.map.map.getCenter().toString() !== "{before}"')
        page.keyboard.press('Enter')
        page.keyboard.press('Enter')
        assert '5 corners' in page.inner_text('#draft')
        page.keyboard.press('Backspace')
        page.keyboard.press('c')
        assert '4 corners' in page.inner_text('#draft')
        assert page.evaluate(focus) == 'draft-plan'
        assert not view.faults
        page.close()


def test_a_distance_is_measured_by_clicks_and_by_keys(browser, flight):
    """On the ellipsoid, within a thousandth; nothing is marked or ordered meanwhile."""
    stage, _, address = flight
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    place = ORIGIN

    def choose(east_m: float, north_m: float) -> None:
        other = LocalFrame(GeoPosition(*place, 0.0)).position_of((east_m, north_m, 0.0))
        box = view.page.evaluate(
            f'(() => {{ const p = rocsafe.map.map.latLngToContainerPoint('
            f'[{other.latitude_deg}, {other.longitude_deg}]); return [p.x, p.y]; }})()'
        )
        view.page.mouse.click(*(sum(pair) for pair in zip(box, corner, strict=True)))

    view.page.evaluate(f'rocsafe.map.map.setView([{place[0]}, {place[1]}], 18)')
    view.page.evaluate('rocsafe.map.isFitted = true')
    bounds = view.page.locator('#map').bounding_box()
    corner = (bounds['x'], bounds['y'])
    choose(0.0, 0.0)
    view.page.click('#measure')
    choose(60.0, 0.0)
    choose(60.0, 40.0)
    words = view.page.inner_text('#place').split('\n')
    numbers = [float(number) for line in words[:3] for number in re.findall(r'[\d.]+', line)[:2]]
    leg, bearing, length = numbers[0], numbers[1], numbers[2]
    assert (leg, bearing, length) == (
        pytest.approx(40.0, abs=0.6), pytest.approx(0.0, abs=2.0), pytest.approx(100.0, abs=1.0),
    )  # fmt: skip
    exact = LocalFrame(GeoPosition(*place, 0.0))
    far = exact.position_of((3000.0, 4000.0, 0.0))
    told = view.page.evaluate(
        f"""import('/static/measure.js').then(({{ distanceOf, bearingOf, areaOf }}) => [
            distanceOf([{place[0]}, {place[1]}], [{far.latitude_deg}, {far.longitude_deg}]),
            bearingOf([{place[0]}, {place[1]}], [{far.latitude_deg}, {far.longitude_deg}])])"""
    )
    assert told == [pytest.approx(5000.0, rel=1e-4), pytest.approx(36.87, abs=0.05)]
    view.page.keyboard.press('Backspace')
    assert 'bearing 090' in view.page.inner_text('#place')
    view.page.keyboard.press('Escape')
    assert view.page.locator('#place').is_hidden()
    view.page.keyboard.press('m')
    view.page.keyboard.press('Enter')
    view.page.keyboard.press('ArrowRight')
    # The map moves for a quarter of a second.
    view.wait('!rocsafe.map.map._panAnim?._inProgress')
    view.page.keyboard.press('Enter')
    assert 'bearing 090' in view.page.inner_text('#place')
    assert not stage.crew.sent
    assert not view.faults
    view.page.close()


def test_a_replay_shows_nothing_of_the_live_mission(browser, tmp_path, flight):
    """Neither its gas nor its maps; a draft is drawn only in its own view."""
    _, _, address = flight
    make_run(tmp_path / 'yard-1')
    view = View(browser, address)
    view.page.wait_for_selector('.image-plume')
    view.page.keyboard.press('3')
    view.page.wait_for_selector('.draft-fleet input')
    assert view.page.evaluate('rocsafe.map.map.hasLayer(rocsafe.draft.layer)')
    view.page.keyboard.press('2')
    assert not view.page.evaluate('rocsafe.map.map.hasLayer(rocsafe.draft.layer)')
    view.page.click('.run .run-buttons button')
    view.page.wait_for_selector('#replay input')
    for name in ('plume', 'dose', 'mosaic'):
        assert view.page.locator(f'.image-{name}').count() == 0
    assert not view.faults
    view.page.close()


def draw_and_launch(view: View) -> int:
    """Draw a region, plan, approve and launch; return the number of clicks."""
    page = view.page
    clicks = 0

    def click(selector: str) -> None:
        nonlocal clicks
        clicks += 1
        page.click(selector)

    click('[data-view="draft"]')
    page.wait_for_selector('#draft-text', state='attached')
    view.wait('document.querySelector("#draft-text").value.length > 100')
    click('#draw-region')
    for east, north in ((-90, -50), (90, -50), (90, 50), (-90, 50)):
        latitude, longitude = place_of(east, north)
        point = page.evaluate(f'rocsafe.map.map.latLngToContainerPoint([{latitude}, {longitude}])')
        page.click('#map', position={'x': point['x'], 'y': point['y']})
        clicks += 1
    click('#draw-done')
    click('#draft-plan')
    view.wait('!document.querySelector("#draft-approve").disabled')
    click('#draft-approve')
    click('#draft-launch')
    return clicks


def test_a_finished_run_is_replayed(browser, tmp_path, flight):
    """Its tracks follow the slider; back to live, the mission is there."""
    _, _, address = flight
    make_run(tmp_path / 'yard-1')
    view = View(browser, address)
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    view.page.keyboard.press('2')
    view.page.click('.run .run-buttons button')
    view.page.wait_for_selector('#replay input')
    length = 'rocsafe.map.tracks.get("rav1").length'
    assert view.page.evaluate(length) == 40
    # What people ordered stands where it was done, and nobody is named twice.
    told = view.page.inner_text('.decisions')
    assert 'anna Hold: 1 of 1 done (rav1)' in told.splitlines()[0]
    assert 'rav1 rav1' not in told
    view.page.locator('#replay input').fill('9')
    assert view.page.evaluate(length) == 10
    assert 'Hold' not in view.page.inner_text('.decisions')
    view.page.click('#replay button:last-child')
    view.wait('rocsafe.map.source === null')
    assert not view.faults
    view.page.close()


def test_a_mission_gets_its_commander_and_list_by_clicks(browser, tmp_path, flight):
    """A replay never looks live, and says that orders go to the live mission."""
    stage, _, address = flight
    make_run(tmp_path / 'yard-1')
    view = View(browser, address)
    page = view.page
    view.wait('document.querySelectorAll(".vehicle").length === 3')
    view.wait('rocsafe.link.sections.contacts.rav1.hears.join() === "rav2,rav3"')
    page.keyboard.press('2')
    page.locator('.run').get_by_role('button', name='People').click()
    page.get_by_role('button', name='Take command').click()
    page.select_option('#access-visibility', 'named')
    page.fill('#access-members', 'bert, cora')
    page.get_by_role('button', name='Save').click()
    view.wait('document.querySelector(".run .note").textContent.includes("list: bert, cora")')
    access = stage.context.missions.of('yard-1')
    assert (access.commander, access.visibility) == ('anna', 'named')
    assert access.members == ('bert', 'cora')
    page.locator('.run .run-buttons button').first.click()
    page.wait_for_selector('#replay-mark:visible')
    assert 'not live' in page.inner_text('#replay-mark')
    assert 'Live mission' in page.inner_text('.order-for')
    page.click('#replay button:last-child')
    view.wait('document.querySelector("#replay-mark").hidden')
    assert 'Live mission' not in page.inner_text('.order-for')
    assert not view.faults
    page.close()


def make_run(run: Path) -> None:
    """Make a folder with what a replay needs."""
    run.mkdir()
    (run / 'scenario.yaml').write_text('name: yard\n')
    rows = ['time_ns,vehicle,latitude_deg,longitude_deg,dose_rate_usvh']
    for second in range(40):
        latitude, longitude = place_of(second, 0.0)
        rows.append(f'{second * 10**9},rav1,{latitude},{longitude},{0.1 + second}')
    (run / 'readings.csv').write_text('\n'.join(rows) + '\n')
    state = {'header': {'stamp': {'sec': 12, 'nanosec': 0}}, 'state': 5}
    done = [{'vehicle': 'rav1', 'outcome': 'done', 'text': ''}]
    log = (
        {'kind': 'order', 'by': 'anna', 'request_id': 'a1', 'verb': 'hold', 'time_s': 1.8e9},
        {'kind': 'state', 'by': 'rav1', 'message': state, 'time_s': 1.8e9},
        {'kind': 'outcome', 'by': 'anna', 'request_id': 'a1', 'results': done, 'time_s': 1.8e9},
    )
    (run / 'evidence.jsonl').write_text(''.join(json.dumps(one) + '\n' for one in log))
