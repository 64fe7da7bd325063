# SPDX-License-Identifier: Apache-2.0
"""Work beside an event loop."""

from collections.abc import Callable
from threading import Event

import pytest

from rocsafe_ros.background_job import BackgroundJob


def test_result_and_progress():
    """The newest report is what a look at the job tells."""
    may_end, has_reported = Event(), Event()

    def work(report: Callable[[int], bool]) -> str:
        assert report(7)
        has_reported.set()
        may_end.wait(10.0)
        return 'done'

    job = BackgroundJob(work, 'test', progress=0)
    assert has_reported.wait(10.0)
    assert job.progress == 7
    assert not job.is_done
    may_end.set()
    assert job.result() == 'done'
    assert job.is_done
    assert job.elapsed_s > 0.0


def test_error_is_raised_by_result():
    """What the work raises is not lost in its thread."""

    def work(_report: Callable[[None], bool]) -> None:
        raise ValueError('no plan')

    with pytest.raises(ValueError, match='no plan'):
        BackgroundJob(work, 'test', progress=None).result()


def test_cancelled_work_is_told():
    """A report returns False once the job is cancelled."""
    may_go_on = Event()

    def work(report: Callable[[int], bool]) -> bool:
        may_go_on.wait(10.0)
        return report(1)

    job = BackgroundJob(work, 'test', progress=0)
    job.cancel()
    may_go_on.set()
    assert job.result() is False
