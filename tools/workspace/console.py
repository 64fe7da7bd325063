# SPDX-License-Identifier: Apache-2.0
"""Output for the user: one line per step, with its duration."""

import time
from collections.abc import Iterator
from contextlib import contextmanager

_COLUMN = 66


def say(text: str) -> None:
    """Print one line."""
    print(f'setup: {text}', flush=True)


@contextmanager
def step(text: str) -> Iterator[None]:
    """Print `text` now and the seconds that the block took when it is done."""
    start = time.monotonic()
    print(f'setup: {text:<{_COLUMN}} ', end='', flush=True)
    try:
        yield
    except BaseException:
        print(flush=True)
        raise
    print(f'{time.monotonic() - start:6.1f} s', flush=True)
