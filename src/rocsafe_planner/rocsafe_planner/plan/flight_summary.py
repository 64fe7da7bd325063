# SPDX-License-Identifier: Apache-2.0
"""Summary of each flight of a plan: take-off, landing, battery change.

The files for autopilots hold one flight each, without the time of take-off, which this summary
states.
"""

import csv
from dataclasses import dataclass
from io import StringIO

from rocsafe_planner.plan.flight_path import begins_aloft
from rocsafe_planner.plan.plan import Route, SurveyPlan

_COLUMNS = (
    'takes_off_s', 'lands_s', 'vehicle', 'flight', 'flights', 'begins', 'lands', 'battery_swap_s',
    'photographs', 'length_m', 'height_m', 'file',
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightSummary:
    """One flight.

    Attributes
    ----------
    takes_off_s, lands_s
        Since the start of the mission; a flight that begins in the air begins at 0.
    number, count
        Of the vehicle's flights, from 1, and how many there are.
    begins, lands
        ``'home'`` or ``'in the air'``; ``'home'``, ``'end'`` or ``'last viewpoint'``.
    battery_swap_s
        Time for a new battery after it; None: it is the last.
    """

    takes_off_s: float
    lands_s: float
    number: int
    count: int
    begins: str
    lands: str
    battery_swap_s: float | None

    @property
    def text(self) -> str:
        """The summary as one sentence without a full stop."""
        begin = 'takes off' if self.begins == 'home' else 'is in the air'
        late = f' after {self.takes_off_s:.0f} s' if self.takes_off_s else ''
        where = 'home' if self.lands == 'home' else f'its {self.lands}'
        swap = ''
        if self.battery_swap_s is not None:
            swap = f', and gets a new battery within {self.battery_swap_s:.0f} s'
        return f'{begin}{late}, lands at {where} after {self.lands_s:.0f} s{swap}'


def flight_summary(route: Route, number: int) -> FlightSummary:
    """Return the summary of flight `number` of a route, counted from 0."""
    vehicle, count = route.vehicle, len(route.sorties)
    swap_s = vehicle.battery_swap_s or 0.0
    takes_off_s = route.delay_s + sum(s.duration_s + swap_s for s in route.sorties[:number])
    is_last = number == count - 1
    lands = 'home'
    if is_last and (vehicle.is_open or vehicle.end is not None):
        lands = 'last viewpoint' if vehicle.is_open else 'end'
    return FlightSummary(
        takes_off_s=takes_off_s,
        lands_s=takes_off_s + route.sorties[number].duration_s,
        number=number + 1,
        count=count,
        begins='in the air' if begins_aloft(route, number) else 'home',
        lands=lands,
        battery_swap_s=None if is_last else swap_s,
    )


def flight_stem(route: Route, number: int) -> str:
    """Return the name, without its ending, of the files of flight `number`, from 0."""
    return f'plan-{route.vehicle.name}' + (f'-{number + 1}' if number else '')


def flight_table(plan: SurveyPlan) -> str:
    """Return all flights as CSV, by the time of their take-off."""
    rows = sorted(
        _row(route, number) for route in plan.routes for number in range(len(route.sorties))
    )
    text = StringIO()
    writer = csv.writer(text, lineterminator='\n')
    writer.writerow(_COLUMNS)
    writer.writerows(rows)
    return text.getvalue()


def _row(route: Route, number: int) -> tuple[object, ...]:
    summary, sortie = flight_summary(route, number), route.sorties[number]
    return (
        round(summary.takes_off_s, 1),
        round(summary.lands_s, 1),
        route.vehicle.name,
        summary.number,
        summary.count,
        summary.begins,
        summary.lands,
        '' if summary.battery_swap_s is None else round(summary.battery_swap_s, 1),
        len(sortie.viewpoints),
        round(sortie.length_m, 1),
        round(route.flight_height_m, 2),
        flight_stem(route, number),
    )
