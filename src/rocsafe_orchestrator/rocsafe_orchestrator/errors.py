# SPDX-License-Identifier: Apache-2.0
"""Errors of a run and the exit codes of the `rocsafe` command."""

EXIT_COMPLETE = 0
EXIT_FAILED = 1
EXIT_USAGE = 2
EXIT_SETUP = 3
# The shell's convention for a command ended by a signal.
EXIT_SIGNAL_BASE = 128


class OrchestratorError(Exception):
    """A reason to end the command; its text is one line for each thing that is wrong."""

    exit_code = EXIT_FAILED


class SetupError(OrchestratorError):
    """The machine, not the mission: an executable is missing, or another run is in the way."""

    exit_code = EXIT_SETUP
