# SPDX-License-Identifier: Apache-2.0
"""All open requests of a mission."""

from collections.abc import Iterator

from rocsafe_orchestrator.mission_state.request import Order, OrderKind, Request, Status

# These take long to answer, and the server carries out every repetition.
SLOW_ORDERS = (OrderKind.SAVE_MOSAIC, OrderKind.WRITE_PRODUCTS)
SLOW_REPEAT_S = 5.0


class RequestBook:
    """Keeps one request for each order; `repeat_s` as for `Request`."""

    def __init__(self, repeat_s: float) -> None:
        self._repeat_s = repeat_s
        self._requests: dict[Order, Request] = {}

    def __iter__(self) -> Iterator[Request]:
        return iter(self._requests.values())

    def get(self, kind: OrderKind, vehicle: str = '') -> Request | None:
        """Return the request for an order, None if there is none."""
        return self.of(Order(kind=kind, vehicle=vehicle))

    def of(self, order: Order) -> Request | None:
        """Return the request for `order`, None if there is none."""
        return self._requests.get(order)

    def add(self, kind: OrderKind, server: str, vehicle: str = '') -> None:
        """Add a request to `server` unless there is one for this order."""
        order = Order(kind=kind, vehicle=vehicle)
        if order not in self._requests:
            repeat_s = SLOW_REPEAT_S if kind in SLOW_ORDERS else self._repeat_s
            self._requests[order] = Request(order, server, repeat_s)

    def renew(self, kind: OrderKind, server: str, vehicle: str = '') -> None:
        """Add a request to `server`, in place of an earlier one for this order."""
        self._requests.pop(Order(kind=kind, vehicle=vehicle), None)
        self.add(kind, server, vehicle)

    def forget(self) -> None:
        """Drop all requests."""
        self._requests = {}

    def due(self, now_s: float) -> list[Order]:
        """Return the orders to send now."""
        return [order for order, request in self._requests.items() if request.is_due(now_s)]

    def finish(self, kind: OrderKind, vehicle: str = '') -> None:
        """Note that an order was carried out, if it is open."""
        if (request := self.get(kind, vehicle)) is not None:
            request.finish()

    def of_kind(self, kind: OrderKind) -> list[Request]:
        """Return all requests of one kind."""
        return [request for order, request in self._requests.items() if order.kind is kind]

    def all_done(self, kind: OrderKind) -> bool:
        """Return whether all of one kind are answered; without routes, flying is done at once."""
        requests = self.of_kind(kind)
        is_flight = kind is OrderKind.FLY
        return (bool(requests) or is_flight) and all(r.status is Status.DONE for r in requests)
