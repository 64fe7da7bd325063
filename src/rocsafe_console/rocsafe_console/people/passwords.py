# SPDX-License-Identifier: Apache-2.0
"""Passwords as Argon2id hashes in the PHC string format (RFC 9106)."""

import base64
import os

from cryptography.exceptions import InvalidKey
from cryptography.hazmat.primitives.kdf.argon2 import Argon2id

FEWEST_LETTERS = 12
MOST_LETTERS = 256
# RFC 9106, section 4, second recommended option.
_PASSES, _LANES, _MEMORY_KIB, _SALT_BYTES, _HASH_BYTES = 3, 4, 64 * 1024, 16, 32


def hash_of(password: str) -> str:
    """Return the hash of a password with a salt of its own.

    Raises
    ------
    ValueError
        If it is shorter than 12 letters or longer than 256; the text is not told.
    """
    if not FEWEST_LETTERS <= len(password) <= MOST_LETTERS:
        raise ValueError(
            f'the password has {len(password)} letters: must have {FEWEST_LETTERS} to '
            f'{MOST_LETTERS}'
        )
    kdf = Argon2id(
        salt=os.urandom(_SALT_BYTES),
        length=_HASH_BYTES,
        iterations=_PASSES,
        lanes=_LANES,
        memory_cost=_MEMORY_KIB,
    )
    return kdf.derive_phc_encoded(password.encode())


def is_right(password: str, hashed: str) -> bool:
    """Return whether `hashed` is of this password; takes about 0.1 s whatever the answer is."""
    try:
        Argon2id.verify_phc_encoded(password[:MOST_LETTERS].encode(), hashed)
    except (InvalidKey, ValueError):
        return False
    return True


def _random_text(count: int) -> str:
    return base64.b64encode(os.urandom(count)).decode().rstrip('=')


# The hash of no password: for names that there are not, so that they take as long.
NOBODY = (
    f'$argon2id$v=19$m={_MEMORY_KIB},t={_PASSES},p={_LANES}'
    f'${_random_text(_SALT_BYTES)}${_random_text(_HASH_BYTES)}'
)
