# SPDX-License-Identifier: Apache-2.0
"""Secrets from files that only their owner can read: keys and tokens."""

import math
import string
from pathlib import Path
from stat import S_IMODE

from rocsafe_geo.storage.named_file import require_file

# A file with one key or token has at most so many bytes.
LARGEST_FILE = 4096
FEWEST_BITS = 128
# Fewer different letters are a typed pattern, not a random text.
FEWEST_LETTERS = 8
# Alphabets of random texts, the smallest first: hexadecimal digits, Base64, all that is printed.
_ALPHABETS = (
    frozenset(string.hexdigits.lower()),
    frozenset(string.ascii_letters + string.digits + '+/=-_'),
    frozenset(string.ascii_letters + string.digits + string.punctuation),
)


class SecretFileError(ValueError):
    """A secret is unreadable, readable by others, or weak; the message never contains its text."""


def read_secret(path: Path, largest: int = LARGEST_FILE) -> bytes:
    """Return the content of a file that only its owner can read.

    Parameters
    ----------
    largest
        Most bytes that it may have.

    Raises
    ------
    SecretFileError
        Naming the file and its mode or size, never its content.
    """
    try:
        require_file(path)
        mode = S_IMODE(path.stat().st_mode)
        if mode & 0o077:
            raise SecretFileError(f'{path} has mode {mode:04o}: must be 0600')
        with path.open('rb') as file:
            content = file.read(largest + 1)
    except OSError as error:
        raise SecretFileError(f'{path}: {error.strerror}') from error
    if len(content) > largest:
        raise SecretFileError(f'{path} is larger than {largest} bytes')
    return content


def read_token(path: Path) -> str:
    """Return the token in a file that only its owner can read: a random text of 128 bits or more.

    That is 32 hexadecimal digits, 22 letters of Base64, or 20 of all that can be printed.

    Raises
    ------
    SecretFileError
        Naming the file, and its mode or how strong the token is, never the token.
    """
    try:
        token = read_secret(path).decode('ascii').strip()
    except UnicodeDecodeError:
        # Not chained: the cause would quote the content of the file.
        raise SecretFileError(f'{path}: a token must be ASCII text') from None
    if not token:
        raise SecretFileError(f'{path} is empty: must hold a token')
    bits = _bits_of(token)
    if bits < FEWEST_BITS:
        raise SecretFileError(
            f'{path}: the token has at most {bits:.0f} bits: must have {FEWEST_BITS}, '
            'for instance by: openssl rand -hex 32'
        )
    return token


def _bits_of(token: str) -> float:
    """Return the largest number of bits that a random text like `token` can hold."""
    letters = set(token)
    if len(letters) < FEWEST_LETTERS:
        return len(letters) * math.log2(len(_ALPHABETS[-1]))
    for alphabet in _ALPHABETS:
        if letters <= alphabet:
            return len(token) * math.log2(len(alphabet))
    return 0.0
