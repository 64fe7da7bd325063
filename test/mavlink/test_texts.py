# SPDX-License-Identifier: Apache-2.0
"""Texts longer than a message are told whole, and none is lost for a piece that is."""

import pytest
from test.mavlink.telemetry import said

from rocsafe_mavlink.wire.texts import TextJoiner

LONG = 'RTL: start return at 518 m (30 m above destination) and a further sixty characters more'


def piece(text, number=0, place=0):
    """Return a piece of a text."""
    return said('STATUSTEXT', text=text, id=number, chunk_seq=place, severity=6)


def joined(*pieces, step_s=0.01):
    """Return the texts that come of pieces, and of the time after."""
    joiner = TextJoiner()
    told = [
        one for n, message in enumerate(pieces) for one in joiner.take(message, n * step_s)
    ] + joiner.late(100.0)
    return [one['text'] for one in told]


def test_long_text_is_one():
    """Its pieces are joined, and a short one is told as it is."""
    first, second = piece(LONG[:50], 7, 0), piece(LONG[50:], 7, 1)
    assert joined(first, second) == [LONG]
    assert joined(piece('Armed', 7), piece('Disarmed')) == ['Armed', 'Disarmed']
    # Old autopilots number nothing: what is full is whole.
    assert joined(piece(LONG[:50]), piece('Armed')) == [LONG[:50], 'Armed']


@pytest.mark.parametrize(
    ('pieces', 'told'),
    [
        ([(0, 50, 7, 0)], [LONG[:50]]),
        ([(0, 50, 7, 0), (0, 5, 8, 0)], [LONG[:50], LONG[:5]]),
        ([(50, 60, 7, 1)], [LONG[50:60]]),
        ([(0, 50, 7, 0), (50, 60, 7, 2)], [LONG[:50], LONG[50:60]]),
    ],
    ids=['end', 'end, and another begins', 'beginning', 'middle'],
)
def test_lost_piece_loses_no_other(pieces, told):
    """What came is told, at once or when nothing more follows."""
    sent = [piece(LONG[a:b], number, place) for a, b, number, place in pieces]
    assert joined(*sent) == told


def test_endless_text_ends():
    """Who sends pieces for ever is told in parts."""
    sent = [piece('x' * 50, 7, n) for n in range(25)]
    assert [len(text) for text in joined(*sent)][:1] == [500]
    assert sum(map(len, joined(*sent))) == 1250
