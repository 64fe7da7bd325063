# SPDX-License-Identifier: Apache-2.0
"""Who may do what: the whole table of roles, users, sessions and limits."""

import pytest
from cryptography.exceptions import InvalidKey
from cryptography.hazmat.primitives.kdf.argon2 import Argon2id

from rocsafe_console.errors import ConsoleError, RefusedError
from rocsafe_console.people.missions import EVERYBODY, NAMED, Access, Missions, access_of
from rocsafe_console.people.passwords import NOBODY, hash_of, is_right
from rocsafe_console.people.roles import MAY, VERBS, Action, Role, require
from rocsafe_console.people.session_file import load_sessions, save_sessions
from rocsafe_console.people.sessions import LONGEST_S, AttemptLimit, Sessions
from rocsafe_console.people.users import User, Users, read_users, write_users

PASSWORD = 'correct horse battery'  # noqa: S105 - of a test
# Written out by hand: a change of the table must be meant.
EXPECTED = {
    'viewer': {'see'},
    'operator': {
        'see', 'acknowledge', 'mark', 'draft', 'hold', 'resume', 'return', 'land', 'take',
        'release', 'go_to', 'send', 'remake',
    },
    'commander': {
        'see', 'acknowledge', 'mark', 'draft', 'hold', 'resume', 'return', 'land', 'take',
        'release', 'go_to', 'send', 'remake', 'replan', 'launch', 'end', 'seal', 'revoke',
        'resume_run', 'assign', 'clear',
    },
}  # fmt: skip


@pytest.mark.parametrize('role', Role)
@pytest.mark.parametrize('action', Action)
def test_every_role_may_exactly_what_the_table_says(role, action):
    """All pairs of role and action."""
    if action.value in EXPECTED[role.value]:
        require(role, action)
    else:
        with pytest.raises(RefusedError, match=f'the role {role.value} may not'):
            require(role, action)


def test_who_may_more_may_also_less():
    """Each role may all that the one below may; a viewer commands nothing."""
    assert MAY[Role.VIEWER] < MAY[Role.OPERATOR] < MAY[Role.COMMANDER] == frozenset(Action)
    assert not MAY[Role.VIEWER] & VERBS


MANY = [str(number) for number in range(101)]
OF_COMMANDER = {'replan', 'end', 'seal', 'resume_run'}
OF_MEMBERS = {'resume', 'take', 'release', 'go_to', 'send', 'replan'}


@pytest.mark.parametrize('visibility', [EVERYBODY, NAMED])
@pytest.mark.parametrize('commander', ['', 'anna'])
@pytest.mark.parametrize('members', [(), ('bert',)])
@pytest.mark.parametrize('user', ['anna', 'bert', 'cora'])
@pytest.mark.parametrize('role', Role)
def test_the_rights_on_a_mission_hold_for_every_action(visibility, commander, members, user, role):
    """All combinations: who is not named does not see; hold, return and land need no list."""
    access = Access(commander=commander, visibility=visibility, members=members)
    is_named = user in (commander, *members)
    sees = visibility == EVERYBODY or role is Role.COMMANDER or is_named
    assert access.is_seen_by(user, role) == sees
    for action in Action:
        name = action.value
        may = sees
        may = may and (name not in OF_COMMANDER or commander in ('', user))
        may = may and (name not in OF_MEMBERS or not members or is_named)
        if may:
            access.require(user, role, action)
        else:
            with pytest.raises(RefusedError):
                access.require(user, role, action)


def test_the_rights_on_a_mission_outlive_the_server(tmp_path):
    """Without any, whoever started it commands it; a file that is torn opens nothing."""
    (tmp_path / 'run1').mkdir()
    (tmp_path / 'run1' / 'run.json').write_text('{"commander": "anna"}')
    missions = Missions(tmp_path)
    assert missions.of('run1') == Access(commander='anna')
    assert missions.of('none') == Access()
    access = Access(commander='bert', visibility=NAMED, members=('cora',))
    missions.put('run1', access)
    assert Missions(tmp_path).of('run1') == access
    path = tmp_path / 'console-missions.json'
    assert path.stat().st_mode & 0o777 == 0o600
    path.write_text('{"run1": {"commander": "bert"')
    with pytest.raises(ConsoleError, match='cannot be read'):
        Missions(tmp_path)


@pytest.mark.parametrize(
    ('plain', 'words'),
    [
        ({'commander': 'a', 'visibility': 'nobody', 'members': []}, 'visibility'),
        ({'commander': 'a', 'visibility': EVERYBODY, 'members': 'bert'}, 'a list of names'),
        (
            {'commander': 'a', 'visibility': EVERYBODY, 'members': list(map(str, range(101)))},
            '101',
        ),
        ({'commander': 'a', 'members': []}, 'visibility'),
    ],
)
def test_wrong_rights_are_refused_in_one_line(plain, words):
    """By the name of the field."""
    with pytest.raises((ValueError, TypeError, KeyError), match=words):
        access_of(plain)


def test_users_are_kept_in_a_file_that_only_its_owner_reads(tmp_path):
    """What is written is read; a file that others could read is refused."""
    path = tmp_path / 'users.yaml'
    user = User(name='anna', role=Role.OPERATOR, password_hash=hash_of(PASSWORD))
    write_users(path, {'anna': user})
    assert path.stat().st_mode & 0o777 == 0o600
    assert read_users(path) == {'anna': user}
    assert PASSWORD not in path.read_text()
    path.chmod(0o644)
    with pytest.raises(ConsoleError, match='must be 0600'):
        read_users(path)


@pytest.mark.slow
def test_all_users_and_sessions_of_a_large_staff_are_kept(tmp_path):
    """Neither file is read in part only."""
    path, hashed = tmp_path / 'users.yaml', hash_of(PASSWORD)
    users = {
        name: User(name=name, role=Role.OPERATOR, password_hash=hashed)
        for name in (f'user{number}' for number in range(100))
    }
    write_users(path, users)
    assert read_users(path) == users
    sessions, after = Sessions(), Sessions()
    secrets = [sessions.begin(name, Role.OPERATOR, '::1', 0.0)[0] for name in users]
    save_sessions(tmp_path, sessions)
    load_sessions(tmp_path, after, dict.fromkeys(users, Role.OPERATOR))
    assert all(after.of_secret(secret, 1.0) for secret in secrets)


@pytest.mark.parametrize(
    ('text', 'words'),
    [
        ('users: {anna: {role: king, password_hash: x}}', 'king'),
        ('users: {anna: {role: viewer}}', 'password_hash'),
        ('users: {anna: {role: viewer, password_hash: plain}}', 'no Argon2id hash'),
        ('users: {"a b": {role: viewer, password_hash: plain}}', 'a name must be'),
        ('nobody: 1', 'users'),
        ('[1, 2]', 'users'),
        ('users: {', 'users.yaml'),
    ],
)
def test_a_wrong_file_of_users_is_told_in_one_line(tmp_path, text, words):
    """By the name of the file and what is wrong."""
    path = tmp_path / 'users.yaml'
    path.write_text(text)
    path.chmod(0o600)
    with pytest.raises(ConsoleError, match=words):
        read_users(path)


@pytest.mark.slow
def test_a_name_that_there_is_not_takes_as_long_as_another():
    """The hash of nobody is read and computed like one of a user, with the same costs."""
    with pytest.raises(InvalidKey):
        Argon2id.verify_phc_encoded(PASSWORD.encode(), NOBODY)
    assert NOBODY.split('$')[:4] == hash_of(PASSWORD).split('$')[:4]


@pytest.mark.slow
def test_a_password_is_right_or_not():
    """Two hashes of one password differ; a short one is refused without being told."""
    first, second = hash_of(PASSWORD), hash_of(PASSWORD)
    assert first != second
    assert 'm=65536,t=3,p=4' in first
    assert is_right(PASSWORD, first)
    assert not is_right(PASSWORD + 'x', first)
    with pytest.raises(ValueError, match='has 5 letters') as refusal:
        hash_of('short')
    assert 'short:' not in str(refusal.value)
    users = Users({'anna': User(name='anna', role=Role.VIEWER, password_hash=first)})
    assert users.log_in('anna', PASSWORD) is not None
    assert users.log_in('anna', 'wrong') is None
    assert users.log_in('nobody', PASSWORD) is None


def test_a_session_ends_by_time_or_by_a_word():
    """Its secret is not kept, and other sessions stay."""
    sessions = Sessions()
    secret, session = sessions.begin('anna', Role.VIEWER, '127.0.0.1', 0.0)
    other, _ = sessions.begin('bert', Role.OPERATOR, '127.0.0.1', 0.0)
    assert secret not in repr(vars(sessions))
    assert sessions.of_secret(secret, 10.0) == session
    assert sessions.of_secret(secret + 'x', 10.0) is None
    assert sessions.of_secret(secret, LONGEST_S + 1.0) is None
    assert sessions.end(session.public_id)
    assert not sessions.end(session.public_id)
    assert not sessions.is_alive(session, 1.0)
    assert sessions.of_secret(other, 10.0) is not None


def test_attempts_are_limited_by_key():
    """Five in a minute; then the oldest must be a minute old."""
    limit = AttemptLimit(most=5, within_s=60.0)
    for second in range(5):
        assert limit.wait_s('anna', float(second)) == 0.0
        limit.note('anna', float(second))
    assert limit.wait_s('anna', 5.0) == 55.0
    assert limit.wait_s('bert', 5.0) == 0.0
    assert limit.wait_s('anna', 61.0) == 0.0
    limit.forgive('anna')
    assert limit.wait_s('anna', 5.0) == 0.0


def test_sessions_outlive_the_server_but_not_their_role(tmp_path):
    """Of users who are gone or have another role, none; a file that others can read is none."""
    sessions = Sessions()
    secret, _ = sessions.begin('anna', Role.OPERATOR, '127.0.0.1', 0.0)
    save_sessions(tmp_path, sessions)
    assert secret not in (tmp_path / 'console-sessions.json').read_text()
    for roles, is_there in (
        ({'anna': Role.OPERATOR}, True), ({'anna': Role.VIEWER}, False), ({}, False),
    ):  # fmt: skip
        after = Sessions()
        load_sessions(tmp_path, after, roles)
        assert (after.of_secret(secret, 1.0) is not None) == is_there
    (tmp_path / 'console-sessions.json').chmod(0o644)
    after = Sessions()
    load_sessions(tmp_path, after, {'anna': Role.OPERATOR})
    assert after.of_secret(secret, 1.0) is None
