# SPDX-License-Identifier: Apache-2.0
"""Recorded inputs in their order, never faster than the nodes process them."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

# Less than a publisher keeps (`MEASUREMENTS_KEPT` in `rocsafe_ros.interfaces.qos`): none is lost.
MOST_READINGS = 40
MOST_SHOTS = 4
# A photograph without a receipt is sent again after this wall time.
RESEND_S = 2.0


@dataclass(frozen=True, slots=True, order=True)
class RecordedReading:
    """A reading of a vehicle as serialised message; `time_ns` is its stamp."""

    time_ns: int
    vehicle: str
    data: bytes


@dataclass(frozen=True, slots=True, order=True)
class StoredShot:
    """A photograph of the image store."""

    time_ns: int
    vehicle: str
    shot_id: str


Input = RecordedReading | StoredShot


class Feed:
    """Hands out inputs in the order of their times.

    Parameters
    ----------
    inputs
        All inputs, in any order.
    """

    def __init__(self, inputs: Iterable[Input]) -> None:
        self._waiting = sorted(inputs, key=lambda given: (given.time_ns, given.vehicle))[::-1]
        self._readings: dict[str, list[int]] = {}
        self._shots: dict[str, tuple[StoredShot, float]] = {}

    @property
    def left(self) -> int:
        """Number of inputs that were not taken in yet."""
        return len(self._waiting) + len(self._shots) + sum(map(len, self._readings.values()))

    def has_less_than(self, count: int) -> bool:
        """Return whether fewer inputs than `count` are left."""
        return self.left < count

    def due(self, now_s: float) -> Iterator[Input]:
        """Yield the inputs to publish now; `now_s` is wall time."""
        for name, (shot, sent_s) in self._shots.items():
            if now_s - sent_s >= RESEND_S:
                self._shots[name] = (shot, now_s)
                yield shot
        while self._waiting and self._has_room(self._waiting[-1]):
            given = self._waiting.pop()
            if isinstance(given, StoredShot):
                self._shots[given.shot_id] = (given, now_s)
            else:
                self._readings.setdefault(given.vehicle, []).append(given.time_ns)
            yield given

    def on_receipt(self, shot_id: str) -> None:
        """Note that a photograph was stored or refused."""
        self._shots.pop(shot_id, None)

    def on_dose_rate(self, vehicle: str, time_ns: int) -> None:
        """Note that the readings of a vehicle up to a time were taken in."""
        waiting = self._readings.get(vehicle, [])
        self._readings[vehicle] = [at_ns for at_ns in waiting if at_ns > time_ns]

    def _has_room(self, given: Input) -> bool:
        if isinstance(given, StoredShot):
            return len(self._shots) < MOST_SHOTS
        return len(self._readings.get(given.vehicle, ())) < MOST_READINGS
