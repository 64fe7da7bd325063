# SPDX-License-Identifier: Apache-2.0
"""Localising beside a node's event loop: one thread at a time."""

import threading
from collections.abc import Callable
from dataclasses import dataclass

from rocsafe_radiation.cordon import DEFAULT_LEVELS_USVH
from rocsafe_radiation.dose_map import DoseMap, dose_map
from rocsafe_radiation.localization import Localization, LocalizationOptions, localize
from rocsafe_radiation.survey import Survey

# As many bytes of a message; files hold finer maps.
LARGEST_CELLS = 40_000


@dataclass(frozen=True, slots=True, kw_only=True)
class Picture:
    """What the readings so far say: sources and the dose rates that follow."""

    found: Localization
    dose: DoseMap


def picture_of(survey: Survey, options: LocalizationOptions) -> Picture:
    """Return the picture of `survey`.

    Raises
    ------
    TooFewReadingsError: if there are too few readings.
    """
    found = localize(survey, options)
    level = min(DEFAULT_LEVELS_USVH)
    return Picture(
        found=found,
        dose=dose_map(found, survey, options.kernel, level, largest_cells=LARGEST_CELLS),
    )


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
