# SPDX-License-Identifier: Apache-2.0
"""A simulated ground vehicle: commands, and decisions by its own readings.

Commands take effect at the time of the last step.
"""

import math
from collections import deque
from collections.abc import Sequence
from dataclasses import replace

from rocsafe_geo.limits import require_positive
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_sim.driving.caution import Outlook, reason_to_end
from rocsafe_sim.driving.drive_route import DrivenRoute, RouteStop
from rocsafe_sim.driving.drive_state import DriveMode, DriveOutcome, DriveState, Ledger
from rocsafe_sim.driving.rover_motion import RoverMotion
from rocsafe_sim.driving.rover_parts import EvidenceShot, RoverParts
from rocsafe_sim.driving.way_back import Mark, WayBack
from rocsafe_sim.errors import CommandRefusedError

# A gap between two readings over which the dose is not added up.
LONGEST_GAP_S = 5.0
# A route may begin so far from the vehicle: cells of the map, and the error of its receiver.
LARGEST_OFFSET_M = 5.0
# Readings over which the growth of the dose rate is looked at: 2 s at 5 Hz.
RATES_KEPT = 10
# Lines whose mean dose rate is so many times higher are much hotter.
HOTTER = 1.5


class Rover(RoverMotion):
    """Drives routes, and turns back by its own readings."""

    def __init__(self, parts: RoverParts, state: DriveState) -> None:
        super().__init__(parts, state)
        self._rates: deque[float] = deque([state.read_usvh], maxlen=RATES_KEPT)
        self._gas_ns = 0

    def drive(self, route: DrivenRoute, *, replaces: bool = False) -> None:
        """Drive `route` from here; with `replaces` in place of the one being driven.

        Raises
        ------
        CommandRefusedError
            If another drive goes on, the vehicle has crashed, or the route begins elsewhere.
        """
        state = self.state
        if state.mode is DriveMode.CRASHED:
            raise CommandRefusedError('has crashed')
        if state.route == route and not self.is_over:
            return
        if state.route is not None and not self.is_over and not replaces:
            raise CommandRefusedError('drives another route: replace it, or wait')
        away = math.dist(route.stops[0].place, state.place)
        if away > LARGEST_OFFSET_M:
            raise CommandRefusedError(
                f'the route begins {away:.0f} m from here: must be {LARGEST_OFFSET_M:g} m at most'
            )
        # What it takes while it waits on its way belongs to the next drive, whoever predicts it.
        waited_usv = state.ledger.after_usv
        if state.mode in (DriveMode.PARKED, DriveMode.ARRIVED):
            waited_usv = 0.0
            self._way = WayBack([Mark(east_m=state.east_m, north_m=state.north_m, limit_mps=0.5)])
        here = replace(route.stops[0], east_m=state.east_m, north_m=state.north_m)
        state.route = replace(route, stops=(here, *route.stops[1:]))
        state.ledger = Ledger(
            began_ns=state.time_ns, dose_usv=waited_usv, predicted_usv=waited_usv
        )
        if state.is_backing:
            state.back()
        self._begin(DriveMode.DRIVING)

    def hold(self) -> None:
        """Stop where it is until the next command.

        Raises
        ------
        CommandRefusedError
            If it does not drive.
        """
        if not self.state.mode.is_moving:
            raise CommandRefusedError(f'cannot hold: {self.state.mode.value}')
        self.state.held_mode, self.state.mode = self.state.mode, DriveMode.HOLDING
        self.changes += 1

    def resume(self) -> None:
        """Continue a held drive.

        Raises
        ------
        CommandRefusedError
            If it does not hold, or its drive has ended.
        """
        if self.state.mode is not DriveMode.HOLDING or self.is_over:
            raise CommandRefusedError('cannot resume: it holds no drive')
        self.state.mode = self.state.held_mode
        self.changes += 1

    def cancel(self) -> None:
        """End the drive where it is."""
        if self.state.route is not None and not self.is_over:
            self._end(DriveOutcome.CANCELLED, 'by request', DriveMode.HOLDING)

    def return_home(self) -> None:
        """Drive back on its own tracks.

        Raises
        ------
        CommandRefusedError
            If it is there, or on its way.
        """
        if self.state.mode not in (DriveMode.DRIVING, DriveMode.HOLDING):
            raise CommandRefusedError(f'cannot return home: {self.state.mode.value}')
        ledger = self.state.ledger
        if self.is_over:
            ledger.ended_ns = 0
            ledger.dose_usv, ledger.after_usv = ledger.dose_usv + ledger.after_usv, 0.0
        self._go_back(DriveOutcome.RETURNED_EARLY, 'told to return home')

    def set_speed(self, speed: float) -> None:
        """Drive no faster than this to the end of the route; limits of lines still hold.

        Raises
        ------
        CommandRefusedError
            If no route is driven.
        """
        require_positive('speed_mps', speed, 'm/s')
        route = self.state.route
        if route is None or self.is_over:
            raise CommandRefusedError(f'cannot change its speed: {self.state.mode.value}')
        slower = (
            replace(one, limit_mps=min(one.limit_mps, speed) if k else one.limit_mps)
            for k, one in enumerate(route.stops)
        )
        self.state.route = replace(route, stops=tuple(slower))
        self._plan_speeds()
        self.changes += 1

    def read(self, time_ns: int, rate_usvh: float) -> None:
        """Take a reading of its own detector: dose and turn-back follow from it."""
        state = self.state
        if time_ns <= state.read_ns:
            return
        gap_s = (time_ns - state.read_ns) / NS_PER_S
        if state.read_ns and gap_s <= LONGEST_GAP_S:
            dose = 0.5 * (rate_usvh + state.read_usvh) * gap_s / 3600.0
            if self.is_over:
                state.ledger.after_usv += dose
            else:
                state.ledger.dose_usv += dose
            if not state.is_standing and state.mode is DriveMode.DRIVING:
                self._way.measure(dose)
        state.read_ns, state.read_usvh = time_ns, rate_usvh
        self._rates.append(rate_usvh)
        if state.mode is DriveMode.DRIVING and state.ledger.outcome is None:
            self._reconsider()

    def read_gas(self, sensor: str, ppm: float) -> None:
        """Take a reading of one of its gas sensors; infinite: it is saturated, NaN: it is none."""
        if math.isnan(ppm):
            return
        state = self.state
        self._gas_ns = state.time_ns
        level = state.route.turn_back_ppm if state.route else 0.0
        is_out = state.mode is DriveMode.DRIVING and state.ledger.outcome is None
        if not (level and is_out) or ppm < level:
            return
        reads = f'reads {ppm:.4g} ppm' if math.isfinite(ppm) else 'is saturated'
        text = f'{sensor} {reads}: the level is {level:.4g}'
        self._go_back(DriveOutcome.TURNED_BACK_GAS, text)

    def step(self, time_ns: int) -> list[EvidenceShot]:
        """Advance to `time_ns` and return the photographs that are due; see `RoverMotion.step`."""
        shots = super().step(time_ns)
        state = self.state
        if self.parts.has_detector:
            self._heed_silence('detector has', state.read_ns, DriveOutcome.TURNED_BACK_DOSE)
        if state.route is not None and state.route.turn_back_ppm:
            self._heed_silence('gas sensors have', self._gas_ns, DriveOutcome.TURNED_BACK_GAS)
        return shots

    def _heed_silence(self, who: str, read_ns: int, outcome: DriveOutcome) -> None:
        state = self.state
        heard_ns = max(read_ns, state.ledger.began_ns)
        silent_s = (state.time_ns - heard_ns) / NS_PER_S
        if state.mode is DriveMode.DRIVING and silent_s > self.parts.caution.silent_s:
            self._go_back(outcome, f'its {who} been silent for {silent_s:.0f} s')

    def _reconsider(self) -> None:
        found = reason_to_end(self._outlook(), self.parts.caution)
        self._is_at_stop = False
        if found is None:
            return
        outcome, text = found
        if outcome is DriveOutcome.DOSE_UNEXPECTED:
            self._end(outcome, text, DriveMode.HOLDING)
        else:
            self._go_back(outcome, text)

    def _outlook(self) -> Outlook:
        state, stops, chassis = self.state, self.stops, self.parts.chassis
        rest = stops[state.next_stop :]
        predicted = self.predicted_usv()
        line_usv = state.ledger.predicted_usv + rest[0].predicted_usv
        left_s = sum(stop.predicted_s for stop in rest)
        route = state.route
        assert route is not None  # noqa: S101 - it drives one
        power = chassis.power_w(1.0, 0.0)
        return Outlook(
            budget_usv=route.budget_usv,
            turn_back_usvh=route.turn_back_usvh,
            dose_usv=state.ledger.dose_usv,
            rate_usvh=state.read_usvh,
            growth=state.read_usvh / max(self._rates[0], 1e-9),
            predicted_usv=predicted,
            predicted_line_usv=line_usv,
            rest_usv=max(0.0, sum(stop.predicted_usv for stop in rest)
                         - (predicted - state.ledger.predicted_usv)),
            is_rest_hotter=_peak(rest[1:]) > HOTTER * _peak(stops[1 : state.next_stop + 1]),
            hotter_ratio=route.upper_ratio,
            back_usv=self._way.dose_usv,
            rest_j=left_s * power,
            back_j=self._way.energy_j(lambda speed: chassis.power_w(speed, 0.0))
            + self.parts.caution.reaction_s * power,
            charge_j=state.charge_j - chassis.reserve_fraction * chassis.capacity_j,
            is_at_stop=self._is_at_stop,
        )  # fmt: skip

    def _go_back(self, outcome: DriveOutcome, text: str) -> None:
        self.state.ledger.outcome, self.state.ledger.text = outcome, text
        self._turn_round()
        self._begin(DriveMode.RETURNING)


def _peak(stops: Sequence[RouteStop]) -> float:
    """Return the highest mean dose rate that is predicted for a line, microsievert a second."""
    return max((one.predicted_usv / max(one.predicted_s, 1e-9) for one in stops), default=0.0)
