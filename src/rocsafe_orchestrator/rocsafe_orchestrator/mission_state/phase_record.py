# SPDX-License-Identifier: Apache-2.0
"""The phase of a mission, the time since its start, and faults so far."""

from rocsafe_orchestrator.mission_state.phase import Phase


class PhaseRecord:
    """Present phase and expected outcome of a mission.

    Attributes
    ----------
    phase
        The present phase.
    outcome
        How the mission will end, as far as is known now.
    faults
        Reasons why the mission is not complete.
    remarks
        Other remarks for people.
    is_cancelled
        Whether the mission was cancelled.
    """

    def __init__(self) -> None:
        self.phase = Phase.STARTING
        self.outcome = Phase.COMPLETE
        self.faults: list[str] = []
        self.remarks: list[str] = []
        self.is_cancelled = False
        self._entered_s: float | None = None

    def fault(self, text: str) -> None:
        """Note a reason why the mission is not complete, and continue."""
        self.faults.append(text)
        if self.outcome is Phase.COMPLETE:
            self.outcome = Phase.FAILED

    def cancel(self, text: str) -> None:
        """Note that the mission is cancelled, and why."""
        self.is_cancelled = True
        self.outcome = Phase.CANCELLED
        self.faults.append(text)

    def enter(self, phase: Phase) -> None:
        """Begin a phase, or the present one again."""
        self.phase = phase
        self._entered_s = None

    def passed_s(self, now_s: float) -> float:
        """Return the time since the first call in this phase, seconds."""
        if self._entered_s is None:
            self._entered_s = now_s
        return now_s - self._entered_s
