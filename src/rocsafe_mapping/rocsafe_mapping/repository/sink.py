# SPDX-License-Identifier: Apache-2.0
"""Where photographs are copied to, by URL."""

import hashlib
import importlib
import json
from pathlib import Path
from typing import Any, Protocol
from urllib.parse import urlsplit
from urllib.request import url2pathname

from rocsafe_geo.storage.secret_file import SecretFileError, read_token
from rocsafe_mapping.errors import StoreError
from rocsafe_mapping.photographs.shot import ShotRecord, plain_of_record
from rocsafe_mapping.repository.http_sink import HttpSink
from rocsafe_mapping.store.catalogue import IMAGE_SUFFIX, SIDECAR_SUFFIX
from rocsafe_mapping.store.store import Answer, ImageStore, Status


class Sink(Protocol):
    """Keeps photographs."""

    def put(self, record: ShotRecord, image: bytes) -> Answer:
        """Keep a tagged image; on return it is safe there, or was refused for good.

        Raises
        ------
        StoreError
            If it is not there now: try again later.
        """

    def close(self) -> None:
        """Let go of what is in use."""


class FolderSink:
    """Another image store, in a folder."""

    def __init__(self, folder: Path) -> None:
        self._store = ImageStore(folder)

    def put(self, record: ShotRecord, image: bytes) -> Answer:
        """Keep a tagged image. Raises StoreError if the disk does not take it."""
        return self._store.put(record, image, is_tagged=True)

    def close(self) -> None:
        """Let another process write there."""
        self._store.close()


class S3Sink:
    """A bucket, through the library obstore, which is not installed by default."""

    def __init__(self, url: str) -> None:
        try:
            self._module: Any = importlib.import_module('obstore')
            stores: Any = importlib.import_module('obstore.store')
        except ImportError as error:
            raise StoreError(f'{url}: copies to S3 need the package obstore') from error
        self._bucket: Any = stores.from_url(url)
        self._url = url

    def put(self, record: ShotRecord, image: bytes) -> Answer:
        """Keep a tagged image, unless the bucket has it; its record is written last.

        Raises
        ------
        StoreError
            On any failure.
        """
        sha256 = hashlib.sha256(image).hexdigest()
        text = json.dumps(plain_of_record(record)).encode()
        try:
            known = self._known_sha256(record.shot_id + SIDECAR_SUFFIX)
            if known == sha256:
                return Answer(status=Status.DUPLICATE, sha256=sha256)
            if known:
                reason = f'{record.shot_id} is stored already with another image'
                return Answer(status=Status.REJECTED, sha256=sha256, reason=reason)
            self._module.put(self._bucket, record.shot_id + IMAGE_SUFFIX, image)
            self._module.put(self._bucket, record.shot_id + SIDECAR_SUFFIX, text)
        except Exception as error:
            raise StoreError(f'{self._url}: {error}') from error
        return Answer(status=Status.STORED, sha256=sha256)

    def _known_sha256(self, key: str) -> str:
        """Return the checksum in a record of the bucket, empty if there is no record."""
        try:
            content = bytes(self._module.get(self._bucket, key).bytes())
        except FileNotFoundError:
            return ''
        return str(json.loads(content)['sha256'])

    def close(self) -> None:
        """Nothing is held open."""


def token_of_file(path: str) -> str:
    """Return the token that a file holds; without a file there is none.

    Raises
    ------
    StoreError
        If the file cannot be read, others could read it too, or the token is weak.
    """
    if not path:
        return ''
    try:
        return read_token(Path(path))
    except SecretFileError as error:
        raise StoreError(f'token file {error}') from error


def open_sink(url: str, token: str = '') -> Sink:
    """Return what keeps photographs at `url`: a path, file, http, https or s3 URL.

    Raises
    ------
    StoreError
        If the scheme is not known or it cannot be opened.
    """
    parts = urlsplit(url)
    if parts.scheme in ('', 'file'):
        return FolderSink(Path(url if not parts.scheme else url2pathname(parts.path)))
    if parts.scheme in ('http', 'https'):
        return HttpSink(url, token)
    if parts.scheme == 's3':
        return S3Sink(url)
    raise StoreError(f'{url}: scheme {parts.scheme} is none of file, http, https, s3')
