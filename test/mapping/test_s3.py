# SPDX-License-Identifier: Apache-2.0
"""Photographs are copied to a bucket, by the real library to a server that speaks S3."""

import dataclasses
import hashlib
import json
import threading
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer

import pytest

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.repository.sink import open_sink
from rocsafe_mapping.store.store import Status

pytest.importorskip('obstore', reason='obstore is an extra: pip install obstore')

BUCKET = 'photos'
DEADLINE_S = 60.0


class Handler(BaseHTTPRequestHandler):
    """Keeps objects of one bucket in memory: PUT and GET by path."""

    protocol_version = 'HTTP/1.1'

    def do_PUT(self):
        """Store an object, if the request is signed."""
        body = self.rfile.read(int(self.headers.get('Content-Length', 0)))
        signed = self.headers.get('Authorization', '').startswith('AWS4-HMAC-SHA256')
        if not signed or not self.path.startswith(f'/{BUCKET}/'):
            return self.answer(403 if not signed else 404)
        self.server.objects[self.path] = body
        return self.answer(200)

    def do_GET(self):
        """Return an object."""
        body = self.server.objects.get(self.path)
        return self.answer(404) if body is None else self.answer(200, body)

    def answer(self, status, body=b''):
        """Send a status and a body."""
        self.send_response(status)
        self.send_header('Content-Length', str(len(body)))
        self.send_header('ETag', '"1"')
        self.send_header('Last-Modified', 'Sat, 21 Nov 2026 00:00:00 GMT')
        self.end_headers()
        self.wfile.write(body)

    def log_message(self, *_arguments):
        """Say nothing."""


@pytest.fixture
def server(monkeypatch):
    """A bucket on loopback, found by the variables that all S3 clients know."""
    server = ThreadingHTTPServer(('127.0.0.1', 0), Handler)
    server.objects = {}
    thread = threading.Thread(target=server.serve_forever, kwargs={'poll_interval': 0.01})
    thread.start()
    address = f'http://127.0.0.1:{server.server_address[1]}'
    for name, value in {
        'AWS_ENDPOINT_URL': address, 'AWS_ENDPOINT': address, 'AWS_ALLOW_HTTP': 'true',
        'AWS_REGION': 'us-east-1', 'AWS_ACCESS_KEY_ID': 'name', 'AWS_SECRET_ACCESS_KEY': 'secret',
    }.items():  # fmt: skip
        monkeypatch.setenv(name, value)
    yield server
    server.shutdown()
    thread.join(DEADLINE_S)
    server.server_close()


def tagged(shot, number=0, **changes):
    """Return a photograph whose record names the bytes as they are."""
    record, jpeg = shot(number, **changes)
    return dataclasses.replace(record, sha256=hashlib.sha256(jpeg).hexdigest()), jpeg


def test_a_photograph_and_its_record_are_in_the_bucket(server, shot):
    """Below the prefix of the URL, byte by byte."""
    record, jpeg = tagged(shot)
    assert open_sink(f's3://{BUCKET}/run').put(record, jpeg).status is Status.STORED
    assert server.objects[f'/{BUCKET}/run/rav1-00000.jpg'] == jpeg
    sidecar = json.loads(server.objects[f'/{BUCKET}/run/rav1-00000.json'])
    assert sidecar['sha256'] == record.sha256


def test_a_photograph_is_kept_once(server, shot):
    """Sent again it is a duplicate; other bytes of its name are refused."""
    sink = open_sink(f's3://{BUCKET}')
    sink.put(*tagged(shot))
    assert sink.put(*tagged(shot)).status is Status.DUPLICATE
    other = tagged(shot, 1, shot_id='rav1-00000', sequence=0)
    assert sink.put(*other).status is Status.REJECTED
    assert server.objects[f'/{BUCKET}/rav1-00000.jpg'] == tagged(shot)[1]


def test_a_missing_bucket_is_one_clear_error(server, shot):
    """Named by its URL; the copier tries again later."""
    with pytest.raises(StoreError, match='s3://nothing: '):
        open_sink('s3://nothing').put(*tagged(shot))
