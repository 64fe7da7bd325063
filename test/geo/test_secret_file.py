# SPDX-License-Identifier: Apache-2.0
"""Secrets come from private files, and weak tokens are refused."""

import secrets

import pytest

from rocsafe_geo.storage.secret_file import SecretFileError, read_secret, read_token


@pytest.fixture
def private(tmp_path):
    """Return what writes a file of mode 0600."""

    def write(content, mode=0o600):
        path = tmp_path / 'secret'
        path.write_bytes(content)
        path.chmod(mode)
        return path

    return write


@pytest.mark.parametrize(
    'token',
    [secrets.token_hex(16), secrets.token_urlsafe(17), secrets.token_hex(64)],
    ids=['128 bits', 'Base64', '512 bits'],
)
def test_strong_token_of_a_private_file_is_read(private, token):
    """128 bits in hexadecimal digits or Base64; the end of the line is not part of it."""
    assert read_token(private(f'{token}\n'.encode())) == token


@pytest.mark.parametrize(
    ('content', 'words'),
    [
        (b'', 'is empty'),
        (b' \n', 'is empty'),
        (b'secret', 'at most'),
        (b'0123456789abcdef0123456789abcde', 'at most 124 bits: must have 128'),
        (b'a' * 64, 'at most 7 bits'),
        (b'abcABCabcABCabcABCabcABCabcABC', 'bits: must have 128'),
        (b'Correct-Horse-Bat', 'at most 103 bits'),
        ('Schlüssel'.encode(), 'must be ASCII text'),
        (b'two words of more than twenty letters', 'at most 0 bits'),
    ],
)
def test_weak_token_is_refused_and_never_told(private, content, words):
    """The line names the file and how strong it is at most."""
    path = private(content)
    with pytest.raises(SecretFileError, match=words) as refusal:
        read_token(path)
    assert str(path) in str(refusal.value)
    text = content.decode(errors='ignore').strip()
    assert not text or text not in str(refusal.value).replace(str(path), '')


@pytest.mark.parametrize('mode', [0o640, 0o604, 0o644, 0o660, 0o777])
def test_file_that_others_can_read_is_refused_with_its_mode(private, mode):
    """Before it is read."""
    with pytest.raises(SecretFileError, match=f'has mode {mode:04o}: must be 0600'):
        read_secret(private(b'x', mode))


def test_missing_file_is_named(tmp_path):
    """In one line."""
    with pytest.raises(SecretFileError, match='none: No such file'):
        read_token(tmp_path / 'none')
