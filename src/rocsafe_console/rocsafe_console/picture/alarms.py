# SPDX-License-Identifier: Apache-2.0
"""One list of alarms: what needs somebody's eyes, until somebody has seen it."""

from dataclasses import asdict, dataclass, replace
from typing import Any

MOST_KEPT = 500
WARN, ERROR = 'warning', 'critical'


@dataclass(frozen=True, slots=True, kw_only=True)
class Alarm:
    """Something that an operator must see.

    Attributes
    ----------
    number
        Rises by one with each.
    time_s
        By the clock on the wall, seconds since 1970.
    severity
        ``'warning'`` or ``'critical'``.
    vehicle
        That it is about, empty: the mission.
    text
        For people.
    seen_by, seen_s
        Who has acknowledged it, and when; empty and 0: nobody.
    """

    number: int
    time_s: float
    severity: str
    vehicle: str
    text: str
    seen_by: str = ''
    seen_s: float = 0.0


class Alarms:
    """The alarms of a mission, the newest last.

    Parameters
    ----------
    newest
        Number of the newest alarm before. No number comes twice: who acknowledges an alarm names
        the one that he saw, also after another mission or another process has begun.
    """

    def __init__(self, newest: int = 0) -> None:
        self._alarms: dict[int, Alarm] = {}
        self._newest: dict[tuple[str, str], int] = {}
        self.newest = newest

    def __len__(self) -> int:
        return len(self._alarms)

    def raise_one(self, time_s: float, severity: str, vehicle: str, text: str) -> Alarm | None:
        """Add an alarm and return it; None if the same one is there and nobody has seen it."""
        before = self._alarms.get(self._newest.get((vehicle, text), 0))
        if before is not None and not before.seen_by:
            return None
        self.newest += 1
        alarm = Alarm(
            number=self.newest, time_s=time_s, severity=severity, vehicle=vehicle, text=text
        )
        self._alarms[alarm.number] = alarm
        self._newest[vehicle, text] = alarm.number
        self._forget()
        return alarm

    def of(self, number: int) -> Alarm:
        """Return the alarm of a number; raises `ValueError` if there is none."""
        if number not in self._alarms:
            raise ValueError(f'alarm {number}: there is none')
        return self._alarms[number]

    def acknowledge(self, number: int, who: str, time_s: float) -> Alarm:
        """Note that `who` has seen an alarm, and return it; the first who did stays.

        Raises
        ------
        ValueError
            If there is none of this number.
        """
        alarm = self.of(number)
        if not alarm.seen_by:
            alarm = self._alarms[number] = replace(alarm, seen_by=who, seen_s=time_s)
        return alarm

    def to_plain(self) -> list[dict[str, Any]]:
        """Return all of them, fit for JSON."""
        return [asdict(alarm) for alarm in self._alarms.values()]

    def _forget(self) -> None:
        """Drop the oldest that somebody has seen, or if all are unseen the oldest."""
        if len(self._alarms) <= MOST_KEPT:
            return
        seen = (number for number, alarm in self._alarms.items() if alarm.seen_by)
        number = next(seen, next(iter(self._alarms)))
        gone = self._alarms.pop(number)
        if self._newest[gone.vehicle, gone.text] == number:
            del self._newest[gone.vehicle, gone.text]
