# SPDX-License-Identifier: Apache-2.0
"""Short hashes of routes and plans, by which a person confirms what real vehicles will fly."""

import hashlib
import json
from collections.abc import Sequence
from typing import Any

DIGITS = 8


def route_digest(plan_id: str, route: Any) -> str:
    """Return the hash of the message of a route: no other route has it, nor does a changed one."""
    return _digest([plan_id, _plain(route)])


def plan_digest(plan_id: str, routes: Sequence[Any]) -> str:
    """Return the hash of all routes of a plan."""
    return _digest([plan_id, *map(_plain, routes)])


def _digest(content: object) -> str:
    # The shortest decimal form of a float reads back as the same float: nothing is rounded.
    return hashlib.sha256(json.dumps(content).encode()).hexdigest()[:DIGITS]


def _plain(value: Any) -> Any:
    if hasattr(value, 'get_fields_and_field_types'):
        return [_plain(getattr(value, name)) for name in value.get_fields_and_field_types()]
    if isinstance(value, Sequence) and not isinstance(value, str):
        return [_plain(each) for each in value]
    return value
