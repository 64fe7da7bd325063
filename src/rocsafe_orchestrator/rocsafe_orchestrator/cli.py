# SPDX-License-Identifier: Apache-2.0
"""The `rocsafe` command."""

import argparse
import sys
from collections.abc import Callable, Sequence
from typing import Any

from rocsafe_geo.evidence.code_version import version_text
from rocsafe_orchestrator.command_line import passed_on
from rocsafe_orchestrator.errors import EXIT_SETUP, EXIT_USAGE, OrchestratorError
from rocsafe_orchestrator.processes.interrupt import Interrupted, ended_by_signals
from rocsafe_orchestrator.processes.lasting_output import lasting_output
from rocsafe_orchestrator.processes.memory_limit import require_memory
from rocsafe_scenario.errors import ScenarioError

DESCRIPTION = """\
ROCSAFE surveys a region with a fleet of unmanned vehicles: it plans who photographs what, flies
the plan over simulated or real vehicles, measures radiation on the way, and hands over a map and
a report. A scenario file says what to survey with which vehicles; config/scenarios/ has examples.
"""

EPILOG = """\
examples:
  rocsafe check config/scenarios/derailment.yaml    check it and print what would fly
  rocsafe plan config/scenarios/derailment.yaml     plan it; nothing flies
  rocsafe run config/scenarios/derailment.yaml      fly it as fast as possible
  rocsafe run config/scenarios/derailment.yaml --speed 1    fly it in real time
  rocsafe fleet hold                                stop all vehicles of a mission in the air
  rocsafe localize readings.csv                     find the sources in a file of readings

exit codes:
  0    done; for `run`: the mission is complete
  1    the mission failed, or the plan is not possible; the reason is printed
  2    wrong arguments, or a scenario that cannot be flown as written
  3    the workspace is not set up, a process cannot start, or another run is active
  129  the terminal was closed    130  ended by Ctrl-C    143  ended by SIGTERM
"""


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command with `argv`, by default the arguments of this process."""
    words = sys.argv[1:] if argv is None else argv
    with lasting_output():
        return _answered(words)


def _answered(words: Sequence[str]) -> int:
    """Return the exit code, after one line about each fault."""
    try:
        with ended_by_signals():
            require_memory()
            return _obey(words)
    except (OrchestratorError, ScenarioError) as error:
        for line in str(error).splitlines():
            print(f'rocsafe: {line}', file=sys.stderr)
        return EXIT_USAGE if isinstance(error, ScenarioError) else error.exit_code
    except ModuleNotFoundError as error:
        print(
            f'rocsafe: Python module {error.name} is missing: run `make setup`, or '
            'source the workspace (. install/setup.bash)',
            file=sys.stderr,
        )
        return EXIT_SETUP
    except ImportError as error:
        hint = 'too little memory, or run `make setup`'
        print(f'rocsafe: cannot load all parts: {error} ({hint})', file=sys.stderr)
        return EXIT_SETUP
    except MemoryError:
        print('rocsafe: not enough memory', file=sys.stderr)
        return EXIT_SETUP
    except OSError as error:
        what = ': '.join(filter(None, (error.filename and str(error.filename), error.strerror)))
        print(f'rocsafe: {what or error}', file=sys.stderr)
        return EXIT_SETUP
    except Interrupted as error:
        print(f'rocsafe: {error}', file=sys.stderr)
        return error.exit_code


def orchestrator() -> int:
    """Run `rocsafe run` with the arguments of this process: the executable `orchestrator`."""
    return main(['run', *sys.argv[1:]])


def _obey(words: Sequence[str]) -> int:
    row = passed_on.passed_on(words)
    if row is not None:
        passed_on.pass_on(row, words[1:])
    arguments = _parser().parse_args(words)
    command: Callable[[argparse.Namespace], int] = arguments.command
    return command(arguments)


class _Version(argparse.Action):
    """Prints the version; git is asked only then."""

    def __init__(self, option_strings: Sequence[str], dest: str, **options: Any) -> None:
        super().__init__(option_strings, dest, nargs=0, **options)

    def __call__(self, parser: argparse.ArgumentParser, *_arguments: object) -> None:
        """Print it and end."""
        print(version_text())
        parser.exit()


def _parser() -> argparse.ArgumentParser:
    # Imported here: commands that are passed on need none of it.
    from rocsafe_orchestrator.command_line import (
        airsim,
        check,
        clear,
        fleet,
        join,
        plan,
        preflight,
        replan,
        replay,
        report,
        run,
        scene_show,
        whatif,
    )

    parser = argparse.ArgumentParser(
        prog='rocsafe',
        description=DESCRIPTION,
        epilog=EPILOG,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument('--version', action=_Version, help='print version and git revision')
    commands = parser.add_subparsers(title='commands', required=True, metavar='COMMAND')
    modules = (
        run, join, fleet, check, plan, replan, whatif, preflight, report, replay, clear, airsim,
        passed_on, scene_show,
    )  # fmt: skip
    for module in modules:
        module.add_to(commands)
    return parser


if __name__ == '__main__':
    sys.exit(main())
