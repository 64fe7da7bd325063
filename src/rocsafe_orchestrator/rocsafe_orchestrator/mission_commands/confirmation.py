# SPDX-License-Identifier: Apache-2.0
"""A person confirms the plan by which real vehicles take off."""

from typing import TYPE_CHECKING

from rocsafe_orchestrator.mission_commands.progress import Display
from rocsafe_orchestrator.mission_commands.terminal import Terminal

if TYPE_CHECKING:  # the loop is tested without ROS
    from rocsafe_orchestrator.plan_requests_node import PlanRequests

# A plan must be confirmed within this time.
CONFIRM_S = 120.0


class Confirmation:
    """Asks at the terminal, unless the plan was confirmed on the command line.

    Parameters
    ----------
    plans
        Knows the plan that waits.
    confirmed
        Hashes of plans that are confirmed already.
    """

    def __init__(
        self,
        plans: 'PlanRequests',
        terminal: Terminal,
        display: Display,
        confirmed: frozenset[str],
    ) -> None:
        self._plans = plans
        self._terminal, self._display = terminal, display
        self._confirmed = confirmed
        self._asked_s: float | None = None

    def watch(self, now_s: float) -> str:
        """Return the hash of a plan that is confirmed now and is flown; empty: none is."""
        digest = self._plans.unconfirmed
        if not digest:
            return ''
        if digest in self._confirmed or (self._asked_s and self._terminal.typed() == 'y'):
            self._asked_s = None
            self._plans.confirm()
            return digest
        if not self._terminal.is_there:
            self._plans.reject(
                f'plan {digest} of real vehicles is not confirmed: look at plan.json, then run '
                f'again with --confirm {digest}, or in a terminal'
            )
        elif self._asked_s is None:
            self._asked_s = now_s
            self._display.say(
                f'real vehicles take off by plan {digest}, see plan.json: y and Enter confirms it'
            )
        elif now_s - self._asked_s > CONFIRM_S:
            self._asked_s = None
            self._plans.reject(f'plan {digest} was not confirmed within {CONFIRM_S:.0f} s')
        return ''
