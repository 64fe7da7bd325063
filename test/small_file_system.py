# SPDX-License-Identifier: Apache-2.0
"""A real disk that is small: a tmpfs."""

import subprocess
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest


@contextmanager
def small_file_system(folder: Path, *, megabytes: int) -> Iterator[Path]:
    """Mount a file system of so many megabytes at a new folder; skip where none can be mounted."""
    folder.mkdir()
    mounting = ['mount', '-t', 'tmpfs', '-o', f'size={megabytes}m', 'none', str(folder)]
    try:
        done = subprocess.run(mounting, capture_output=True, text=True, timeout=10, check=False)
    except OSError as error:
        pytest.skip(f'no command mount: {error}')
    if done.returncode != 0:
        pytest.skip(f'no tmpfs can be mounted here: {done.stderr.strip()}')
    try:
        yield folder
    finally:
        subprocess.run(['umount', '--lazy', str(folder)], timeout=10, check=True)
