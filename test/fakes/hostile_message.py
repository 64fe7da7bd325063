# SPDX-License-Identifier: Apache-2.0
"""Messages whose values no honest sender has, from a seed: what a node must outlive."""

import re

WILD = (float('nan'), float('inf'), -float('inf'), 0.0, -0.0, -1.0, 1e-300, 1e308, 91.0, 1e7)
TEXTS = ('', 'rav1', '\0', '../../x', 'a' * 5000, '☢', '{"a": 1}', 'rav1/lease')
WHOLE = re.compile(r'(u?)int(\d+)')


def spoil(message, rng, share):
    """Fill a share of the fields of a message, and of those within, with wild values."""
    for name, kind in message.get_fields_and_field_types().items():
        if rng.random() < share:
            setattr(message, name, _wild(kind, getattr(message, name), rng, share))
        elif hasattr(getattr(message, name), 'get_fields_and_field_types'):
            spoil(getattr(message, name), rng, share)
    return message


def _wild(kind, value, rng, share):
    if kind in ('double', 'float'):
        wild = rng.choice(WILD)
        return wild if kind == 'double' or abs(wild) < 1e38 else 3e38
    if (whole := WHOLE.fullmatch(kind)) is not None:
        bits = int(whole[2]) - (whole[1] == '')
        least = 0 if whole[1] else -(2**bits)
        return rng.choice((least, 2**bits - 1, 0, 1, 3))
    if kind == 'boolean':
        return rng.random() < 0.5
    if kind.startswith('string'):
        return rng.choice(TEXTS)
    if hasattr(value, 'get_fields_and_field_types'):
        return spoil(value, rng, share)
    if kind.startswith('sequence'):
        return _sequence(value, rng, share)
    return value


def _sequence(value, rng, share):
    """Return a sequence that is empty, shorter, doubled or has spoiled elements."""
    items = list(value)
    how = rng.randrange(4)
    if how == 0 or not items:
        return []
    if how == 1:
        return items[: rng.randrange(len(items) + 1)]
    if how == 2:
        return items * 2
    return [spoil(one, rng, share) if hasattr(one, 'SLOT_TYPES') else one for one in items]
