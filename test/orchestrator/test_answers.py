# SPDX-License-Identifier: Apache-2.0
"""Executables that are asked by JSON: an answer, or one line that says why there is none."""

from collections.abc import Callable
from pathlib import Path

import pytest

from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.processes.answers import answer_of


@pytest.fixture
def asked(tmp_path: Path) -> Callable[[str], Path]:
    """Return a function that makes an executable of lines of a shell."""

    def make(lines: str) -> Path:
        path = tmp_path / 'asked'
        path.write_text(f'#!/bin/sh\n{lines}\n')
        path.chmod(0o755)
        return path

    return make


def test_the_answer_to_a_request(asked: Callable[[str], Path]) -> None:
    """Both are JSON."""
    assert answer_of(asked('cat'), {'method': 'strips'}, 20.0) == {'method': 'strips'}


@pytest.mark.parametrize(
    ('lines', 'reason'),
    [
        ('echo one >&2; echo "error: no region" >&2; exit 1', 'no region'),
        ('exit 7', 'asked ended with 7'),
        ('exec sleep 20', 'asked: no answer within 0.1 s'),
    ],
)
def test_the_reason_for_no_answer(asked: Callable[[str], Path], lines: str, reason: str) -> None:
    """The last line that it says, how it ended, or the time."""
    with pytest.raises(OrchestratorError) as caught:
        answer_of(asked(lines), {}, 0.1 if 'sleep' in lines else 20.0)
    assert str(caught.value) == reason
