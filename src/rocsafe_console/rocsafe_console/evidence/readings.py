# SPDX-License-Identifier: Apache-2.0
"""Readings and products as the evidence log keeps them: hashes of what was heard, and the most."""

import hashlib
import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

from rocsafe_console.evidence.chain import line_of

DATUM = 'WGS84'
# The log keeps, besides the hash of a product, what was estimated and how sure it is.
_TOLD_KEYS = (
    'stamp_s',
    'plan_id',
    'verdict',
    'doubts',
    'sources',
    'releases',
    'agent',
    'makespan_s',
)


@dataclass(slots=True)
class _Heard:
    count: int = 0
    first_s: float = math.inf
    last_s: float = -math.inf
    highest: Mapping[str, Any] = field(default_factory=dict)
    digest: Any = field(default_factory=hashlib.sha256)


class ReadingsHeard:
    """The readings of each vehicle and unit since the last time that they were taken."""

    def __init__(self) -> None:
        self._heard: dict[tuple[str, str], _Heard] = {}

    def note(self, vehicle: str, unit: str, value: float, reading: Mapping[str, Any]) -> None:
        """Add a reading, which has `stamp_s`."""
        heard = self._heard.setdefault((vehicle, unit), _Heard())
        heard.count += 1
        heard.first_s = min(heard.first_s, reading['stamp_s'])
        heard.last_s = max(heard.last_s, reading['stamp_s'])
        heard.digest.update(line_of(reading) + b'\n')
        if not heard.highest or value > heard.highest['value']:
            heard.highest = {**reading, 'value': value}

    def take(self) -> Iterator[tuple[str, dict[str, Any]]]:
        """Yield vehicle and what the log keeps of it, and forget it."""
        taken, self._heard = self._heard, {}
        for (vehicle, unit), heard in taken.items():
            yield (
                vehicle,
                {
                    'unit': unit,
                    'datum': DATUM,
                    'count': heard.count,
                    'first_s': heard.first_s,
                    'last_s': heard.last_s,
                    'highest': dict(heard.highest),
                    'sha256': heard.digest.hexdigest(),
                },
            )


def product_of(name: str, value: Any) -> dict[str, Any]:
    """Return what the log keeps of a product: its hash, and what it says of itself."""
    data = value if isinstance(value, bytes) else line_of({'value': value})
    told = value if isinstance(value, Mapping) else {}
    return {
        'name': name,
        'datum': DATUM,
        'sha256': hashlib.sha256(data).hexdigest(),
        **{key: told[key] for key in _TOLD_KEYS if key in told},
    }
