# SPDX-License-Identifier: Apache-2.0
"""How others take over the work of a vehicle that is lost, turned back or led by somebody else."""

from collections.abc import Iterable

from rocsafe_orchestrator.mission.losses import WORLD, Losses
from rocsafe_orchestrator.mission.time_watch import TimeWatch
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.mission_state.phase_record import PhaseRecord
from rocsafe_orchestrator.mission_state.request import OrderKind
from rocsafe_orchestrator.mission_state.request_book import RequestBook
from rocsafe_orchestrator.mission_state.situation import Situation

AGENTS = 'agents'


class Takeover:
    """Has the rest of a survey planned for the other vehicles, or leaves it to their agents.

    Parameters
    ----------
    record
        Phase and faults of the mission.
    requests
        Open requests of the mission.
    fleet
        Presence of the vehicles.
    time
        Watches the simulated time of the mission.
    has_agents
        Whether agents of the vehicles hand the work over by themselves.
    """

    def __init__(
        self,
        record: PhaseRecord,
        requests: RequestBook,
        fleet: Losses,
        time: TimeWatch,
        *,
        has_agents: bool,
    ) -> None:
        self.has_agents = has_agents
        self._record, self._requests = record, requests
        self._fleet, self._time = fleet, time
        self._open: dict[str, str] = {}

    @property
    def _is_aloft(self) -> bool:
        return self._record.phase is Phase.FLYING or self._fleet.is_gathering

    def watch(self, situation: Situation) -> bool:
        """Look for vehicles that are lost or come back; return whether others take over now."""
        lost, remarks = self._fleet.look(situation.sightings)
        self._record.remarks += remarks
        is_replaced = False
        open_losses, self._open = {**self._open, **lost}, {}
        for vehicle, why in open_losses.items():
            is_gone = not situation.sightings[vehicle].ending
            if self._fleet.member(vehicle).takes_orders:
                continue  # it is back
            if self.replaced([vehicle], why, is_gone=is_gone):
                is_replaced = True
            elif not self._fleet.others:
                # They may be silent for a moment only.
                self._open[vehicle] = why
            elif is_gone:
                self._give_up_on(vehicle, why)
        back = [] if self.has_agents else self._fleet.regain()
        if back:
            self._record.enter(Phase.PLANNING)
        return is_replaced or bool(back)

    def replaced(self, vehicles: list[str], why: str, *, is_gone: bool = False) -> bool:
        """Let others take over from lost vehicles; return whether they do."""
        if not vehicles or not self._is_aloft or self._record.is_cancelled:
            return False
        if not self._fleet.note(vehicles, why, is_gone=is_gone):
            return self._left_to_agents(vehicles, why, is_gone=is_gone)
        self._time.begin()
        self._record.remarks.append(f'{", ".join(vehicles)}: {why}; the others take over')
        self._record.enter(Phase.PLANNING)
        return True

    def _left_to_agents(self, vehicles: list[str], why: str, *, is_gone: bool) -> bool:
        """Leave lost vehicles to the agents of the others; return whether there are any."""
        if not self.has_agents or not self._fleet.others:
            return False
        names = ', '.join(vehicles)
        self._record.remarks.append(f'{names}: {why}; the agents of the others take over')
        for vehicle in vehicles:
            self._requests.finish(OrderKind.FLY, vehicle)
        if is_gone:
            self._fleet.dismiss_again()
        return True

    def turn_back(self, vehicle: str, why: str, *, is_waiting: bool = False) -> None:
        """Let a vehicle return by the way of least dose; others take over its work.

        `is_waiting`: it has not taken off. It is told to return by the plain command, which
        withdraws its start: a route would make it take off.
        """
        if not self._is_aloft or not self._fleet.member(vehicle).takes_orders:
            return
        self._requests.finish(OrderKind.FLY, vehicle)
        if not self.replaced([vehicle], why) and not self.has_agents:
            self._record.fault(f'{vehicle}: {why}')
        self._fleet.withdraw(vehicle, why, OrderKind.RETURN if is_waiting else OrderKind.RETREAT)

    def replan(self, led_by_others: Iterable[str] = ()) -> str:
        """Plan the rest anew for the vehicles in flight; return why not, empty if it does.

        Vehicles in `led_by_others` would refuse the new plan: the others take over from them.
        """
        if self._record.phase is not Phase.FLYING or self._record.is_cancelled:
            return 'cannot plan anew: the vehicles do not fly a plan now'
        if self.has_agents:
            return 'cannot plan anew: the agents of the vehicles plan by themselves'
        why = 'is led by somebody else'
        if not (self._fleet.note(led_by_others, why, is_gone=False) or self._fleet.gather()):
            return 'cannot plan anew: no vehicle takes orders of the mission'
        self._time.begin()
        self._record.remarks.append('an operator has the rest planned anew')
        self._record.enter(Phase.PLANNING)
        return ''

    def sent_home(self, vehicle: str) -> None:
        """Note that the plan leaves nothing to a vehicle in the air: it returns home."""
        self._requests.finish(OrderKind.FLY, vehicle)
        self._fleet.withdraw(vehicle, 'nothing is left for it')

    def do_without_agents(self, text: str) -> None:
        """Handle losses here from now on; simulated time does not wait for the agents."""
        self.has_agents = False
        self._fleet.replace_losses()
        self._record.remarks.append(f'{AGENTS} {text}: losses are handled without them')
        self._requests.renew(OrderKind.DISMISS, WORLD, AGENTS)

    def _give_up_on(self, vehicle: str, why: str) -> None:
        """Stop waiting for a vehicle that cannot be replaced; the others fly on."""
        self._record.fault(f'{vehicle}: {why}')
        self._fleet.dismiss_again()
        self._requests.finish(OrderKind.FLY, vehicle)
