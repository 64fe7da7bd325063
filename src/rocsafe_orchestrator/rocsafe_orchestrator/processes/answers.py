# SPDX-License-Identifier: Apache-2.0
"""Executables of other packages that are asked by JSON, answer by JSON, and end."""

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
        In one line, why there is no answer: its own reason, or the time.
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
    """Return why a process gave up: its last line, or how it ended."""
    words = done.stderr.strip().splitlines() or [f'{name} ended with {done.returncode}']
    return words[-1].removeprefix('error: ')
