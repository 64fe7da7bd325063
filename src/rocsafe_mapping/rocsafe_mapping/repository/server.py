# SPDX-License-Identifier: Apache-2.0
"""A reference repository: keeps photographs that are sent over HTTP in an image store.

Sending: ``HEAD /uploads/<sha256>`` returns the offset; ``PATCH /uploads/<sha256>`` with
``Upload-Offset`` adds a piece; ``PUT /images/<shot_id>`` with the record, and the SHA-256 of the
bytes as ``Idempotency-Key``, makes them a photograph: 201 new, 200 there already, 409 other bytes
of that name, 412 not all bytes are there, 413 too large, 422 no photograph, 503 too many
unfinished uploads, 507 disk full. Each body is checked against ``Content-Digest`` (RFC 9530).

Reading: ``GET /images`` lists the photographs as JSON, ``GET /images/<shot_id>`` is one.

Beyond loopback a token is needed; it is checked before a body is read. Of more connections than
`MOST_CONNECTIONS` the oldest that has not brought it is closed.
"""

import base64
import contextlib
import hashlib
import hmac
import ipaddress
import json
import re
import socket
import sys
from collections.abc import Callable
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Lock
from typing import Any, BinaryIO, cast

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import ShotRecord, record_of_plain
from rocsafe_mapping.repository.http_sink import OFFSET
from rocsafe_mapping.repository.uploads import UploadRefusedError, Uploads
from rocsafe_mapping.store.catalogue import read_shot, read_store
from rocsafe_mapping.store.store import Answer, ImageStore, Status

MOST_PIECE_BYTES = 64 * 2**20
MOST_RECORD_BYTES = 2**20
SILENCE_S = 30.0
"""A connection without a byte for so long is closed."""

MOST_CONNECTIONS = 64

UPLOADS = 'uploads'
_UPLOAD = re.compile(r'/uploads/([0-9a-f]{64})')
_IMAGE = re.compile(r'/images/([A-Za-z0-9_-]{1,80})')
_SHA256 = re.compile(r'[0-9a-f]{64}')
_NUMBER = re.compile(r'[0-9]{1,18}')
_DIGEST = re.compile(r'sha-256=:([A-Za-z0-9+/=]+):')
ANSWERS = {Status.STORED: 201, Status.DUPLICATE: 200, Status.REJECTED: 409}


class Repository(ThreadingHTTPServer):
    """Serves an image store.

    Parameters
    ----------
    folder
        Of the image store.
    address
        Host and port; port 0 is any.
    token
        That requests must bring; may be empty on loopback only.
    store
        The open store, where another writes to it too; then under `lock`. It is not closed.
    on_stored
        Called in the thread of a connection with each photograph and what became of it.

    Attributes
    ----------
    lock
        Held while something is stored.

    Raises
    ------
    StoreError
        If the store cannot be opened.
    ValueError
        If others than this machine could write without a token.
    """

    daemon_threads = True
    request_queue_size = MOST_CONNECTIONS

    def __init__(
        self,
        folder: Path,
        address: tuple[str, int],
        token: str = '',
        store: ImageStore | None = None,
        on_stored: Callable[[ShotRecord, Answer], None] = lambda _record, _answer: None,
    ) -> None:
        if not token and not _is_loopback(address[0]):
            raise ValueError(f'host = {address[0]} is not loopback: a token is needed')
        self.folder = folder
        self._owns_store = store is None
        self.store = ImageStore(folder) if store is None else store
        self.on_stored = on_stored
        self.uploads = Uploads(folder / UPLOADS)
        self.token = token
        self.lock = Lock()
        # Open connections, oldest first, and whether each has brought the token.
        self._connections: dict[socket.socket, bool] = {}
        self._connections_lock = Lock()
        super().__init__(address, _Handler)

    def server_close(self) -> None:
        """Close the store with the server."""
        super().server_close()
        if self._owns_store:
            self.store.close()

    def verify_request(self, request: Any, client_address: Any) -> bool:
        """Return whether there is room for a connection; strangers that wait make it."""
        del client_address
        with self._connections_lock:
            if len(self._connections) >= MOST_CONNECTIONS:
                strange = (link for link, is_known in self._connections.items() if not is_known)
                oldest = next(strange, None)
                if oldest is None:
                    return False
                del self._connections[oldest]
                with contextlib.suppress(OSError):
                    oldest.shutdown(socket.SHUT_RDWR)
            self._connections[request] = False
        return True

    def know(self, connection: socket.socket) -> None:
        """Note that a connection has brought the token."""
        with self._connections_lock:
            if connection in self._connections:
                self._connections[connection] = True

    def shutdown_request(self, request: Any) -> None:
        """Close a connection."""
        with self._connections_lock:
            self._connections.pop(request, None)
        super().shutdown_request(request)

    def handle_error(self, request: Any, client_address: Any) -> None:
        """Say in one line what ended a connection, unless its client has gone."""
        del request
        error = sys.exc_info()[1]
        if not isinstance(error, OSError):
            sys.stderr.write(f'{client_address[0]}: {type(error).__name__}: {error}\n')


class _Handler(BaseHTTPRequestHandler):
    """One connection."""

    protocol_version = 'HTTP/1.1'
    timeout = SILENCE_S
    server: Repository

    def do_HEAD(self) -> None:
        """Return how much of an upload is there."""
        if self._is_allowed():
            found = _UPLOAD.fullmatch(self.path)
            if found is None:
                return self._answer(404)
            self._answer(200, headers={OFFSET: str(self.server.uploads.size(found[1]))})
        return None

    def do_GET(self) -> None:
        """Return the list of the photographs, or one of them."""
        if not self._is_allowed():
            return None
        found = _IMAGE.fullmatch(self.path)
        try:
            if self.path == '/images':
                return self._send('application/json', _listed(self.server.folder))
            if found is None:
                return self._answer(404)
            return self._send('image/jpeg', read_shot(self.server.folder, found[1]).read_image())
        except StoreError:
            return self._answer(404)

    def do_PATCH(self) -> None:
        """Add a piece to an upload."""
        length = self._length(MOST_PIECE_BYTES)
        if length is None:
            return None
        found, offset = _UPLOAD.fullmatch(self.path), self.headers.get(OFFSET, '')
        if found is None or not _NUMBER.fullmatch(offset):
            self.close_connection = True
            return self._answer(404 if found is None else 400, f'{OFFSET} is {offset[:40]!r}')
        try:
            size = self._appended(found[1], int(offset), length)
        except UploadRefusedError as error:
            self.close_connection = True
            return self._answer(error.status, str(error))
        return self._answer(204, headers={OFFSET: str(size)})

    def _appended(self, sha256: str, offset: int, length: int) -> int:
        """Receive a piece and add it to its upload; return the new size of the upload."""
        uploads = self.server.uploads
        piece, digest = uploads.received(cast(BinaryIO, self.rfile), length)
        try:
            if not self._is_digest(digest):
                raise UploadRefusedError(400, 'Content-Digest is missing or not that of the body')
            with self.server.lock:
                return uploads.append(sha256, offset, piece)
        finally:
            piece.unlink(missing_ok=True)

    def do_PUT(self) -> None:
        """Make an upload a photograph; a repeated request has the answer that it is there."""
        length = self._length(MOST_RECORD_BYTES)
        if length is None:
            return None
        body, found = self.rfile.read(length), _IMAGE.fullmatch(self.path)
        if not self._is_digest(hashlib.sha256(body).digest()):
            return self._answer(400, 'Content-Digest is missing or not that of the body')
        if found is None:
            return self._answer(404)
        try:
            record = record_of_plain(json.loads(body))
        except (ValueError, RecursionError) as error:
            return self._answer(422, str(error))
        if record.shot_id != found[1]:
            return self._answer(422, f'record is of {record.shot_id}')
        # One at a time: a photograph is held in memory while it is stored.
        with self.server.lock:
            return self._store(record, self.headers.get('Idempotency-Key', ''))

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Log nothing: the answers say it."""

    def _store(self, record: ShotRecord, sha256: str) -> None:
        if not _SHA256.fullmatch(sha256):
            return self._answer(400, 'Idempotency-Key is not the SHA-256 of the photograph')
        uploads = self.server.uploads
        image = uploads.path(sha256).read_bytes() if uploads.size(sha256) > 0 else b''
        if hashlib.sha256(image).hexdigest() != sha256:
            if _is_stored(self.server.folder, record.shot_id, sha256):
                return self._answer(ANSWERS[Status.DUPLICATE])
            return self._answer(412, f'{len(image)} bytes of {sha256} are there')
        try:
            answer = self.server.store.put(record, image, is_tagged=True)
        except StoreError as error:
            return self._answer(507, str(error))
        uploads.remove(sha256)
        self.server.on_stored(record, answer)
        return self._answer(ANSWERS[answer.status], answer.reason)

    def _length(self, most: int) -> int | None:
        """Return the length of the body, None if the request was refused without reading it."""
        if not self._is_allowed():
            return None
        # Two lengths, or a body in chunks, would leave bytes that are read as the next request.
        told, *others = self.headers.get_all('Content-Length', ['0'])
        if others or not _NUMBER.fullmatch(told) or 'Transfer-Encoding' in self.headers:
            self.close_connection = True
            self._answer(400, f'Content-Length is {told[:40]!r}: one number is needed')
            return None
        if int(told) > most:
            self.close_connection = True
            self._answer(413, f'{told} bytes exceed {most}')
            return None
        return int(told)

    def _is_digest(self, digest: bytes) -> bool:
        """Return whether ``Content-Digest`` is this SHA-256."""
        given = _DIGEST.search(self.headers.get('Content-Digest', ''))
        return given is not None and given[1] == base64.b64encode(digest).decode()

    def _is_allowed(self) -> bool:
        """Return whether the request brings the token; else refuse it and close the connection."""
        given = self.headers.get('Authorization', '')
        wanted = f'Bearer {self.server.token}'
        if not self.server.token or hmac.compare_digest(given.encode(), wanted.encode()):
            self.server.know(self.connection)
            return True
        self.close_connection = True
        self._answer(401)
        return False

    def _answer(self, status: int, text: str = '', headers: dict[str, str] | None = None) -> None:
        content = text.encode() if self.command != 'HEAD' and status != 204 else b''
        self.send_response(status)
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        if self.close_connection:
            self.send_header('Connection', 'close')
        if status != 204:
            self.send_header('Content-Length', str(len(content)))
        self.end_headers()
        self.wfile.write(content)

    def _send(self, kind: str, content: bytes) -> None:
        self.send_response(200)
        self.send_header('Content-Type', kind)
        self.send_header('Content-Length', str(len(content)))
        self.end_headers()
        self.wfile.write(content)


def _listed(folder: Path) -> bytes:
    """Return name, SHA-256 and size of the stored photographs as JSON."""
    rows = [
        {'shot_id': shot.record.shot_id, 'sha256': shot.sha256, 'bytes': shot.size_bytes}
        for shot in read_store(folder, lambda _text: None)
    ]
    return json.dumps(rows).encode()


def _is_stored(folder: Path, shot_id: str, sha256: str) -> bool:
    """Return whether the store has the photograph of that name with these bytes."""
    try:
        return read_shot(folder, shot_id).sha256 == sha256
    except StoreError:
        return False


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'
