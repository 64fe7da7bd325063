# SPDX-License-Identifier: Apache-2.0
"""Localising beside a node's event loop: one thread at a time."""

import threading
from collections.abc import Callable

from rocsafe_radiation.products.assessment import Picture


class LocalizationJob:
    """Runs `work` in a thread of its own from now on; the thread ends with the process."""

    def __init__(self, work: Callable[[], Picture]) -> None:
        self._work = work
        self._results: list[Picture] = []
        self._errors: list[BaseException] = []
        self._thread = threading.Thread(target=self._run, name='localizing', daemon=True)
        self._thread.start()

    @property
    def is_done(self) -> bool:
        """Whether the result, or the error, is there."""
        return bool(self._results or self._errors)

    def result(self) -> Picture:
        """Return what the work returned, or raise what it raised; only when it is done."""
        if self._errors:
            raise self._errors[0]
        return self._results[0]

    def _run(self) -> None:
        try:
            self._results.append(self._work())
        except BaseException as error:  # noqa: BLE001 - handed to whoever asks for the result
            self._errors.append(error)
