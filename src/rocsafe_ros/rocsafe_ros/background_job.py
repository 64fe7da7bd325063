# SPDX-License-Identifier: Apache-2.0
"""Work beside a node's event loop, so that no callback blocks."""

import threading
from collections.abc import Callable
from concurrent.futures import Future
from typing import TypeVar

T = TypeVar('T')


def start_job(work: Callable[[], T], name: str) -> 'Future[T]':
    """Start `work` in a thread of its own and return its future result.

    The thread is a daemon: the process may end before the work is done, which the threads of a
    `concurrent.futures` executor would prevent.

    Parameters
    ----------
    work
        What to do. Its error is raised by `Future.result`.
    name
        Name of the thread.
    """
    future: Future[T] = Future()

    def run() -> None:
        try:
            future.set_result(work())
        except BaseException as error:  # noqa: BLE001 - handed to whoever asks for the result
            future.set_exception(error)

    threading.Thread(target=run, name=name, daemon=True).start()
    return future
