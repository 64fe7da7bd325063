# SPDX-License-Identifier: Apache-2.0
"""The limit of memory under which nothing of the suite runs."""

import resource

from rocsafe_orchestrator.errors import SetupError

# The planner of a small mission takes this much address space. OpenBLAS asks for memory again and
# again, for ever, where it gets none: that must not begin.
LEAST_BYTES = 2 * 2**30


def require_memory() -> None:
    """Refuse to run where the shell allows too little memory (`ulimit -v`).

    Raises
    ------
    SetupError
        Naming the limit and what is needed.
    """
    allowed, _ = resource.getrlimit(resource.RLIMIT_AS)
    if allowed != resource.RLIM_INFINITY and allowed < LEAST_BYTES:
        raise SetupError(
            f'ulimit -v allows {allowed // 1024} kB of memory: must be at least '
            f'{LEAST_BYTES // 1024} kB, or unlimited'
        )
