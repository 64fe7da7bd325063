# SPDX-License-Identifier: Apache-2.0
"""`ros2 run`: starts a node, hands it the signals meant for us, ends as it ends."""

import os
import shlex
import shutil
import signal
from argparse import REMAINDER, ArgumentParser, Namespace

from rocsafe_ros2cli.command import Command, CommandError
from rocsafe_ros2cli.packages import executable

FORWARDED = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP, signal.SIGQUIT)

SENT_BY_KERNEL = 0x80
"""`si_code` of a signal from the terminal, which the node has received as well (Linux)."""


def _add_arguments(parser: ArgumentParser) -> None:
    """Add the arguments of `run`; what follows the executable is the node's."""
    parser.add_argument('--prefix', help='Command to put before the executable, in quotes')
    parser.add_argument('package_name', help='Name of the package')
    parser.add_argument('executable_name', help='Name of the executable')
    parser.add_argument('argv', nargs=REMAINDER, help='Arguments of the executable')


def _run(options: Namespace) -> int:
    """Run the executable and return its exit status, 128 + N if signal N ended it."""
    path = executable(options.package_name, options.executable_name)
    status = run_forwarding_signals([*shlex.split(options.prefix or ''), str(path), *options.argv])
    if status < 0:
        print('[ros2run]:', signal.strsignal(-status))
        return 128 - status
    if status > 0:
        print(f'[ros2run]: Process exited with failure {status}')
    return status


def run_forwarding_signals(words: list[str]) -> int:
    """Run a program to its end; signals sent to this process alone reach it too.

    The program starts with the default reaction to signals, also below a shell that lets its
    background jobs ignore Ctrl-C.

    Parameters
    ----------
    words : list of str
        The program and its arguments.

    Returns
    -------
    int
        Its exit status, or minus the number of the signal that ended it.

    Raises
    ------
    CommandError
        If the program cannot be started.
    """
    program = shutil.which(words[0])
    if program is None:
        raise CommandError(f"Cannot run '{words[0]}': no such program")
    waited = {*FORWARDED, signal.SIGCHLD}
    before = signal.pthread_sigmask(signal.SIG_BLOCK, waited)
    try:
        child = os.posix_spawn(program, words, os.environ, setsigmask=(), setsigdef=FORWARDED)
        return _await_end(child, waited)
    except OSError as error:
        raise CommandError(f"Cannot run '{words[0]}': {error.strerror}") from error
    finally:
        signal.pthread_sigmask(signal.SIG_SETMASK, before)


def _await_end(child: int, waited: set[signal.Signals]) -> int:
    """Pass signals on until the child has ended; return its exit status."""
    while True:
        arrived = signal.sigwaitinfo(waited)
        if arrived.si_signo == signal.SIGCHLD:
            ended, status = os.waitpid(child, os.WNOHANG)
            if ended:
                return os.waitstatus_to_exitcode(status)
        elif arrived.si_code != SENT_BY_KERNEL:
            os.kill(child, arrived.si_signo)


COMMAND = Command(add_arguments=_add_arguments, run=_run)
