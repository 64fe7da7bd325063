# SPDX-License-Identifier: Apache-2.0
"""Dose of a vehicle, and the levels of dose rate and dose that it has reached."""

import math
from dataclasses import dataclass

from rocsafe_geo.time_units import NS_PER_S

S_PER_H = 3600.0
DOSE_RATE, DOSE = 'dose rate', 'dose'
# Names of levels, microsievert per hour and microsievert: EPR-First Responders and GSR Part 7 of
# the IAEA, ICRP 103, and the cordon of German responders.
NAMED_DOSE_RATES_USVH = {
    25.0: 'cordon (German responders)',
    100.0: 'inner cordon (IAEA)',
    1e5: 'turn back (IAEA)',
}
NAMED_DOSES_USV = {
    1e3: 'public, year (ICRP)',
    2e4: 'worker, year (ICRP)',
    5e4: 'emergency worker (IAEA)',
    1e5: 'to avert a large collective dose (IAEA)',
    5e5: 'life saving (IAEA)',
}
DEFAULT_DOSE_RATES_USVH = (25.0, 100.0, 1000.0, 1e5)
DEFAULT_DOSES_USV = tuple(NAMED_DOSES_USV)
# A vehicle turns back at the dose rate at which people do, 100 mSv/h (EPR-First Responders of the
# IAEA), so that it can still be touched and its way home be walked; and at a dose that parts which
# are not hardened bear, 10 Gy (1 krad: commercial parts fail from some krad on).
DEFAULT_TURN_BACK_USVH = 1e5
DEFAULT_VEHICLE_BUDGET_USV = 1e7
# Readings scatter: a level is left only well below it.
CLEARED_SHARE = 0.8


@dataclass(frozen=True, slots=True, kw_only=True)
class Exposure:
    """One reading: the end of its window, its length (0: an instant), and what was read."""

    time_ns: int
    window_s: float
    dose_rate_usvh: float
    is_saturated: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Alarm:
    """A level reached or left with `value`, both in microsievert or microsievert per hour.

    The vehicle is to return where it `turns_back`.
    """

    quantity: str
    threshold: float
    value: float
    is_reached: bool
    turns_back: bool = False

    @property
    def name(self) -> str:
        """Name of the level."""
        is_dose = self.quantity == DOSE
        names = NAMED_DOSES_USV if is_dose else NAMED_DOSE_RATES_USVH
        return names.get(self.threshold, f'{self.threshold:g} uSv{"" if is_dose else "/h"}')


@dataclass(frozen=True, slots=True, kw_only=True)
class AlarmLevels:
    """Levels of dose rate and of dose, and the longest gap between readings that is bridged.

    At `turn_back_usvh` and at `vehicle_budget_usv` the vehicle is to return; 0: never.
    """

    dose_rates_usvh: tuple[float, ...] = DEFAULT_DOSE_RATES_USVH
    doses_usv: tuple[float, ...] = DEFAULT_DOSES_USV
    turn_back_usvh: float = DEFAULT_TURN_BACK_USVH
    vehicle_budget_usv: float = DEFAULT_VEHICLE_BUDGET_USV
    largest_gap_s: float = 5.0

    def __post_init__(self) -> None:
        for name in ('turn_back_usvh', 'vehicle_budget_usv'):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise ValueError(f'{name} = {getattr(self, name)} must be at least 0 and finite')
        for name in ('dose_rates_usvh', 'doses_usv'):
            for level in getattr(self, name):
                if not 0.0 < level < math.inf:
                    raise ValueError(f'{name} = {level} must be above 0 and finite')
        if not 0.0 <= self.largest_gap_s < math.inf:
            raise ValueError(f'largest_gap_s = {self.largest_gap_s} must be at least 0')

    @property
    def all(self) -> tuple[tuple[str, float], ...]:
        """Quantity and value of each level, those to turn back at included, ascending."""
        rates = {*self.dose_rates_usvh, self.turn_back_usvh} - {0.0}
        doses = {*self.doses_usv, self.vehicle_budget_usv} - {0.0}
        return (
            *((DOSE_RATE, level) for level in sorted(rates)),
            *((DOSE, level) for level in sorted(doses)),
        )

    def turns_back(self, quantity: str, level: float) -> bool:
        """Return whether a vehicle is to return at a level, or at a higher one."""
        limit = self.turn_back_usvh if quantity == DOSE_RATE else self.vehicle_budget_usv
        return 0.0 < limit <= level


class Dosimeter:
    """Adds up the dose of one vehicle over its readings, in the order of their stamps.

    A window adds its dose rate times its length. A gap between windows, and the time between
    instants, adds the mean of both dose rates times its length. A gap longer than the levels allow
    adds nothing: it is reported, and the dose is a lower limit. A reading whose stamp is not after
    the newest is ignored.

    Attributes
    ----------
    newest
        The newest reading, None before the first.
    dose_usv
        Dose so far, microsievert.
    measured_s, unmeasured_s
        Time that counted, and time of gaps, seconds.
    is_lower_limit
        Whether there was a gap or a saturated reading.
    """

    def __init__(self, levels: AlarmLevels) -> None:
        self.newest: Exposure | None = None
        self.dose_usv = self.measured_s = self.unmeasured_s = 0.0
        self.is_lower_limit = False
        self._levels = levels
        self._reached: set[tuple[str, float]] = set()

    def add(self, reading: Exposure) -> tuple[Alarm, ...] | None:
        """Take `reading` and return the levels reached or left; None if it does not count."""
        if self.newest is not None and reading.time_ns <= self.newest.time_ns:
            return None
        self._count(reading.dose_rate_usvh, reading.window_s)
        if self.newest is not None:
            self._bridge(self.newest, reading)
        self.is_lower_limit = self.is_lower_limit or reading.is_saturated
        self.newest = reading
        return tuple(self._alarms(reading.dose_rate_usvh))

    def _bridge(self, last: Exposure, reading: Exposure) -> None:
        gap_s = (reading.time_ns - last.time_ns) / NS_PER_S - reading.window_s
        if gap_s > self._levels.largest_gap_s:
            self.unmeasured_s += gap_s
            self.is_lower_limit = True
        elif gap_s > 0.0:
            self._count((last.dose_rate_usvh + reading.dose_rate_usvh) / 2.0, gap_s)

    def _count(self, dose_rate_usvh: float, duration_s: float) -> None:
        self.dose_usv += dose_rate_usvh * duration_s / S_PER_H
        self.measured_s += duration_s

    def _alarms(self, dose_rate_usvh: float) -> list[Alarm]:
        values = {DOSE_RATE: dose_rate_usvh, DOSE: self.dose_usv}
        found = (
            self._alarm(quantity, level, values[quantity]) for quantity, level in self._levels.all
        )
        return [alarm for alarm in found if alarm is not None]

    def _alarm(self, quantity: str, level: float, value: float) -> Alarm | None:
        key = (quantity, level)
        if key not in self._reached and value >= level:
            self._reached.add(key)
        elif key in self._reached and value < CLEARED_SHARE * level:
            self._reached.remove(key)
        else:
            return None
        return Alarm(
            quantity=quantity,
            threshold=level,
            value=value,
            is_reached=key in self._reached,
            turns_back=self._levels.turns_back(quantity, level),
        )
