# SPDX-License-Identifier: Apache-2.0
"""Files that a user names: what is no file is refused before it is opened."""

import errno
from pathlib import Path


def require_file(path: Path) -> None:
    """Refuse a pipe or a device: opening a pipe waits until somebody writes into it.

    A path at which there is nothing, or a folder, is left to `open`, which refuses both.

    Raises
    ------
    OSError
        Whose `strerror` says so.
    """
    if path.exists() and not (path.is_file() or path.is_dir()):
        raise OSError(errno.EINVAL, 'must be a file, is a pipe or a device', str(path))
