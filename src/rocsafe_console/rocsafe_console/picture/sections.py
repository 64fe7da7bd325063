# SPDX-License-Identifier: Apache-2.0
"""Parts of the picture that change rarely: each has a version, and is encoded once."""

import json
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any

from rocsafe_geo.storage.json_values import finite

# Sections that pages get at once, not with the next tick.
URGENT = frozenset({'alarms'})


class Sections:
    """Named values as JSON texts, with the number of the change that made each.

    A client that has seen change `n` needs the sections after it and no other.

    Attributes
    ----------
    on_urgent
        Called when an urgent section has changed.
    """

    def __init__(self) -> None:
        self.on_urgent: Callable[[], object] = lambda: None
        self.newest = 0
        self._texts: dict[str, str] = {}
        self._changes: dict[str, int] = {}

    def put(self, name: str, value: Any) -> bool:
        """Set the section `name`; return whether it differs from before. NaN becomes null."""
        text = json.dumps(finite(value), separators=(',', ':'), allow_nan=False)
        if self._texts.get(name) == text:
            return False
        self.newest += 1
        self._texts[name] = text
        self._changes[name] = self.newest
        if name in URGENT:
            self.on_urgent()
        return True

    def drop(self, names: Iterable[str]) -> None:
        """Remove sections; whoever has them learns it by null."""
        for name in names:
            if name in self._texts:
                self.put(name, None)

    def value(self, name: str) -> Any:
        """Return the value of a section as clients have it, None if there is none."""
        return json.loads(self._texts[name]) if name in self._texts else None

    def after(self, change: int) -> Mapping[str, str]:
        """Return the JSON texts of the sections that changed after `change`."""
        return {name: self._texts[name] for name, n in self._changes.items() if n > change}


def message_of(texts: Mapping[str, str], kind: str = 'sections') -> str:
    """Return one JSON message that holds sections as they are encoded."""
    parts = ','.join(f'{json.dumps(name)}:{text}' for name, text in texts.items())
    return f'{{"kind":{json.dumps(kind)},"sections":{{{parts}}}}}'


def placed(found: Iterable[Mapping[str, Any]]) -> Iterator[Mapping[str, Any]]:
    """Yield the values of a section whose ``place`` is known: what is not known is None."""
    return (one for one in found if None not in one['place'])
