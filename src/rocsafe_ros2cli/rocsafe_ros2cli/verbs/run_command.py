# SPDX-License-Identifier: Apache-2.0
"""`ros2 run`: starts a node, forwards signals to it and returns its exit status."""

import os
import signal
from argparse import REMAINDER, ArgumentParser, Namespace

from rocsafe_ros2cli.command import CommandError
from rocsafe_ros2cli.packages import executable

FORWARDED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

SENT_BY_KERNEL = 0x80
"""`si_code` of a signal from the terminal, which the node has received as well (Linux)."""


def add_run_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `run`; those after the executable are the node's."""
    parser.add_argument('package_name', help='Name of the package')
    parser.add_argument('executable_name', help='Name of the executable')
    parser.add_argument('argv', nargs=REMAINDER, help='Arguments of the executable')


def run(options: Namespace) -> int:
    """Run the executable and return its exit status, 128 + N if signal N ended it."""
    path = executable(options.package_name, options.executable_name)
    status = _run_forwarding_signals([str(path), *options.argv])
    if status < 0:
        print('[ros2run]:', signal.strsignal(-status))
        return 128 - status
    if status > 0:
        print(f'[ros2run]: Process exited with failure {status}')
    return status


def _run_forwarding_signals(words: list[str]) -> int:
    """Run a program to its end; signals sent to this process alone are forwarded to it.

    The program starts with the default reaction to signals, also below a shell whose background
    jobs ignore Ctrl-C.

    Returns
    -------
    int
        Its exit status, or minus the number of the signal that ended it.

    Raises
    ------
    CommandError
        If the program cannot be started.
    """
    waited = {*FORWARDED, signal.SIGCHLD}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, waited)
    try:
        child = os.posix_spawn(words[0], words, os.environ, setsigmask=(), setsigdef=FORWARDED)
        return _await_end(child, waited)
    except OSError as error:
        raise CommandError(f"Cannot run '{words[0]}': {error.strerror}") from error
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _await_end(child: int, waited: set[signal.Signals]) -> int:
    """Forward signals until the child has ended; return its exit status."""
    while True:
        arrived = signal.sigwaitinfo(waited)
        if arrived.si_signo == signal.SIGCHLD:
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                return os.waitstatus_to_exitcode(status)
        elif arrived.si_code != SENT_BY_KERNEL:
            os.kill(child, arrived.si_signo)
