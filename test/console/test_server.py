# SPDX-License-Identifier: Apache-2.0
"""The server refuses what does not come from its page and from somebody who may."""

import asyncio
import fcntl
import json
import secrets
import threading
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import pytest
from test.console.caller import FORGED, Caller, revisions_of
from test.console.forger import Forger, forge
from test.console.stage import TOKEN, Stage, served
from test.console.test_hostile_clients import frames_read

from rocsafe_console.errors import ConsoleError
from rocsafe_console.orders.order_book import TARGETS
from rocsafe_console.people.missions import SAFE, Access
from rocsafe_console.people.passwords import hash_of
from rocsafe_console.people.roles import MAY, VERBS, Action, Role
from rocsafe_console.people.sessions import MOST_SESSIONS
from rocsafe_console.people.users import User, Users, write_users
from rocsafe_console.runs.drafts import Drafts, Step
from rocsafe_console.runs.jobs import KINDS, Jobs
from rocsafe_console.runs.launches import Launch, Launches
from rocsafe_console.web import context as context_module
from rocsafe_console.web import order_handlers
from rocsafe_console.web.context import ORDERS, REFUSALS, REFUSALS_S, WebOptions
from rocsafe_console.web.server import ServerThread, require_safe
from rocsafe_geo.evidence.evidence_log import checked

PASSWORD = 'correct horse battery'  # noqa: S105 - of a test
LAYERS = (
    'Content-Security-Policy',
    'X-Content-Type-Options',
    'Referrer-Policy',
    'X-Frame-Options',
)


@pytest.fixture
def stage(tmp_path) -> Stage:
    """Return a mission of three vehicles."""
    stage = Stage(tmp_path)
    stage.begin()
    return stage


@pytest.fixture
def caller(stage) -> Iterator[Caller]:
    """Return somebody who has the token."""
    with served(stage) as address:
        caller = Caller(address)
        assert caller.ask('/api/token', {'token': TOKEN})[0] == 200
        yield caller


def test_an_order_is_written_down_and_sent_and_answered(stage, caller, tmp_path):
    """In this order; the log has who, what and what became of it."""
    status, answer = caller.order('hold', revisions_of(stage))
    assert status == 200
    assert [one['outcome'] for one in answer['results']] == ['done'] * 3
    order, names = stage.crew.sent[0]
    assert (order.verb, sorted(names)) == (Action.HOLD, stage.names)
    entries = checked((tmp_path / 'console.jsonl').read_bytes().split(b'\n')[:-1])
    assert [(entry['kind'], entry['by']) for entry in entries] == [
        ('login', 'anna'), ('order', 'anna'), ('outcome', 'anna'),
    ]  # fmt: skip


def test_an_order_that_cannot_be_written_down_is_not_sent(stage, caller, monkeypatch):
    """A full disk: nothing flies without a line in the log, but what ends a flight."""

    def full(*_: object) -> None:
        raise OSError(28, 'No space left on device')

    monkeypatch.setattr(stage.context.desk, 'write', full)
    for verb in sorted(verb.value for verb in VERBS - SAFE - TARGETS.keys()):
        status, answer = caller.order(verb, revisions_of(stage))
        assert status == 403
        assert 'nothing was sent' in answer['error']
    assert not stage.crew.sent


@pytest.mark.slow
@pytest.mark.parametrize('verb', ['hold', 'return', 'land'])
@pytest.mark.parametrize('disk', ['full', 'hangs', 'log damaged', 'log gone'])
def test_no_trouble_with_the_log_holds_up_an_emergency(
    stage, caller, monkeypatch, tmp_path, verb, disk
):
    """It is sent, and the page says that it is in no log; a damaged log goes on beside itself."""
    monkeypatch.setattr(context_module, 'LOG_S', 0.3)
    path, done = tmp_path / 'console.jsonl', threading.Event()
    write = stage.context.desk.write

    def troubled(*event: object) -> None:
        if disk == 'full':
            raise OSError(28, 'No space left on device')
        done.wait(20.0)
        write(*event)

    if disk == 'log damaged':
        path.write_bytes(path.read_bytes().replace(b'anna', b'bert'))
        # As a console that is started again reads it.
        stage.context.desk.close()
    elif disk == 'log gone':
        path.unlink()
    else:
        monkeypatch.setattr(stage.context.desk, 'write', troubled)
    begun_s = time.monotonic()
    status, answer = caller.order(verb, revisions_of(stage))
    assert time.monotonic() - begun_s < 5.0
    assert (status, [one['outcome'] for one in answer['results']]) == (200, ['done'] * 3)
    assert len(stage.crew.sent) == 1
    done.set()
    if disk in ('full', 'hangs'):
        assert answer['unlogged']
        return
    assert 'unlogged' not in answer
    log = tmp_path / 'console-0002.jsonl'
    entries = checked(log.read_bytes().split(b'\n')[:-1])
    assert [entry['kind'] for entry in entries] == ['damaged', 'order', 'outcome']
    assert 'evidence log damaged' in str(stage.context.live.picture.sections.value('alarms'))


def test_what_was_done_is_told_though_its_outcome_cannot_be_written_down(
    stage, caller, monkeypatch
):
    """The disk is full since the order was written: nobody must think that nothing was sent."""
    write, left = stage.context.desk.write, iter(range(1))

    def fuller(*event: object) -> None:
        if next(left, None) is None:
            raise OSError(28, 'No space left on device', 'evidence.jsonl')
        write(*event)

    monkeypatch.setattr(stage.context.desk, 'write', fuller)
    status, answer = caller.order('hold', revisions_of(stage))
    assert (status, [one['outcome'] for one in answer['results']]) == (200, ['done'] * 3)
    assert 'No space left' in answer['unlogged']


@pytest.mark.parametrize('gone', ['no ROS', 'no answer'])
def test_an_order_that_is_not_answered_has_an_outcome(stage, caller, tmp_path, monkeypatch, gone):
    """For the operator, for whoever asks again, and in the log."""
    if gone == 'no ROS':
        stage.context.fleet = None
    else:
        monkeypatch.setattr(order_handlers, 'ORDER_S', 0.2)
        monkeypatch.setattr(stage.crew, 'send_order', lambda *_: None)
    body = {'request_id': 'a' * 32, 'verb': 'land', 'revisions': revisions_of(stage)}
    assert caller.ask('/api/orders', body)[0] == 201
    answers = [caller.ask(f'/api/orders/{"a" * 32}/confirm', {}) for _ in range(2)]
    assert answers[0] == answers[1]
    status, answer = answers[0]
    outcome = 'refused' if gone == 'no ROS' else 'no answer'
    assert (status, {one['outcome'] for one in answer['results']}) == (200, {outcome})
    entries = checked((tmp_path / 'console.jsonl').read_bytes().split(b'\n')[:-1])
    assert [entry['kind'] for entry in entries] == ['login', 'order', 'outcome']


def test_a_slow_disk_holds_up_no_picture(stage, caller, monkeypatch):
    """Frames reach a page while an order waits for its line in the log."""
    write, begun, done = stage.context.desk.write, threading.Event(), threading.Event()

    def slow(*event: object) -> None:
        begun.set()
        done.wait(20.0)
        write(*event)

    monkeypatch.setattr(stage.context.desk, 'write', slow)
    with ThreadPoolExecutor(1) as pool:
        order = pool.submit(caller.order, 'resume', revisions_of(stage))
        try:
            assert begun.wait(20.0)
            assert asyncio.run(frames_read(caller, stage.step, 5)) == 5
            assert not stage.crew.sent
            stage.state['rav2'] = 6
            stage.step()
        finally:
            done.set()
        outcomes = {one['vehicle']: one['outcome'] for one in order.result()[1]['results']}
    # What has moved on meanwhile gets no order either.
    assert outcomes == {'rav1': 'done', 'rav2': 'state has changed', 'rav3': 'done'}


def test_nothing_is_seen_or_marked_that_cannot_be_written_down(stage, caller, monkeypatch):
    """A full disk is told in one line, and an alarm stays open."""

    def full(*_: object) -> None:
        raise OSError(28, 'No space left on device', 'evidence.jsonl')

    alarm = stage.context.live.picture.alarm(1.0, 'critical', '', 'fire')
    monkeypatch.setattr(stage.context.desk, 'write', full)
    mark = {'latitude_deg': 1.0, 'longitude_deg': 1.0, 'text': 'drum'}
    for path, body in ((f'/api/alarms/{alarm.number}/acknowledge', {}), ('/api/marks', mark)):
        status, answer = caller.ask(path, body)
        assert (status, 'No space left on device' in answer['error']) == (503, True)
    assert not stage.context.live.picture.alarms.of(alarm.number).seen_by
    assert not stage.context.live.picture.sections.value('marks')


@pytest.mark.slow
def test_nobody_ends_the_sessions_of_others_by_his_own(tmp_path, people):
    """Not by links either, and not faster than a person."""
    stage = Stage(tmp_path, users=people)
    sessions = stage.context.sessions
    kept = sessions.begin('commander', Role.COMMANDER, '', 0.0)[1]
    for is_link in (True, False):
        for _ in range(MOST_SESSIONS):
            newest = sessions.begin('viewer', Role.VIEWER, '', 0.0, is_link=is_link)[1]
    assert sessions.is_alive(kept, 1.0)
    assert sessions.is_alive(newest, 1.0)
    with served(stage) as address:
        caller = Caller(address)
        body = {'name': 'viewer', 'password': PASSWORD}
        assert caller.ask('/api/login', body)[0] == 200
        statuses = [caller.ask('/api/links', {})[0] for _ in range(ORDERS + 1)]
    assert statuses == [200] * ORDERS + [429]


def test_a_vehicle_that_has_moved_on_gets_no_order(stage, caller):
    """The others do, and the answer tells it."""
    seen = revisions_of(stage)
    stage.state['rav2'] = 6
    stage.step()
    _, answer = caller.order('resume', seen)
    outcomes = {one['vehicle']: one['outcome'] for one in answer['results']}
    assert outcomes == {'rav1': 'done', 'rav2': 'state has changed', 'rav3': 'done'}
    assert sorted(stage.crew.sent[0][1]) == ['rav1', 'rav3']


def test_one_vehicle_that_has_moved_on_stops_a_new_plan_for_all(stage, caller):
    """The operator decided on a picture of the whole fleet that is no longer true."""
    seen = revisions_of(stage)
    stage.state['rav2'] = 6
    stage.step()
    _, answer = caller.order('replan', seen)
    assert [one['outcome'] for one in answer['results']] == ['state has changed'] * 3
    assert not stage.crew.sent


def test_a_drive_is_offered_before_it_is_confirmed(stage, caller):
    """With its time and dose; where there is no way, that is said and nothing can be confirmed."""
    target = {'latitude_deg': 53.2801, 'longitude_deg': -9.0633, 'dose_budget_usv': 100.0}
    body = {'verb': 'send', 'revisions': {'rav1': revisions_of(stage)['rav1']}, 'target': target}
    status, offer = caller.ask('/api/orders', {**body, 'request_id': 'a' * 32})
    assert (status, offer['drive']['dose_upper_usv']) == (201, 61.0)
    assert not stage.crew.sent
    assert caller.ask(f'/api/orders/{"a" * 32}/confirm', {})[0] == 200
    assert [order.verb for order, _ in stage.crew.sent] == [Action.SEND]
    stage.crew.refusal = 'router: nothing drivable leads there'
    status, answer = caller.ask('/api/orders', {**body, 'request_id': 'b' * 32})
    assert (status, answer['error']) == (403, stage.crew.refusal)
    assert caller.ask(f'/api/orders/{"b" * 32}/confirm', {})[0] == 403
    assert len(stage.crew.sent) == 1


@pytest.mark.parametrize(
    ('verb', 'target', 'words'),
    [
        ('send', None, 'target'),
        ('send', {'latitude_deg': 53.0, 'longitude_deg': -9.0, 'dose_budget_usv': 0.0}, 'above 0'),
        ('send', {'latitude_deg': 99.0, 'longitude_deg': 0.0, 'dose_budget_usv': 9.0}, 'on the'),
        ('hold', {'latitude_deg': 53.0, 'longitude_deg': -9.0, 'height_m': 50.0}, 'has none'),
        ('send', {'latitude_deg': 53.0, 'longitude_deg': -9.0, 'height_m': 50.0}, 'height_m'),
    ],
)
def test_a_target_that_does_not_fit_its_order_is_refused(stage, caller, verb, target, words):
    """In one line that names it."""
    more = {'target': target} if target else {}
    body = {'request_id': 'c' * 32, 'verb': verb, 'revisions': {'rav1': 1000}, **more}
    status, answer = caller.ask('/api/orders', body)
    assert status == 400
    assert words in answer['error']


def test_a_confirmation_that_is_sent_twice_sends_the_order_once(stage, caller):
    """And is answered the same."""
    request_id = secrets.token_hex(16)
    body = {'request_id': request_id, 'verb': 'land', 'revisions': revisions_of(stage)}
    caller.ask('/api/orders', body)
    first = caller.ask(f'/api/orders/{request_id}/confirm', {})
    assert caller.ask(f'/api/orders/{request_id}/confirm', {}) == first
    assert len(stage.crew.sent) == 1


@pytest.mark.parametrize('headers', FORGED, ids=lambda headers: str(headers))
def test_a_request_that_is_not_of_the_page_is_refused(stage, caller, headers):
    """Another origin or host, a form, or nobody's session: orders and alarms alike."""
    body = {'request_id': 'a' * 32, 'verb': 'hold', 'revisions': revisions_of(stage)}
    for path in ('/api/orders', '/api/alarms/1/acknowledge', '/api/marks'):
        assert caller.ask(path, body, **headers)[0] in (401, 403, 415, 421)
    assert not stage.crew.sent


@pytest.mark.slow
def test_no_forged_or_replayed_request_is_obeyed(stage, caller):
    """Wrong origin, host, form, cookie, id or method, told again, or broken: nothing is sent."""
    request_id = 'f' * 32
    order = {'request_id': request_id, 'verb': 'hold', 'revisions': revisions_of(stage)}
    assert caller.ask('/api/orders', order)[0] == 201
    assert caller.ask(f'/api/orders/{request_id}/confirm', {})[0] == 200
    forger = Forger(caller.address, caller.cookie, revisions_of(stage), request_id)
    statuses = asyncio.run(forge(forger, caller.address, 600))
    assert sum(statuses.values()) == 600
    # A confirmation that is told again is answered with what became of it.
    assert statuses.keys() <= {200, 201, 400, 401, 403, 404, 405, 415, 421, 429}
    assert len(stage.crew.sent) == 1


def test_what_is_not_json_is_refused_in_one_line(caller):
    """No traceback, and the server goes on."""
    for body in (
        b'',
        b'{',
        b'[1]',
        b'{"verb": "fly"}',
        b'\xff',
        b'{"request_id": 1, "verb": "hold"}',
        b'{"request_id": "%s", "verb": "hold", "revisions": {"rav1": 1e999}}' % (b'a' * 32),
        b'{"a":' * 100_000,
        b'[' * 200_000,
    ):
        status, answer = caller.ask('/api/orders', body)
        assert status == 400
        assert answer['error']
    assert caller.ask('/api/orders', b'x' * 2**21)[0] == 413
    assert caller.ask('/api/hello')[0] == 200


@pytest.mark.parametrize('path', ['/', '/static/main.js', '/api/hello', '/nothing', '/api/runs'])
def test_every_answer_has_its_guards(caller, path):
    """Also those that refuse."""
    caller.ask(path)
    for name in LAYERS:
        assert caller.headers[name], name
    assert "default-src 'self'" in caller.headers['Content-Security-Policy']
    assert 'unsafe' not in caller.headers['Content-Security-Policy']


@pytest.mark.parametrize(
    'path',
    [
        '/static/../console_command.py',
        '/static/%2e%2e/errors.py',
        '/static/py.typed',
        '/static//etc/passwd',
        '/api/runs/..%2f..%2fetc/files/passwd',
        '/api/runs/x/replay',
        '/api/photograph/..%2f..%2fetc%2fpasswd',
    ],
)
def test_no_other_file_is_served(caller, path):
    """Neither by dots nor by names that are not for the page."""
    assert caller.ask(path)[0] in (403, 404)


def test_a_run_is_verified_and_sealed_on_the_page(stage, caller, tmp_path):
    """A change is told by its file; a mission that flies is not sealed before its end."""
    run = tmp_path / 'yard-1'
    run.mkdir()
    (run / 'scenario.yaml').write_text('name: yard\n')
    assert caller.ask('/api/runs/yard-1/verify')[1]['faults'] == [f'{run} is not sealed']
    stage.context.environment['XDG_CONFIG_HOME'] = str(tmp_path / 'config')
    with (run / 'run.lock').open('wb') as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        status, answer = caller.ask('/api/runs/yard-1/seal', {})
        assert (status, 'has not ended' in answer['error']) == (403, True)
    assert caller.ask('/api/runs/yard-1/seal', {})[1] == {'seal': 'seal-0001.json', 'signer': ''}
    assert caller.ask('/api/runs/yard-1/verify')[1]['faults'] == []
    (run / 'scenario.yaml').write_text('name: yarn\n')
    found = caller.ask('/api/runs/yard-1/verify')[1]
    assert found['faults'] == ['scenario.yaml: has been changed']


def test_a_place_that_is_typed_is_found(caller):
    """In any form; what is none is refused in one line."""
    assert caller.ask('/api/coordinates?text=53.28%20-9.0633')[1]['place'] == [53.28, -9.0633]
    assert caller.ask('/api/coordinates?text=here')[0] == 400


@pytest.fixture(scope='module')
def people() -> dict[str, User]:
    """Return one user a role."""
    hashed = hash_of(PASSWORD)
    return {role.value: User(name=role.value, role=role, password_hash=hashed) for role in Role}


@pytest.mark.slow
@pytest.mark.parametrize('role', Role)
def test_the_table_of_roles_holds_at_the_server(tmp_path, people, role):
    """Every action by its request: refused with 403 exactly where the role may not."""
    stage = Stage(tmp_path, users=people)
    stage.begin()
    place = {'latitude_deg': 53.0, 'longitude_deg': -9.0, 'text': 'a bag'}
    with served(stage) as address:
        caller = Caller(address)
        assert caller.ask('/api/login', {'name': role.value, 'password': PASSWORD})[0] == 200
        on_earth = {'latitude_deg': 53.0, 'longitude_deg': -9.0}
        targets = {
            Action.GO_TO: {**on_earth, 'height_m': 50.0},
            Action.SEND: {**on_earth, 'dose_budget_usv': 100.0},
        }
        tried = {
            Action.SEE: lambda: caller.ask('/api/runs'),
            Action.ACKNOWLEDGE: lambda: caller.ask('/api/alarms/99/acknowledge', {}),
            Action.MARK: lambda: caller.ask('/api/marks', place),
            Action.REVOKE: lambda: caller.ask('/api/sessions'),
            Action.DRAFT: lambda: caller.ask('/api/drafts'),
            Action.LAUNCH: lambda: caller.ask('/api/drafts/yard/launch', {'approved': 'x'}),
            Action.END: lambda: caller.ask('/api/missions/yard/end', {}),
            Action.SEAL: lambda: caller.ask('/api/runs/yard/seal', {}),
            Action.ASSIGN: lambda: caller.ask('/api/runs/yard/access', {}),
            Action.RESUME_RUN: lambda: caller.ask('/api/jobs/resume/yard', {}),
            Action.REMAKE: lambda: caller.ask('/api/jobs/report/yard', {}),
            Action.CLEAR: lambda: caller.ask('/api/jobs/clear/a.b', {}),
        }
        for verb in VERBS:
            more = {'target': targets[verb]} if verb in targets else {}
            revisions = {'rav1': revisions_of(stage)['rav1']}
            tried[verb] = lambda verb=verb, more=more, revisions=revisions: caller.order(
                verb.value, revisions, **more
            )
        assert tried.keys() == set(Action)
        for action, attempt in tried.items():
            status, answer = attempt()
            is_refused = status == 403 and f'the role {role.value} may not' in answer['error']
            assert is_refused == (action not in MAY[role]), action
        assert {order.verb for order, _ in stage.crew.sent} == VERBS & MAY[role]


@pytest.mark.parametrize('path', ['/api/drafts/yard/launch', '/api/jobs/campaign/yard'])
def test_the_page_of_one_mission_launches_no_other(stage, caller, path, monkeypatch):
    """It would fly unseen: a mission's own page hears that mission alone."""
    monkeypatch.setitem(KINDS, 'campaign', replace(KINDS['campaign'], words=lambda *_: ('x',)))
    monkeypatch.setattr(Jobs, 'begin', lambda *_: Launch(state='running', text=''))
    monkeypatch.setattr(Drafts, 'launch', lambda *_: Launch(state='running', text=''))
    assert caller.ask(path, {})[0] == 200
    stage.context.environment = {**stage.context.environment, 'ROCSAFE_MISSION_TOKEN': 'x'}
    status, answer = caller.ask(path, {})
    assert (status, 'belongs to one mission' in answer['error']) == (403, True)


def test_what_a_role_is_refused_is_logged_and_fills_no_disk(tmp_path, people):
    """With user, time, what was asked for and why not; a client that goes on has one line more."""
    now = [time.time()]
    stage = Stage(tmp_path, users=people)
    stage.begin()
    stage.context.clock = lambda: now[0]
    with served(stage) as address:
        caller = Caller(address)
        assert caller.ask('/api/login', {'name': 'viewer', 'password': PASSWORD})[0] == 200
        seen = {**revisions_of(stage), 'x' * 100_000: 0}
        for _ in range(REFUSALS + 25):
            assert caller.order('land', seen)[0] == 403
        assert caller.ask('/api/marks', {})[0] == 403
        now[0] += REFUSALS_S
        assert caller.ask('/api/missions/yard/end', {})[0] == 403
    entries = checked((tmp_path / 'console.jsonl').read_bytes().split(b'\n')[:-1])
    refused = [entry for entry in entries if entry['kind'] == 'refused']
    assert len(refused) == REFUSALS + 1
    first, last = refused[0], refused[-1]
    assert (first['by'], first['outcome'], first['refused_before']) == ('viewer', 'refused', 0)
    assert first['asked'] == {'verb': 'land', 'vehicles': stage.names}
    assert first['why'] == 'the role viewer may not land'
    assert (last['path'], last['refused_before']) == ('/api/missions/yard/end', 26)
    assert not stage.crew.sent
    assert (tmp_path / 'console.jsonl').stat().st_size < 1000 * (REFUSALS + 2)


@pytest.mark.slow
@pytest.mark.parametrize('run', ['yard-1', ''], ids=['run known', 'run not known yet'])
@pytest.mark.parametrize('visibility', ['everybody', 'named'])
@pytest.mark.parametrize('members', [[], ['operator']])
def test_only_its_commander_ends_a_mission(
    tmp_path, people, monkeypatch, run, visibility, members
):
    """Whatever mission is heard beside it, and whoever commands that one: all users, both ways."""
    others = {'other': replace(people['commander'], name='other')}
    stage = Stage(tmp_path, users={**people, **others})
    stage.begin()
    missions = stage.context.missions
    rights = {'visibility': visibility, 'members': tuple(members)}
    missions.put('yard-1', Access(commander='commander', **rights))
    missions.put(stage.context.mission, Access(commander='other'))
    ended = []
    monkeypatch.setattr(Launches, 'run_of', lambda *_: run)
    monkeypatch.setattr(Launches, 'user_of', lambda *_: 'commander')
    monkeypatch.setattr(Launches, 'end', lambda _self, name: ended.append(name))
    with served(stage) as address:
        for user in (*people, 'other'):
            caller = Caller(address)
            assert caller.ask('/api/login', {'name': user, 'password': PASSWORD})[0] == 200
            status, _ = caller.ask('/api/missions/yard/end', {})
            assert (status, ended) == ((200, ['yard']) if user == 'commander' else (403, [])), user
            ended.clear()
            sees = caller.ask('/api/missions/yard')[0] == 200
            is_hidden = run and visibility == 'named' and user == 'operator' and not members
            assert sees == (user != 'viewer' and not is_hidden), user
        # Who takes the command may end it.
        if run:
            missions.put('yard-1', Access(commander='other', **rights))
            assert caller.ask('/api/missions/yard/end', {})[0] == 200


@pytest.fixture
def open_mission(tmp_path, people):
    """Serve a mission that is commanded by nobody and seen by everybody; gives callers by role."""
    stage = Stage(tmp_path, users=people)
    stage.begin()
    run = tmp_path / stage.context.mission
    run.mkdir()
    (run / 'scenario.yaml').write_text('name: yard')
    stage.context.desk.on_mission(run.name)
    with served(stage) as address:
        callers = {role.value: Caller(address) for role in Role}
        for name, caller in callers.items():
            assert caller.ask('/api/login', {'name': name, 'password': PASSWORD})[0] == 200
        yield stage, run, callers


@pytest.mark.slow
def test_a_mission_is_seen_and_commanded_by_those_who_are_named(open_mission):
    """Whoever is not on its list sees no run, picture or report, and commands nothing."""
    stage, run, callers = open_mission
    named = {'commander': 'commander', 'visibility': 'named', 'members': ['operator']}
    path = f'/api/runs/{run.name}/access'
    assert callers['commander'].ask(path, {**named, 'members': ['nobody']})[0] == 400
    assert callers['commander'].ask(path, named)[0] == 200
    viewer = callers['viewer']
    assert viewer.ask('/api/runs')[1]['runs'] == []
    assert callers['operator'].ask('/api/runs')[1]['runs'][0]['commander'] == 'commander'
    for hidden in (
        f'/api/runs/{run.name}/replay',
        f'/api/runs/{run.name}/verify',
        f'/api/runs/{run.name}/files/scenario.yaml',
        '/api/image/dose_map',
        '/api/photograph/x',
        '/api/video/rav1',
    ):
        status, answer = viewer.ask(hidden)
        assert (status, 'not on the list' in answer['error']) == (403, True), hidden
    assert callers['operator'].order('take', revisions_of(stage))[0] == 200
    others = {**named, 'commander': 'operator', 'members': []}
    assert callers['commander'].ask(path, others)[0] == 200
    status, answer = callers['commander'].order('replan', revisions_of(stage))
    assert (status, 'commanded by operator' in answer['error']) == (403, True)
    log = [json.loads(line) for line in (run / 'evidence.jsonl').read_text().splitlines()]
    assert [e['members'] for e in log if e['kind'] == 'assign'] == [['operator'], []]


@pytest.mark.slow
def test_a_link_for_other_programs_opens_nothing_else(open_mission):
    """Its secret is no cookie, a cookie is no link, and the list of a mission holds for it."""
    _, run, callers = open_mission
    viewer = callers['viewer']
    url = viewer.ask('/api/links', {})[1]['url']
    secret = url.rsplit('/', 1)[1]
    items = f'/ogc/{secret}/collections/vehicles/items'
    assert viewer.ask(items)[0] == 200
    name, _, own = viewer.cookie.partition('=')
    assert viewer.ask('/api/runs', Cookie=f'{name}={secret}')[0] == 401
    assert viewer.ask(f'/ogc/{own}/collections')[0] == 401
    named = {'commander': 'commander', 'visibility': 'named', 'members': []}
    assert callers['commander'].ask(f'/api/runs/{run.name}/access', named)[0] == 200
    assert viewer.ask(items)[0] == 403


@pytest.mark.slow
@pytest.mark.parametrize('disk', ['full', 'hangs'])
def test_no_trouble_with_the_log_keeps_anybody_out_or_in(tmp_path, people, monkeypatch, disk):
    """Who must hold a vehicle can log in, a session can be ended; an alarm tells what is lost."""
    monkeypatch.setattr(context_module, 'LOG_S', 0.3)
    stage, done = Stage(tmp_path, users=people), threading.Event()
    stage.begin()

    def troubled(*_: object) -> None:
        done.wait(20.0 if disk == 'hangs' else 0.0)
        raise OSError(28, 'No space left on device', 'evidence.jsonl')

    monkeypatch.setattr(stage.context.desk, 'write', troubled)
    with served(stage) as address:
        operator, commander = Caller(address), Caller(address)
        for caller, name in ((operator, 'operator'), (commander, 'commander')):
            body = {'name': name, 'password': 'wrong'}
            assert caller.ask('/api/login', body)[0] == 401
            assert caller.ask('/api/login', {**body, 'password': PASSWORD})[0] == 200
        told = stage.context.live.picture.sections.value('alarms')
        assert any('login of operator is in no evidence log' in one['text'] for one in told)
        status, answer = operator.order('hold', revisions_of(stage))
        assert (status, [one['outcome'] for one in answer['results']]) == (200, ['done'] * 3)
        assert answer['unlogged']
        sessions = commander.ask('/api/sessions')[1]['sessions']
        other = next(one['public_id'] for one in sessions if one['user'] == 'operator')
        assert commander.ask(f'/api/sessions/{other}/revoke', {})[0] == 200
        assert operator.ask('/api/runs')[0] == 401
        assert commander.ask('/api/logout', {})[0] == 200
        done.set()


@pytest.mark.slow
def test_passwords_cannot_be_tried_out(tmp_path, people):
    """After five attempts a minute must pass, also for the right password."""
    stage = Stage(tmp_path, users=people)
    with served(stage) as address:
        caller = Caller(address)
        body = {'name': 'viewer', 'password': 'wrong'}
        statuses = [caller.ask('/api/login', body)[0] for _ in range(6)]
        assert statuses == [401] * 5 + [429]
        assert caller.ask('/api/login', {**body, 'password': PASSWORD})[0] == 429
        assert caller.ask('/api/token', {'token': ''})[0] in (401, 429)


@pytest.mark.slow
def test_a_session_that_is_revoked_may_nothing_more(tmp_path, people):
    """By a commander; its cookie is for this server only."""
    stage = Stage(tmp_path, users=people)
    with served(stage) as address:
        viewer, commander = Caller(address), Caller(address)
        viewer.ask('/api/login', {'name': 'viewer', 'password': PASSWORD})
        for flag in ('HttpOnly', 'SameSite=Strict', 'Path=/'):
            assert flag in viewer.set_cookie
        commander.ask('/api/login', {'name': 'commander', 'password': PASSWORD})
        listed = commander.ask('/api/sessions')[1]['sessions']
        public_id = next(one['public_id'] for one in listed if one['user'] == 'viewer')
        assert public_id not in viewer.cookie
        assert viewer.ask('/api/runs')[0] == 200
        assert commander.ask(f'/api/sessions/{public_id}/revoke', {})[0] == 200
        assert viewer.ask('/api/runs')[0] == 401


def test_whoever_plans_keeps_nobody_else_waiting(caller, monkeypatch):
    """Plans that take long leave the threads by which others log in and look at runs."""
    done, asked = threading.Event(), []

    def preflight(*_: object) -> Step:
        asked.append(1)
        done.wait(20.0)
        return Step(is_done=True, text='')

    monkeypatch.setattr(Drafts, 'preflight', preflight)
    with ThreadPoolExecutor(16) as pool:
        plans = [pool.submit(caller.ask, '/api/drafts/m/preflight', {}) for _ in range(16)]
        while not asked:
            time.sleep(0.01)
        try:
            other = Caller(caller.address)
            other.ask('/api/token', {'token': TOKEN})
            began_s = time.monotonic()
            assert other.ask('/api/runs')[0] == 200
            assert time.monotonic() - began_s < 5.0
        finally:
            done.set()
        assert [plan.result()[0] for plan in plans] == [200] * 16


@pytest.mark.slow
def test_a_user_who_was_removed_may_nothing_more(tmp_path, people):
    """Nor one who has another password: the console reads the changed file, and his page ends."""
    path = tmp_path / 'users.yaml'
    write_users(path, people)
    stage = Stage(tmp_path, users=people)
    stage.context.users = Users(people, path)
    with served(stage) as address:
        callers = {name: Caller(address) for name in people}
        for name, caller in callers.items():
            assert caller.ask('/api/login', {'name': name, 'password': PASSWORD})[0] == 200
        url = callers['viewer'].ask('/api/links', {})[1]['url'].removeprefix(address[:-1])
        commander = people['commander']
        write_users(
            path, {'commander': commander, 'operator': replace(commander, name='operator')}
        )
        statuses = {name: caller.ask('/api/runs')[0] for name, caller in callers.items()}
        assert statuses == {'viewer': 401, 'operator': 401, 'commander': 200}
        assert callers['viewer'].ask(url)[0] == 401
        path.write_text('users: {')
        assert callers['commander'].ask('/api/runs')[0] == 200


def test_a_wrong_certificate_is_told_in_one_line_and_no_password_is_asked_for(tmp_path):
    """By its name, before the page is served."""
    stage, path = Stage(tmp_path), tmp_path / 'c.pem'
    path.write_text('no certificate')
    stage.context.options = replace(stage.context.options, certificate=path, key=path)
    with pytest.raises(ConsoleError, match=r'c\.pem: cannot be used'):
        ServerThread(stage.context, print)


def test_an_address_of_ipv6_can_be_opened(tmp_path):
    """It is printed as a browser takes it."""
    stage = Stage(tmp_path)
    stage.context.options = replace(stage.context.options, host='::1')
    with served(stage) as address:
        assert address.startswith('http://[::1]:')
        assert Caller(address).ask('/api/token', {'token': TOKEN})[0] == 200


@pytest.mark.parametrize(
    ('options', 'users', 'words'),
    [
        ({'host': '0.0.0.0'}, 0, '--users and --certificate and --key'),  # noqa: S104 - refused
        ({'host': '192.168.1.5'}, 2, 'needs --certificate'),
        ({'host': 'example.org'}, 2, 'needs --certificate'),
        ({'certificate': 'c'}, 2, 'both are needed'),
        ({'port': 65536}, 0, '--port 65536: must be within 0 and 65535'),
    ],
)
def test_other_machines_reach_it_only_with_users_and_tls(options, users, words):
    """Before anything listens."""
    with pytest.raises(ConsoleError, match=words):
        require_safe(WebOptions(**options), users)
    require_safe(WebOptions(), 0)
    require_safe(WebOptions(host='::1'), 0)
