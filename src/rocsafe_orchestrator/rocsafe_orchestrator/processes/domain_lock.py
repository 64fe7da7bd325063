# SPDX-License-Identifier: Apache-2.0
"""Locks that end with their process: one mission a ROS domain of this machine, one a run."""

import fcntl
import os
import tempfile
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from rocsafe_orchestrator.errors import SetupError
from rocsafe_orchestrator.processes.company import company_text

LOCK_POLL_S = 0.02
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
    with file_lock(path, holder, company_text):
        yield


@contextmanager
def file_lock(
    path: Path, holder: str, refusal: Callable[[str], str], wait_s: float = 0.0
) -> Iterator[None]:
    """Lock a file until the end of the block, or of this process; its copies do not hold it.

    Parameters
    ----------
    holder
        Written into the file, for those who are refused.
    refusal
        Returns the text of the error from what the holder wrote.
    wait_s
        For so long the lock is tried again, seconds: those who only look hold it for a moment.

    Raises
    ------
    SetupError
        If another process holds it.
    """
    try:
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT | os.O_CLOEXEC, 0o600)
    except OSError as error:
        raise SetupError(f'{path}: cannot be opened: {error.strerror}') from error
    try:
        _lock(descriptor, time.monotonic() + wait_s)
    except BlockingIOError as error:
        who = os.pread(descriptor, 200, 0).decode('utf-8', errors='replace')
        os.close(descriptor)
        raise SetupError(refusal(who)) from error
    os.ftruncate(descriptor, 0)
    os.pwrite(descriptor, holder.encode(), 0)
    _held.add(descriptor)
    try:
        yield
    finally:
        _held.discard(descriptor)
        os.close(descriptor)


def _lock(descriptor: int, end_s: float) -> None:
    """Lock an open file; raises `BlockingIOError` if it is still held at `end_s`."""
    while True:
        try:
            fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            if time.monotonic() >= end_s:
                raise
            time.sleep(LOCK_POLL_S)
        else:
            return
