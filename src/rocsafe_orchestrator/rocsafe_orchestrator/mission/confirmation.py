# SPDX-License-Identifier: Apache-2.0
"""What waits for a person: real vehicles move only by a plan or a task that was confirmed."""

from collections.abc import Callable
from dataclasses import dataclass


@dataclass(frozen=True, slots=True, kw_only=True)
class Confirmation:
    """Something to be confirmed.

    Attributes
    ----------
    digest
        Hash of it, which `rocsafe run --confirm` takes.
    what, file
        Word for it, and the file of the run that tells it.
    text
        What real vehicles do once it is confirmed.
    accept, refuse
        Called when it is confirmed, and with the reason when it is not.
    """

    digest: str
    what: str
    file: str
    text: str
    accept: Callable[[], None]
    refuse: Callable[[str], None]
