# SPDX-License-Identifier: Apache-2.0
"""Times in files of settings."""

import re
from datetime import datetime, timezone
from typing import Any


def time_of_text(value: Any) -> Any:
    """Return the time in a quoted ISO 8601 text; any other value unchanged."""
    if not isinstance(value, str):
        return value
    try:
        # Python 3.10 does not know the Z.
        return datetime.fromisoformat(re.sub('[Zz]$', '+00:00', value))
    except ValueError:
        return value


def in_utc(time: datetime) -> datetime:
    """Return a time in UTC.

    Raises
    ------
    ValueError
        If it does not say its zone, or UTC has no such year.
    """
    if time.tzinfo is None:
        raise ValueError('must say its time zone, for instance 2025-06-01T10:00:00Z')
    try:
        return time.astimezone(timezone.utc)
    except OverflowError as error:
        raise ValueError('must be within the years 1 to 9999 in UTC') from error
