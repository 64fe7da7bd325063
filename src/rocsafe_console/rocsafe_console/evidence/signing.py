# SPDX-License-Identifier: Apache-2.0
"""Where the key lives that signs seals: one of each user of a machine."""

from collections.abc import Mapping
from pathlib import Path

from cryptography.hazmat.primitives.asymmetric.ed25519 import Ed25519PrivateKey

from rocsafe_console.evidence.seal import read_key


def key_path(environment: Mapping[str, str]) -> Path:
    """Return where the signing key of this user lives."""
    home = environment.get('XDG_CONFIG_HOME') or Path(environment.get('HOME', '~')) / '.config'
    return (Path(home) / 'rocsafe' / 'signing.key').expanduser()


def usual_key(environment: Mapping[str, str]) -> Ed25519PrivateKey | None:
    """Return the signing key of this user, None if none was made; raises `EvidenceError`."""
    path = key_path(environment)
    return read_key(path) if path.exists() else None
