# SPDX-License-Identifier: Apache-2.0
"""Fits of all readings so far, one after the other, beside the event loop of a node."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, Generic, Protocol, TypeVar

from rclpy.clock import Clock, ClockType
from rclpy.node import Node

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_hazard.pending_request import PendingRequest
from rocsafe_interfaces.srv import SuggestViewpoints
from rocsafe_ros.background_job import BackgroundJob

AssessmentT = TypeVar('AssessmentT')

# Period of looks at a running fit, on the wall clock: simulated time may stand still.
LOOK_PERIOD_S = 0.1
# Period of looks at news that need no fit, and at what is made of them.
RENEW_PERIOD_S = 0.5

# Fits that nobody asked for rest for so many times as long as the last one took: they get slower
# with the number of readings, and would otherwise keep a core of the mission busy.
REST = 3.0


class ReadingLog(Protocol):
    """All readings so far."""

    def __len__(self) -> int:
        """Return their number."""

    @property
    def newest_ns(self) -> int:
        """Time of the newest, ns."""


@dataclass(frozen=True, slots=True, kw_only=True)
class FitSteps(Generic[AssessmentT]):
    """What a cycle of fits calls.

    Attributes
    ----------
    prepare
        Returns the fit of all readings so far, which is called in a thread of its own.
    refusals
        Errors by which `prepare` and the fit say that nothing can be said.
    publish
        Called with the result of a fit and the time of its newest reading, ns.
    period_s
        Least wall time between the beginnings of two fits, s.
    renew
        Called with the newest result. Returns None, or, where there is news that needs no fit, a
        function that makes the result anew, and the time of the news, ns. The function is called
        in a thread of its own.
    """

    prepare: Callable[[], Callable[[], AssessmentT]]
    refusals: tuple[type[Exception], ...]
    publish: Callable[[AssessmentT, int], None]
    period_s: float
    renew: Callable[[AssessmentT], tuple[Callable[[], AssessmentT], int] | None] | None = None


class FitCycle(Generic[AssessmentT]):
    """Fits when the last fit is done, the period has passed and there are new readings.

    A fit that nobody asked for also waits until three times the duration of the last has passed.

    The last fit covers all readings; which ones the others cover depends on the speed of the
    machine.

    Parameters
    ----------
    node
        Node whose event loop looks at the fits.
    log
        All readings so far.
    steps
        What the cycle calls.
    """

    def __init__(self, node: Node, log: ReadingLog, steps: FitSteps[AssessmentT]) -> None:
        self._log, self._steps = log, steps
        self._assessment: AssessmentT | None = None
        self._why_none = 'too few readings'
        self._job: BackgroundJob[AssessmentT, None] | None = None
        self._renewal: tuple[BackgroundJob[AssessmentT, None], AssessmentT, int] | None = None
        self._request = PendingRequest()
        self._steady = Clock(clock_type=ClockType.STEADY_TIME)
        self._fitted = self._fitted_ns = self._evaluated = 0
        self._began_ns = self._next_ns = 0
        node.create_timer(LOOK_PERIOD_S, self._on_look, clock=self._steady)
        if steps.renew is not None:
            node.create_timer(RENEW_PERIOD_S, self._on_look_at_renewal, clock=self._steady)

    def note_reading(self) -> None:
        """Note that a reading came from a vehicle."""
        self._request.news(self._now_ns)

    def answer(
        self,
        response: SuggestViewpoints.Response,
        fill: Callable[[AssessmentT], SuggestViewpoints.Response],
    ) -> Any:
        """Return the answer to a request for viewpoints; `fill` makes it from the assessment."""
        self._begin()
        if not self._request.is_answerable(self._now_ns, len(self._log), self._evaluated):
            response.status = SuggestViewpoints.Response.NOT_YET
            return response
        if self._assessment is None:
            response.status = SuggestViewpoints.Response.TOO_FEW_READINGS
            response.reason = self._why_none
            return response
        return fill(self._assessment)

    @property
    def _now_ns(self) -> int:
        return int(self._steady.now().nanoseconds)

    def _on_look(self) -> None:
        if self._job is not None and self._job.is_done:
            ended, self._job = self._job, None
            rest_ns = int(REST * (self._now_ns - self._began_ns))
            self._next_ns = max(self._next_ns, self._now_ns + rest_ns)
            self._end(ended)
        if self._now_ns >= self._next_ns:
            self._begin()

    def _on_look_at_renewal(self) -> None:
        if self._renewal is None:
            self._begin_renewal()
            return
        job, of, time_ns = self._renewal
        if not job.is_done:
            return
        self._renewal = None
        # A fit that ended meanwhile knows better.
        if of is self._assessment:
            self._assessment = job.result()
            self._steps.publish(self._assessment, time_ns)

    def _begin_renewal(self) -> None:
        if self._steps.renew is None or self._assessment is None:
            return
        begun = self._steps.renew(self._assessment)
        if begun is not None:
            renew, time_ns = begun
            job = BackgroundJob[AssessmentT, None](lambda _report: renew(), 'renewing', None)
            self._renewal = job, self._assessment, time_ns

    def _begin(self) -> None:
        if self._job is not None or len(self._log) <= self._fitted:
            return
        self._began_ns = self._now_ns
        self._next_ns = self._began_ns + int(self._steps.period_s * NS_PER_S)
        self._fitted, self._fitted_ns = len(self._log), self._log.newest_ns
        try:
            fit = self._steps.prepare()
        except self._steps.refusals as refusal:
            self._evaluated, self._why_none = self._fitted, str(refusal)
            return
        self._job = BackgroundJob(lambda _report: fit(), 'fitting', None)

    def _end(self, job: BackgroundJob[AssessmentT, None]) -> None:
        self._evaluated = self._fitted
        try:
            self._assessment = assessment = job.result()
        except self._steps.refusals as refusal:
            self._why_none = str(refusal)
            return
        self._steps.publish(assessment, self._fitted_ns)
