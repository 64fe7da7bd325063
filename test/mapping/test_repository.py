# SPDX-License-Identifier: Apache-2.0
"""Photographs are copied elsewhere, each once, over links that break."""

import base64
import dataclasses
import hashlib
import http.client
import json
import os
import socket
import threading
import time

import pytest

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import plain_of_record
from rocsafe_mapping.repository import server as server_module
from rocsafe_mapping.repository import uploads
from rocsafe_mapping.repository.copying import LEDGER, Copier
from rocsafe_mapping.repository.http_sink import HttpSink
from rocsafe_mapping.repository.server import Repository
from rocsafe_mapping.repository.sink import FolderSink, open_sink
from rocsafe_mapping.store.catalogue import read_store
from rocsafe_mapping.store.store import ImageStore, Status

DEADLINE_S = 60.0


@pytest.fixture
def server(tmp_path):
    """A repository on loopback."""
    server = Repository(tmp_path / 'far', ('127.0.0.1', 0), token='secret')  # noqa: S106
    thread = threading.Thread(target=server.serve_forever, kwargs={'poll_interval': 0.01})
    thread.start()
    yield server
    server.shutdown()
    thread.join(DEADLINE_S)
    server.server_close()


def url_of(server):
    """Return where a repository is."""
    return f'http://127.0.0.1:{server.server_address[1]}'


def tagged(shot, number=0, **changes):
    """Return a photograph whose record names the bytes as they are."""
    record, jpeg = shot(number, **changes)
    return dataclasses.replace(record, sha256=hashlib.sha256(jpeg).hexdigest()), jpeg


def test_a_photograph_is_kept_once(server, shot):
    """Sent twice it is stored once, byte by byte."""
    sink = HttpSink(url_of(server), 'secret')
    record, jpeg = tagged(shot)
    assert sink.put(record, jpeg).status is Status.STORED
    assert sink.put(record, jpeg).status is Status.DUPLICATE
    sink.close()
    (stored,) = read_store(server.store.directory, pytest.fail)
    assert stored.record == record
    assert stored.read_image() == jpeg


def test_other_bytes_of_the_same_name_are_refused(server, shot):
    """For good: sending them again would not help."""
    sink = HttpSink(url_of(server), 'secret')
    sink.put(*tagged(shot))
    record, other = tagged(shot, 1)
    first = tagged(shot)[0]
    record = dataclasses.replace(first, sha256=record.sha256)
    answer = sink.put(record, other)
    assert answer.status is Status.REJECTED
    assert 'stored already with another image' in answer.reason
    sink.close()


def test_an_upload_goes_on_where_it_stopped(server, shot):
    """Bytes that arrived before the link broke are not sent again."""
    record, jpeg = tagged(shot)
    part = jpeg[: len(jpeg) // 2]
    first = HttpSink(url_of(server), 'secret')
    first._ask('PATCH', f'/uploads/{record.sha256}', part, {'Upload-Offset': '0'})
    first.close()
    sent = []
    second = HttpSink(url_of(server), 'secret')
    ask = second._ask
    second._ask = lambda method, path, body=b'', headers=None: (
        sent.append((method, len(body))),
        ask(method, path, body, headers),
    )[1]
    assert second.put(record, jpeg).status is Status.STORED
    assert ('PATCH', len(jpeg) - len(part)) in sent
    second.close()


def test_a_wrong_token_is_refused(server, shot):
    """Nothing is stored."""
    sink = HttpSink(url_of(server), 'wrong')
    with pytest.raises(StoreError, match='401'):
        sink.put(*tagged(shot))
    sink.close()
    assert len(server.store) == 0


def test_a_damaged_body_is_refused(server):
    """The digest is checked before anything is written."""
    link = http.client.HTTPConnection('127.0.0.1', server.server_address[1], timeout=DEADLINE_S)
    headers = {
        'Authorization': 'Bearer secret',
        'Upload-Offset': '0',
        'Content-Digest': 'sha-256=:AAAA:',
    }
    link.request('PATCH', f'/uploads/{"0" * 64}', b'bytes', headers)
    assert link.getresponse().status == 400
    link.close()
    assert not list((server.folder / 'uploads').iterdir())


@pytest.mark.parametrize(
    'headers',
    [
        [('Content-Length', '-1')],
        [('Content-Length', '9' * 5000)],
        [('Content-Length', '1'), ('Content-Length', '2')],
        [('Transfer-Encoding', 'chunked')],
    ],
)
def test_a_body_of_unclear_length_is_refused(server, headers):
    """With an answer; what follows is not read as another request."""
    link = http.client.HTTPConnection('127.0.0.1', server.server_address[1], timeout=DEADLINE_S)
    link.putrequest('PATCH', f'/uploads/{"0" * 64}')
    for header in [('Authorization', 'Bearer secret'), *headers]:
        link.putheader(*header)
    link.endheaders()
    answer = link.getresponse()
    assert answer.status == 400
    assert b'one number is needed' in answer.read()
    assert link.sock is None
    link.close()


def test_strangers_that_wait_make_room(server, monkeypatch, capsys):
    """More connections than are served, none of which sends a request, keep nobody out."""
    monkeypatch.setattr(server_module, 'MOST_CONNECTIONS', 3)
    address = ('127.0.0.1', server.server_address[1])
    strangers = [socket.create_connection(address, DEADLINE_S) for _ in range(8)]
    assert asked(server, 'GET', '/images') == (200, b'[]')
    # The oldest were closed.
    assert strangers[0].recv(1) == b''
    for stranger in strangers:
        stranger.close()
    assert capsys.readouterr().err == ''


def test_a_record_nested_without_end_is_refused(server):
    """Not answered by a closed connection."""
    body = b'[' * 100_000
    digest = base64.b64encode(hashlib.sha256(body).digest()).decode()
    headers = {'Content-Digest': f'sha-256=:{digest}:'}
    assert asked(server, 'PUT', '/images/rav1-00000', body, **headers)[0] == 422


def asked(server, method, path, body=None, **headers):
    """Return status and content of the answer to a request with the token."""
    link = http.client.HTTPConnection('127.0.0.1', server.server_address[1], timeout=DEADLINE_S)
    link.request(method, path, body, {'Authorization': 'Bearer secret', **headers})
    answer = link.getresponse()
    content = answer.read()
    link.close()
    return answer.status, content


def test_a_repeated_put_is_answered_as_success(server, shot):
    """The upload is gone then: a client whose answer was lost must not send the bytes again."""
    sink = HttpSink(url_of(server), 'secret')
    record, jpeg = tagged(shot)
    assert sink.put(record, jpeg).status is Status.STORED
    assert sink._commit(record, record.sha256).status is Status.DUPLICATE
    with pytest.raises(StoreError, match='412'):
        sink._commit(record, '0' * 64)
    sink.close()


def test_a_put_without_the_hash_of_its_photograph_is_told_so(server, shot):
    """Not that zero bytes of nothing are there."""
    body = json.dumps(plain_of_record(shot(0)[0])).encode()
    digest = base64.b64encode(hashlib.sha256(body).digest()).decode()
    headers = {'Content-Digest': f'sha-256=:{digest}:'}
    status, text = asked(server, 'PUT', '/images/rav1-00000', body, **headers)
    assert status == 400
    assert b'Idempotency-Key' in text


def test_photographs_can_be_listed_and_read(server, shot):
    """By those who have the token."""
    sink = HttpSink(url_of(server), 'secret')
    record, jpeg = tagged(shot)
    sink.put(record, jpeg)
    sink.close()
    status, listed = asked(server, 'GET', '/images')
    assert (status, json.loads(listed)) == (
        200,
        [{'shot_id': record.shot_id, 'sha256': record.sha256, 'bytes': len(jpeg)}],
    )
    assert asked(server, 'GET', f'/images/{record.shot_id}') == (200, jpeg)
    assert asked(server, 'GET', '/images/rav9-00000')[0] == 404
    assert asked(server, 'GET', '/images', Authorization='Bearer wrong')[0] == 401


def test_a_stranger_is_refused_before_the_body_is_read(server):
    """A body that never comes keeps nobody waiting."""
    link = http.client.HTTPConnection('127.0.0.1', server.server_address[1], timeout=DEADLINE_S)
    link.putrequest('PATCH', f'/uploads/{"0" * 64}')
    link.putheader('Content-Length', '1000000')
    link.endheaders()
    assert link.getresponse().status == 401
    link.close()


def test_uploads_are_limited_in_size_and_number(server, monkeypatch):
    """And an upload that nobody goes on with makes room."""
    monkeypatch.setattr(uploads, 'MOST_UPLOADS', 2)
    monkeypatch.setattr(uploads, 'MOST_UPLOAD_BYTES', 10)

    def status(number, body):
        digest = base64.b64encode(hashlib.sha256(body).digest()).decode()
        headers = {'Upload-Offset': '0', 'Content-Digest': f'sha-256=:{digest}:'}
        return asked(server, 'PATCH', f'/uploads/{number:064x}', body, **headers)[0]

    assert status(1, b'12345678901') == 413
    assert [status(number, b'1') for number in (1, 2, 3)] == [204, 204, 503]
    os.utime(server.uploads.path(f'{1:064x}'), (0.0, 0.0))
    assert status(3, b'1') == 204
    assert server.uploads.size(f'{1:064x}') == 0


def test_beyond_loopback_a_token_is_needed(tmp_path):
    """Nobody opens a store to the network by accident."""
    with pytest.raises(ValueError, match=r'host = 0\.0\.0\.0 is not loopback'):
        Repository(tmp_path, ('0.0.0.0', 0))  # noqa: S104


def test_a_full_disk_is_told_and_nothing_kept(server, shot, monkeypatch):
    """507, to be tried again."""
    monkeypatch.setattr(server.store, '_reserve_bytes', 2**62)
    sink = HttpSink(url_of(server), 'secret')
    with pytest.raises(StoreError, match=r'507 disk of .* is as good as full'):
        sink.put(*tagged(shot))
    sink.close()
    assert len(server.store) == 0


def test_copies_survive_an_absent_repository(tmp_path, shot):
    """What could not be sent is sent later, each once; a new copier knows what is done."""
    near = ImageStore(tmp_path / 'near', reserve_bytes=0)
    for number in range(3):
        near.put(*shot(number))
    failures = []

    def unreliable():
        if len(failures) < 1:
            failures.append(None)
            raise StoreError('link is down')
        return FolderSink(tmp_path / 'far')

    copier = Copier(tmp_path / 'near', unreliable, lambda _text: None)
    end = time.monotonic() + DEADLINE_S
    ledger = tmp_path / 'near' / LEDGER
    while len(ledger.read_text().splitlines()) < 3:
        assert time.monotonic() < end
        time.sleep(0.01)
    copier.close()
    again = Copier(tmp_path / 'near', pytest.fail, pytest.fail)
    again.close()
    assert len(ledger.read_text().splitlines()) == 3
    near.close()
    near_images = {s.record.shot_id: s.read_image() for s in read_store(tmp_path / 'near', print)}
    far_images = {s.record.shot_id: s.read_image() for s in read_store(tmp_path / 'far', print)}
    assert near_images == far_images


def test_sinks_by_url(tmp_path):
    """A path and a file URL are folders; an unknown scheme is refused."""
    for url in (str(tmp_path / 'a'), (tmp_path / 'b').as_uri()):
        sink = open_sink(url)
        assert isinstance(sink, FolderSink)
        sink.close()
    assert {path.name for path in tmp_path.iterdir()} == {'a', 'b'}
    with pytest.raises(StoreError, match='scheme gopher is none of'):
        open_sink('gopher://host/x')
