# SPDX-License-Identifier: Apache-2.0
"""Events to a TAK server: by TLS, with certificates of both sides, again after a break."""

import datetime
import socket
import ssl
import threading
import time
from collections.abc import Callable, Iterator
from dataclasses import replace
from pathlib import Path
from xml.etree import ElementTree

import pytest
from cryptography import x509
from cryptography.hazmat.primitives import hashes, serialization
from cryptography.hazmat.primitives.asymmetric import ec
from cryptography.x509.oid import NameOID
from test.console.stage import Stage

from rocsafe_console.errors import ConsoleError
from rocsafe_console.outward.event_target import target_of
from rocsafe_console.web.server import ServerThread

DEADLINE_S = 30.0
DAY = datetime.timedelta(days=1)


class Authority:
    """Signs certificates, as that of a TAK server does."""

    def __init__(self, folder: Path, name: str) -> None:
        self.folder, self.key = folder, ec.generate_private_key(ec.SECP256R1())
        self.name = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
        self.path = folder / f'{name}.pem'
        whole = self._certificate(self.name, self.key, is_authority=True)
        self.path.write_bytes(whole.public_bytes(serialization.Encoding.PEM))

    def issue(self, name: str) -> Path:
        """Return a file with a certificate of this name and its key."""
        key = ec.generate_private_key(ec.SECP256R1())
        subject = x509.Name([x509.NameAttribute(NameOID.COMMON_NAME, name)])
        certificate = self._certificate(subject, key, is_authority=False, name=name)
        path = self.folder / f'{name}-of-{self.path.stem}.pem'
        path.write_bytes(
            certificate.public_bytes(serialization.Encoding.PEM)
            + key.private_bytes(
                serialization.Encoding.PEM,
                serialization.PrivateFormat.PKCS8,
                serialization.NoEncryption(),
            )
        )
        return path

    def _certificate(self, subject, key, *, is_authority: bool, name: str = ''):
        now = datetime.datetime.now(datetime.timezone.utc)
        builder = (
            x509.CertificateBuilder()
            .subject_name(subject)
            .issuer_name(self.name)
            .public_key(key.public_key())
            .serial_number(x509.random_serial_number())
            .not_valid_before(now - DAY)
            .not_valid_after(now + DAY)
            .add_extension(x509.BasicConstraints(ca=is_authority, path_length=None), critical=True)
        )
        if name:
            names = x509.SubjectAlternativeName([x509.DNSName(name)])
            builder = builder.add_extension(names, critical=False)
        return builder.sign(self.key, hashes.SHA256())


class TakServer:
    """A server that takes events of whoever has a certificate of its authority."""

    def __init__(self, authority: Authority) -> None:
        self._context = ssl.SSLContext(ssl.PROTOCOL_TLS_SERVER)
        self._context.load_cert_chain(authority.issue('takserver'))
        self._context.load_verify_locations(authority.path)
        self._context.verify_mode = ssl.CERT_REQUIRED
        self._listener = socket.create_server(('127.0.0.1', 0))
        self.port = self._listener.getsockname()[1]
        self.heard: list[bytes] = []
        self.names: list[str] = []
        self.connection: ssl.SSLSocket | None = None
        threading.Thread(target=self._serve, daemon=True).start()

    def close(self) -> None:
        """Listen no more."""
        self._listener.close()

    def events(self) -> list[ElementTree.Element]:
        """Return the whole events of the newest connection."""
        text = self.heard[-1].decode() if self.heard else ''
        whole = text[: text.rfind('</event>') + len('</event>')] if '</event>' in text else ''
        return [ElementTree.fromstring(line) for line in whole.split('\n') if '<event' in line]  # noqa: S314 - our own

    def _serve(self) -> None:
        while True:
            try:
                plain, _ = self._listener.accept()
            except OSError:
                return
            try:
                self.connection = self._context.wrap_socket(plain, server_side=True)
                subject = dict(pair[0] for pair in self.connection.getpeercert()['subject'])
                self.names.append(subject['commonName'])
                self.heard.append(b'')
                while data := self.connection.recv(65536):
                    self.heard[-1] += data
            except OSError:
                plain.close()


@pytest.fixture
def tak(tmp_path) -> Iterator[tuple[Stage, TakServer, Authority]]:
    """Return a mission, a TAK server, and its authority."""
    authority = Authority(tmp_path, 'tak-ca')
    server = TakServer(authority)
    stage = Stage(tmp_path)
    stage.begin()
    yield stage, server, authority
    server.close()


def served_to(stage: Stage, server: TakServer, identity: Path, authority: Path, name: str):
    """Serve the mission, and send its events; return the server and what it has said."""
    address = f'tls://127.0.0.1:{server.port}'
    target = target_of(address, identity, authority, name)
    stage.context.options = replace(stage.context.options, cursor_on_target=target)
    said: list[str] = []
    return ServerThread(stage.context, said.append), said


def until(condition: Callable[[], bool], what: str) -> None:
    """Wait for a condition."""
    end_s = time.monotonic() + DEADLINE_S
    while not condition():
        assert time.monotonic() < end_s, what
        time.sleep(0.02)


@pytest.mark.slow
def test_events_reach_a_tak_server_and_again_after_a_break(tak):
    """With the certificate of the console; each is whole XML; the break is said once."""
    stage, server, authority = tak
    console, said = served_to(
        stage, server, authority.issue('console'), authority.path, 'takserver'
    )
    until(lambda: len(server.events()) >= 8, 'events')
    kinds = {event.get('type') for event in server.events()}
    assert {'a-f-A-M-H-Q', 'b-m-p-s-m', 'u-d-f'} <= kinds
    assert server.names == ['console']
    assert not said
    server.connection.shutdown(socket.SHUT_RDWR)
    stage.step()
    until(lambda: len(server.names) == 2 and len(server.events()) >= 5, 'events again')
    assert len(said) == 1
    assert f'tls://127.0.0.1:{server.port}' in said[0]
    console.close()


@pytest.mark.slow
@pytest.mark.parametrize('wrong', ['authority', 'identity', 'name'])
def test_nothing_is_sent_where_a_certificate_does_not_fit(tak, wrong, tmp_path):
    """A server that others have signed, that has another name, or that does not know us."""
    stage, server, authority = tak
    other = Authority(tmp_path, 'other-ca')
    identity = (other if wrong == 'identity' else authority).issue('console')
    trusted = (other if wrong == 'authority' else authority).path
    name = 'another.example' if wrong == 'name' else 'takserver'
    console, said = served_to(stage, server, identity, trusted, name)
    until(lambda: bool(said), 'the fault is said')
    assert not server.heard
    assert '\n' not in said[0]
    console.close()


def test_what_cannot_be_used_is_told_at_the_start(tmp_path):
    """Before anything is served: address, files, and which of them are needed."""
    authority = Authority(tmp_path, 'tak-ca')
    identity = authority.issue('console')
    (tmp_path / 'text').write_text('no certificate')
    for arguments, words in (
        (('here', None, None, ''), 'must be HOST:PORT'),
        (('tls://h:0', identity, authority.path, ''), 'must be HOST:PORT'),
        (('tls://h:8089', identity, None, ''), 'both are needed'),
        (('h:8089', identity, authority.path, ''), 'none without it'),
        (('tls://h:8089', tmp_path / 'none', authority.path, ''), 'none: cannot be used'),
        (('tls://h:8089', tmp_path / 'text', authority.path, ''), 'text: cannot be used'),
        (('tls://h:8089', authority.path, authority.path, ''), 'tak-ca.pem: cannot be used'),
        (('tls://h:8089', identity, tmp_path / 'text', ''), 'text: cannot be used'),
    ):
        with pytest.raises(ConsoleError, match=words) as error:
            target_of(*arguments)
        assert '\n' not in str(error.value)
    assert str(target_of('239.2.3.1:6969', None, None, '')) == '239.2.3.1:6969'
