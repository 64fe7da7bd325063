# SPDX-License-Identifier: Apache-2.0
"""Sends photographs to an HTTP repository; a broken transfer goes on where it stopped.

The bytes are uploaded under their SHA-256 in pieces with an offset (as in tus 1.0), then the
record is put, which makes them a photograph: see `server`.
"""

import base64
import hashlib
import http.client
import json
from collections.abc import Mapping
from urllib.parse import urlsplit

from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import ShotRecord, plain_of_record
from rocsafe_mapping.store.store import Answer, Status

TIMEOUT_S = 10.0
PIECE_BYTES = 256 * 1024
CREATED, OK, NO_CONTENT = 201, 200, 204
CONFLICT, UNPROCESSABLE = 409, 422
OFFSET = 'Upload-Offset'


class HttpSink:
    """A repository at a URL.

    Parameters
    ----------
    url
        Of the repository, without a trailing slash.
    token
        That it asks for; empty for none.
    """

    def __init__(self, url: str, token: str = '') -> None:
        parts = urlsplit(url)
        if parts.hostname is None:
            raise StoreError(f'{url}: no host is named')
        self._url = url
        self._base = parts.path.rstrip('/')
        kind = (
            http.client.HTTPSConnection if parts.scheme == 'https' else http.client.HTTPConnection
        )
        self._connection = kind(parts.hostname, parts.port, timeout=TIMEOUT_S)
        self._headers = {'Authorization': f'Bearer {token}'} if token else {}

    def put(self, record: ShotRecord, image: bytes) -> Answer:
        """Keep a tagged image.

        Raises
        ------
        StoreError
            If the repository cannot be reached or does not take it now.
        """
        sha256 = hashlib.sha256(image).hexdigest()
        try:
            self._upload(sha256, image)
            return self._commit(record, sha256)
        except (OSError, http.client.HTTPException) as error:
            self._connection.close()
            raise StoreError(f'{self._url}: {error}') from error

    def close(self) -> None:
        """Close the connection."""
        self._connection.close()

    def _upload(self, sha256: str, image: bytes) -> None:
        path = f'/uploads/{sha256}'
        status, headers, _ = self._ask('HEAD', path)
        if status != OK:
            raise StoreError(f'{self._url}: {status}')
        offset = int(headers.get(OFFSET, 0))
        while offset < len(image):
            piece = image[offset : offset + PIECE_BYTES]
            status, headers, text = self._ask('PATCH', path, piece, {OFFSET: str(offset)})
            if status != NO_CONTENT:
                raise StoreError(f'{self._url}: {status} {text}')
            offset = int(headers[OFFSET])

    def _commit(self, record: ShotRecord, sha256: str) -> Answer:
        digest = base64.b64encode(bytes.fromhex(sha256)).decode()
        headers = {
            'Content-Type': 'application/json',
            'Image-Digest': f'sha-256=:{digest}:',
            'Idempotency-Key': sha256,
        }
        body = json.dumps(plain_of_record(record)).encode()
        status, _, text = self._ask('PUT', f'/images/{record.shot_id}', body, headers)
        if status in (CREATED, OK):
            kind = Status.STORED if status == CREATED else Status.DUPLICATE
            return Answer(status=kind, sha256=sha256)
        if status in (CONFLICT, UNPROCESSABLE):
            return Answer(status=Status.REJECTED, sha256=sha256, reason=text)
        raise StoreError(f'{self._url}: {status} {text}')

    def _ask(
        self, method: str, path: str, body: bytes = b'', headers: Mapping[str, str] | None = None
    ) -> tuple[int, dict[str, str], str]:
        """Return status, headers and text of the answer."""
        digest = base64.b64encode(hashlib.sha256(body).digest()).decode()
        sent = {'Content-Digest': f'sha-256=:{digest}:', **self._headers, **(headers or {})}
        self._connection.request(method, self._base + path, body or None, sent)
        answer = self._connection.getresponse()
        text = answer.read().decode('utf-8', 'replace').strip()
        return answer.status, dict(answer.getheaders()), text
