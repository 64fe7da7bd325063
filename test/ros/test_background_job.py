# SPDX-License-Identifier: Apache-2.0
"""Work in the background hands over its result or its error."""

import threading

import pytest

from rocsafe_ros.background_job import start_job

DEADLINE_S = 30.0


def test_the_result_is_there_once_the_work_is_done():
    """Not before, and the caller did not wait for it."""
    may_end = threading.Event()

    def work():
        may_end.wait(DEADLINE_S)
        return threading.current_thread().name

    job = start_job(work, 'counting')
    assert not job.done()
    may_end.set()
    assert job.result(DEADLINE_S) == 'counting'
    assert job.done()


def test_an_error_of_the_work_is_raised_by_its_result():
    """The very same one."""
    error = ValueError('no readings')

    def work():
        raise error

    with pytest.raises(ValueError, match='no readings') as caught:
        start_job(work, 'failing').result(DEADLINE_S)
    assert caught.value is error
