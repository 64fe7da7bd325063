# SPDX-License-Identifier: Apache-2.0
"""One mission at a time in a ROS domain of this machine."""

import fcntl
import os
import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.processes.company import company_text

# Descriptors of the locks that are held. A forked process must not keep them open.
_held: set[int] = set()


def _let_go() -> None:
    for descriptor in _held:
        os.close(descriptor)
    _held.clear()


os.register_at_fork(after_in_child=_let_go)


@contextmanager
def domain_lock(domain: str, holder: str, folder: Path | None = None) -> Iterator[None]:
    """Lock the domain; the kernel releases the lock when this process ends, in any way.

    Parameters
    ----------
    domain
        Value of ``ROS_DOMAIN_ID``.
    holder
        Who holds it, for those who are refused.
    folder
        Where the lock file lies, by default the system's folder for temporary files.

    Raises
    ------
    SetupError
        If another mission of this user holds it.
    """
    folder = Path(tempfile.gettempdir()) if folder is None else folder
    path = folder / f'rocsafe-{os.getuid()}-domain-{domain}.lock'
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise SetupError(f'{path}: cannot be opened: {error.strerror}') from error
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except BlockingIOError as error:
        who = os.pread(descriptor, 200, 0).decode('utf-8', errors='replace')
        os.close(descriptor)
        raise SetupError(company_text(who)) from error
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, holder.encode(), 0)
    _held.add(descriptor)
    try:
        yield
    finally:
        _held.discard(descriptor)
        os.close(descriptor)
