# SPDX-License-Identifier: Apache-2.0
"""The command line: finds the command, parses its arguments, runs it, ends quietly."""

import argparse
import importlib
import io
import os
import re
import signal
import sys
import threading
from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from types import FrameType

from rocsafe_ros2cli.command import Command, CommandError, Verb

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
"""Name of each command and its summary; module `<name>_command` holds it as `COMMAND`."""


class Terminated(BaseException):
    """SIGTERM arrived."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command named by the arguments (of the process, if none are given).

    Returns
    -------
    int
        What the real command exits with: 0 done, 1 failed, 2 wrong arguments or Ctrl-C,
        15 SIGTERM; 141 when the reader of our output went away. `run` returns the status of its
        node.
    """
    words = list(sys.argv[1:] if arguments is None else arguments)
    try:
        with _sigterm_raises():
            return _run(words)
    except KeyboardInterrupt:
        return int(signal.SIGINT)
    except Terminated:
        return int(signal.SIGTERM)
    except BrokenPipeError:
        _discard_output()
        return 128 + int(signal.SIGPIPE)
    except (CommandError, RuntimeError, OSError) as error:
        # RuntimeError: what rcl refuses, such as a wrong ROS_DOMAIN_ID, with a place in its code.
        print(re.sub(r', at /\S+:\d+$', '', str(error)), file=sys.stderr)
        return 1


def _run(words: list[str]) -> int:
    """Parse the words and run what they ask for."""
    options = _parser(words).parse_args(words)
    if not options.use_python_default_buffering and isinstance(sys.stdout, io.TextIOWrapper):
        # Each message is out at once, also into a pipe or a file.
        sys.stdout.reconfigure(line_buffering=True)
    status = int(options.run(options))
    sys.stdout.flush()
    return status


def _parser(words: Sequence[str]) -> argparse.ArgumentParser:
    """Make the parser; only the module of the named command is imported."""
    parser = argparse.ArgumentParser(
        prog=PROGRAM,
        description='ros2 is an extensible command-line tool for ROS 2. '
        '(Stand-in of ROCSAFE for machines without a ROS 2 installation.)',
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument(
        '--use-python-default-buffering', action='store_true', help='Do not force line buffering'
    )
    parser.set_defaults(run=_HelpAction(parser))
    chosen = next((word for word in words if not word.startswith('-')), None)
    rows = _add_rows(parser, PROGRAM, COMMANDS)
    if chosen in COMMANDS:
        _fill(rows[chosen], chosen)
    return parser


def _add_rows(
    parser: argparse.ArgumentParser, prog: str, summaries: dict[str, str]
) -> dict[str, argparse.ArgumentParser]:
    """Add a sub-parser for each name; its summary stands in the help of the parent."""
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


def _fill(parser: argparse.ArgumentParser, name: str) -> None:
    """Give the parser of command `name` its arguments and verbs."""
    module = importlib.import_module(f'rocsafe_ros2cli.{name}_command')
    command: Command = module.COMMAND
    command.add_arguments(parser)
    parser.set_defaults(run=command.run or _HelpAction(parser))
    if command.verbs:
        summaries = {verb.name: verb.summary for verb in command.verbs}
        rows = _add_rows(parser, f'{PROGRAM} {name}', summaries)
        for verb in command.verbs:
            _fill_verb(rows[verb.name], verb)


def _fill_verb(parser: argparse.ArgumentParser, verb: Verb) -> None:
    """Give the parser of a verb its arguments."""
    verb.add_arguments(parser)
    parser.set_defaults(run=verb.run)


class _HelpAction:
    """Action of a command without a verb."""

    def __init__(self, parser: argparse.ArgumentParser) -> None:
        self._parser = parser

    def __call__(self, _options: argparse.Namespace) -> int:
        """Print the help."""
        self._parser.print_help()
        return 0


@contextmanager
def _sigterm_raises() -> Iterator[None]:
    """Turn SIGTERM into an exception, so that nodes are taken down and goals cancelled."""
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
    """Let the interpreter's last flush go nowhere: nobody reads our output any more."""
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, sys.stdout.fileno())
    os.close(nowhere)
