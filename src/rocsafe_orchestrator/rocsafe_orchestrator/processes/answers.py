# SPDX-License-Identifier: Apache-2.0
"""Executables of other packages that read a request as JSON and write an answer as JSON."""

import json
import subprocess
from pathlib import Path
from typing import Any

from rocsafe_orchestrator.errors import OrchestratorError


def answer_of(executable: Path, request: dict[str, Any], timeout_s: float) -> dict[str, Any]:
    """Return what an executable answers to a request.

    Raises
    ------
    OrchestratorError
        If there is no answer, with the reason in one line.
    """
    try:
        done = subprocess.run(
            [str(executable)],
            input=json.dumps(request),
            capture_output=True,
            text=True,
            timeout=timeout_s,
            check=False,
        )
    except subprocess.TimeoutExpired as error:
        raise OrchestratorError(f'{executable.name}: no answer within {timeout_s:g} s') from error
    if not done.stdout:
        raise OrchestratorError(reason_of(done, executable.name))
    answer: dict[str, Any] = json.loads(done.stdout)
    return answer


def reason_of(done: 'subprocess.CompletedProcess[str]', name: str) -> str:
    """Return why a process failed: its last line, or how it ended."""
    words = done.stderr.strip().splitlines() or [f'{name} ended with {done.returncode}']
    return words[-1].removeprefix('error: ')
