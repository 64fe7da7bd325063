# SPDX-License-Identifier: Apache-2.0
"""A reference repository: keeps photographs that are sent over HTTP in an image store.

``HEAD /uploads/<sha256>`` tells the offset; ``PATCH /uploads/<sha256>`` with ``Upload-Offset``
adds a piece; ``PUT /images/<shot_id>`` with the record makes the bytes a photograph: 201 new, 200
there already, 409 other bytes of that name, 412 not all bytes are there, 422 no photograph, 507
disk full. Each body is checked against ``Content-Digest`` (RFC 9530). Beyond loopback a token is
needed.
"""

import base64
import hashlib
import hmac
import ipaddress
import json
import re
import shutil
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from threading import Lock

from rocsafe_geo.storage.durable import sync_file
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import ShotRecord, record_of_plain
from rocsafe_mapping.repository.http_sink import OFFSET
from rocsafe_mapping.store.store import ImageStore, Status

MOST_BODY_BYTES = 64 * 2**20
UPLOADS = 'uploads'
_UPLOAD = re.compile(r'/uploads/([0-9a-f]{64})')
_IMAGE = re.compile(r'/images/([A-Za-z0-9_-]{1,80})')
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

    Raises
    ------
    StoreError
        If the store cannot be opened.
    ValueError
        If others than this machine could write without a token.
    """

    daemon_threads = True

    def __init__(self, folder: Path, address: tuple[str, int], token: str = '') -> None:
        if not token and not _is_loopback(address[0]):
            raise ValueError(f'host = {address[0]} is not loopback: a token is needed')
        self.store = ImageStore(folder)
        self.uploads = folder / UPLOADS
        self.uploads.mkdir(exist_ok=True)
        self.token = token
        self.lock = Lock()
        super().__init__(address, _Handler)

    def server_close(self) -> None:
        """Close the store with the server."""
        super().server_close()
        self.store.close()


class _Handler(BaseHTTPRequestHandler):
    """One connection."""

    protocol_version = 'HTTP/1.1'
    server: Repository

    def do_HEAD(self) -> None:
        """Tell how much of an upload is there."""
        found = _UPLOAD.fullmatch(self.path)
        if found is None or not self._is_allowed():
            return self._answer(404 if found is None else 401)
        path = self.server.uploads / found.group(1)
        return self._answer(200, headers={OFFSET: str(_size(path))})

    def do_PATCH(self) -> None:
        """Add a piece to an upload."""
        body, found = self._body(), _UPLOAD.fullmatch(self.path)
        if body is None:
            return None
        if found is None:
            return self._answer(404)
        path = self.server.uploads / found.group(1)
        with self.server.lock:
            offset = _size(path)
            if self.headers.get(OFFSET) != str(offset):
                return self._answer(409, f'offset is {offset}')
            if shutil.disk_usage(self.server.uploads).free < len(body) + 2**20:
                return self._answer(507, 'disk is full')
            with path.open('ab') as file:
                file.write(body)
            sync_file(path)
        return self._answer(204, headers={OFFSET: str(offset + len(body))})

    def do_PUT(self) -> None:
        """Make an upload a photograph."""
        body, found = self._body(), _IMAGE.fullmatch(self.path)
        if body is None:
            return None
        if found is None:
            return self._answer(404)
        try:
            record = record_of_plain(json.loads(body))
        except ValueError as error:
            return self._answer(422, str(error))
        if record.shot_id != found.group(1):
            return self._answer(422, f'record is of {record.shot_id}')
        sha256 = self.headers.get('Idempotency-Key', '')
        path = self.server.uploads / sha256
        image = path.read_bytes() if re.fullmatch('[0-9a-f]{64}', sha256) and _size(path) else b''
        if hashlib.sha256(image).hexdigest() != sha256:
            return self._answer(412, f'{len(image)} bytes of {sha256} are there')
        return self._store(record, image, path)

    def log_message(self, format: str, *args: object) -> None:  # noqa: A002
        """Log nothing: the answers say it."""

    def _store(self, record: ShotRecord, image: bytes, upload: Path) -> None:
        try:
            with self.server.lock:
                answer = self.server.store.put(record, image, is_tagged=True)
        except StoreError as error:
            return self._answer(507, str(error))
        upload.unlink(missing_ok=True)
        return self._answer(ANSWERS[answer.status], answer.reason)

    def _body(self) -> bytes | None:
        """Return the body, None if it was refused."""
        told = self.headers.get('Content-Length', '0')
        if not (told.isascii() and told.isdigit()):
            self.close_connection = True
            self._answer(400, f'Content-Length is {told!r}')
            return None
        length = int(told)
        if length > MOST_BODY_BYTES:
            self.close_connection = True
            self._answer(413, f'{length} bytes exceed {MOST_BODY_BYTES}')
            return None
        body = self.rfile.read(length)
        if not self._is_allowed():
            self._answer(401)
            return None
        digest = _DIGEST.search(self.headers.get('Content-Digest', ''))
        actual = base64.b64encode(hashlib.sha256(body).digest()).decode()
        if digest is None or digest.group(1) != actual or len(body) != length:
            self._answer(400, 'Content-Digest is missing or not that of the body')
            return None
        return body

    def _is_allowed(self) -> bool:
        given = self.headers.get('Authorization', '')
        wanted = f'Bearer {self.server.token}'
        return not self.server.token or hmac.compare_digest(given.encode(), wanted.encode())

    def _answer(self, status: int, text: str = '', headers: dict[str, str] | None = None) -> None:
        content = text.encode() if self.command != 'HEAD' and status != 204 else b''
        self.send_response(status)
        for name, value in (headers or {}).items():
            self.send_header(name, value)
        if status != 204:
            self.send_header('Content-Length', str(len(content)))
        self.end_headers()
        self.wfile.write(content)


def _size(path: Path) -> int:
    return path.stat().st_size if path.exists() else 0


def _is_loopback(host: str) -> bool:
    try:
        return ipaddress.ip_address(host).is_loopback
    except ValueError:
        return host == 'localhost'
