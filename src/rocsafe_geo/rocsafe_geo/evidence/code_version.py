# SPDX-License-Identifier: Apache-2.0
"""Version of the code that is running: of its distribution, and of its source if there is one."""

import subprocess
from functools import lru_cache
from importlib import metadata
from pathlib import Path

_GIT_TIMEOUT_S = 5.0


@lru_cache(maxsize=1)
def version_text() -> str:
    """Return the version of ROCSAFE, with the git revision of its source where there is one."""
    try:
        version = metadata.version('rocsafe_geo')
    except metadata.PackageNotFoundError:
        version = 'of unknown version'
    source = Path(__file__).resolve().parent
    revision = git_revision(source)
    if revision is None:
        return f'rocsafe {version}'
    changed = ', with changes that are not committed' if git_is_dirty(source) else ''
    return f'rocsafe {version} (git {revision[:12]}{changed})'


def git_revision(folder: Path) -> str | None:
    """Return the revision that `folder` is checked out at; None outside a checkout."""
    return _git(folder, 'rev-parse', 'HEAD')


def git_is_dirty(folder: Path) -> bool | None:
    """Return whether there are changes that are not committed; None outside a checkout."""
    changes = _git(folder, 'status', '--porcelain', '--untracked-files=no')
    return None if changes is None else bool(changes)


def _git(folder: Path, *arguments: str) -> str | None:
    command = ['git', '-C', str(folder), *arguments]
    try:
        done = subprocess.run(
            command, capture_output=True, text=True, timeout=_GIT_TIMEOUT_S, check=True
        )
    except (OSError, subprocess.SubprocessError):
        return None
    return done.stdout.strip()
