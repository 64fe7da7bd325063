# SPDX-License-Identifier: Apache-2.0
"""Orders in two steps: nothing is sent without a confirmation, nothing twice."""

import pytest

from rocsafe_console.errors import RefusedError
from rocsafe_console.orders.order_book import (
    CONFIRM_S,
    TARGETS,
    Order,
    OrderBook,
    Outcome,
    Result,
    Target,
    stale,
)
from rocsafe_console.people.roles import VERBS, Action

ID = 'a' * 32


def order(verb: Action = Action.HOLD, **more) -> Order:
    """Return an order to one vehicle."""
    values = {
        'request_id': ID, 'session': 's1', 'user': 'anna', 'verb': verb, 'revisions': {'rav1': 3},
    }  # fmt: skip
    return Order(**{**values, **more})


def test_an_order_is_confirmed_once():
    """The second confirmation sends nothing, and gets the same results."""
    book = OrderBook()
    assert book.prepare(order(), 0.0) == CONFIRM_S
    assert book.confirm(ID, 's1', 1.0) == order()
    results = (Result(vehicle='rav1', outcome=Outcome.DONE),)
    book.finish(ID, results)
    assert book.confirm(ID, 's1', 2.0) is None
    assert book.results(ID) == results


def test_an_order_that_was_prepared_twice_is_one():
    """The same id with something else in it is refused, also after it was sent."""
    book = OrderBook()
    until_s = book.prepare(order(), 0.0)
    assert book.prepare(order(), 3.0) == until_s
    with pytest.raises(RefusedError, match='another one'):
        book.prepare(order(Action.LAND), 3.0)
    book.confirm(ID, 's1', 4.0)
    book.prepare(order(), 100.0)
    assert book.confirm(ID, 's1', 100.0) is None


@pytest.mark.parametrize(
    ('request_id', 'session', 'now_s', 'words'),
    [
        ('b' * 32, 's1', 1.0, 'none is waiting'),
        (ID, 's2', 1.0, 'none is waiting'),
        (ID, 's1', CONFIRM_S + 0.1, 'not confirmed within'),
    ],
)
def test_a_confirmation_that_fits_no_order_is_refused(request_id, session, now_s, words):
    """Another id, another session, or too late."""
    book = OrderBook()
    book.prepare(order(), 0.0)
    with pytest.raises(RefusedError, match=words):
        book.confirm(request_id, session, now_s)


@pytest.mark.parametrize(
    'verb', sorted(VERBS - TARGETS.keys() - {Action.REPLAN}, key=lambda verb: verb.value)
)
def test_a_vehicle_that_has_moved_on_is_left_out_unless_it_is_to_hold(verb):
    """A hold makes no state more dangerous, and must not wait for a second look."""
    found = stale(order(verb, revisions={'rav1': 3, 'rav2': 5}), {'rav1': 4, 'rav2': 5})
    names = [result.vehicle for result in found]
    assert names == ([] if verb is Action.HOLD else ['rav1'])


@pytest.mark.parametrize(
    ('change', 'words'),
    [
        ({'request_id': 'short'}, 'request_id'),
        ({'request_id': 'x' * 31 + ';'}, 'request_id'),
        ({'verb': Action.LAUNCH}, 'no order to a vehicle'),
        ({'revisions': {}}, 'one or more'),
        ({'verb': Action.GO_TO}, 'target'),
        ({'target': Target(latitude_deg=0.0, longitude_deg=0.0, height_m=50.0)}, 'target'),
    ],
)
def test_an_order_that_makes_no_sense_is_refused(change, words):
    """By the name of what is wrong."""
    with pytest.raises(ValueError, match=words):
        order(**change)


def test_a_target_is_on_the_earth_and_at_a_height_of_flight():
    """Limits of go_to, and that it is for one vehicle."""
    for values in ((91.0, 0.0, 50.0), (0.0, 181.0, 50.0), (0.0, 0.0, 1.0), (0.0, 0.0, 900.0)):
        with pytest.raises(ValueError, match='must be'):
            Target(latitude_deg=values[0], longitude_deg=values[1], height_m=values[2])
    target = Target(latitude_deg=0.0, longitude_deg=0.0, height_m=50.0)
    with pytest.raises(ValueError, match='one vehicle'):
        order(Action.GO_TO, target=target, revisions={'rav1': 1, 'rav2': 1})
