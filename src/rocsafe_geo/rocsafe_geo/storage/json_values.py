# SPDX-License-Identifier: Apache-2.0
"""Values that JSON can hold."""

import math
from typing import Any


def finite(value: Any) -> Any:
    """Return dictionaries and lists with None for each number in them that is not finite."""
    if isinstance(value, dict):
        return {name: finite(part) for name, part in value.items()}
    if isinstance(value, (list, tuple)):
        return [finite(part) for part in value]
    return None if isinstance(value, float) and not math.isfinite(value) else value
