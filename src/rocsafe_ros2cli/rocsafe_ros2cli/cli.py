# SPDX-License-Identifier: Apache-2.0
"""The command line: finds the command, parses its arguments, runs it."""

import argparse
import importlib
import io
import os
import re
import signal
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from types import FrameType

from rocsafe_ros2cli.command import CommandError, Verb
from rocsafe_ros2cli.verbs.run_command import add_run_arguments, run

PROGRAM = 'ros2'

COMMANDS = {
    'action': 'Various action related sub-commands',
    'interface': 'Show information about ROS interfaces',
    'node': 'Various node related sub-commands',
    'param': 'Various param related sub-commands',
    'pkg': 'Various package related sub-commands',
    'run': 'Run a package specific executable',
    'service': 'Various service related sub-commands',
    'topic': 'Various topic related sub-commands',
}
"""Name and summary of each command. Module `<name>_command` holds its `VERBS`, except for run."""


class Terminated(BaseException):
    """SIGTERM arrived."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command named by the arguments (of the process, if none are given).

    Returns
    -------
    int
        Exit status of the real command: 0 done, 1 failed, 2 wrong arguments or Ctrl-C,
        15 SIGTERM; 141 if the reader of the output went away. `run` returns the status of its
        node.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        with _sigterm_raises():
            options = _parser(words).parse_args(words)
            if isinstance(sys.stdout, io.TextIOWrapper):
                # Print each message at once, also into a pipe or a file.
                sys.stdout.reconfigure(line_buffering=True)
            return int(options.run(options) or 0)
    except KeyboardInterrupt:
        return int(signal.SIGINT)
    except Terminated:
        return int(signal.SIGTERM)
    except BrokenPipeError:
        _discard_output()
        return 128 + int(signal.SIGPIPE)
    except (CommandError, RuntimeError, OSError) as error:
        # RuntimeError: rcl appends the place in its code to refusals, e.g. of ROS_DOMAIN_ID.
        print(re.sub(r', at /\S+:\d+$', '', str(error)), file=sys.stderr)
        return 1


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Make the parser; only the module of the named command is imported."""
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description='ros2 is an extensible command-line tool for ROS 2. '
        '(Replacement by ROCSAFE for machines without a ROS 2 installation.)',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    rows = _add_rows(parser, PROGRAM, COMMANDS)
    add_run_arguments(rows['run'])
    rows['run'].set_defaults(run=run)
    chosen = next((word for word in words if not word.startswith('-')), None)
    if chosen in COMMANDS and chosen != 'run':
        _add_verbs(rows[chosen], chosen)
    return parser


def _add_rows(
    parser: argparse.ArgumentParser, prog: str, summaries: Mapping[str, str]
) -> dict[str, argparse.ArgumentParser]:
    """Add a sub-parser for each name; its summary is shown in the help of the parent."""
    parser.set_defaults(run=lambda _options: parser.print_help())
    width = max(map(len, summaries))
    lines = [f'{name:{width}}  {summary}' for name, summary in summaries.items()]
    group = parser.add_subparsers(
        title='Commands',
        description='\n'.join(lines),
        metavar=f'Call `{prog} <command> -h` for more detailed usage.',
    )
    return {
        name: group.add_parser(
            name,
            prog=f'{prog} {name}',
            description=summary,
            formatter_class=argparse.RawDescriptionHelpFormatter,
        )
        for name, summary in summaries.items()
    }


def _add_verbs(parser: argparse.ArgumentParser, command: str) -> None:
    """Give the parser of a command its verbs and their arguments."""
    module = importlib.import_module(f'rocsafe_ros2cli.verbs.{command}_command')
    verbs: tuple[Verb, ...] = module.VERBS
    rows = _add_rows(parser, f'{PROGRAM} {command}', {verb.name: verb.summary for verb in verbs})
    for verb in verbs:
        for add_to in verb.arguments:
            add_to(rows[verb.name])
        rows[verb.name].set_defaults(run=verb.run)


@contextmanager
def _sigterm_raises() -> Iterator[None]:
    """Turn SIGTERM into an exception, so that nodes are destroyed and goals are cancelled."""
    if threading.current_thread() is not threading.main_thread():
        yield
        return

    def handle(_number: int, _frame: FrameType | None) -> None:
        raise Terminated

    before = signal.signal(signal.SIGTERM, handle)
    try:
        yield
    finally:
        signal.signal(signal.SIGTERM, before)


def _discard_output() -> None:
    """Send the interpreter's last flush to nowhere: nobody reads the output any more."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
