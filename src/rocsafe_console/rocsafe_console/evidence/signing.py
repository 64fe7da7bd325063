# SPDX-License-Identifier: Apache-2.0
"""Identity of a seal: the key of the user of this machine and the version of the code."""

from collections.abc import Mapping
from importlib.metadata import PackageNotFoundError, version
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


def code_version() -> str:
    """Return the version of this package, ``unknown`` if it is not installed."""
    try:
        return version('rocsafe_console')
    except PackageNotFoundError:
        return 'unknown'
