# SPDX-License-Identifier: Apache-2.0
"""Command line of the set-up."""

import argparse
import os
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from workspace import building, packages, processes, stages
from workspace.console import say
from workspace.errors import CommandError, Interrupted, SetupError
from workspace.layout import Layout
from workspace.lock import exclusive
from workspace.ros import find_system_ros

EXIT_FAILURE = 1


def main(arguments: Sequence[str]) -> int:
    """Make the workspace ready, or clean it; return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        with processes.signals_as_exceptions():
            _run(options)
    except SetupError as error:
        if isinstance(error, CommandError):
            print(processes.tail(error.log_text), file=sys.stderr)
        print(f'setup: {error}', file=sys.stderr)
        return EXIT_FAILURE
    except OSError as error:
        place = f'{error.filename}: ' if error.filename else ''
        print(f'setup: {place}{error.strerror}', file=sys.stderr)
        return EXIT_FAILURE
    except Interrupted as stop:
        print('setup: interrupted; the same command goes on from here', file=sys.stderr)
        return stop.exit_code
    return 0


def _run(options: argparse.Namespace) -> None:
    layout = Layout(Path(__file__).resolve().parents[2])
    if options.clean:
        with exclusive(layout.lock):
            _clean(layout)
        return
    workspace = stages.Workspace(layout, find_system_ros(os.environ, layout.root), os.environ)
    start = time.monotonic()
    if stages.is_ready(workspace, development=options.dev):
        say('ready')
        return
    with exclusive(layout.lock):
        count = processes.end_strays(layout.root)
        if count:
            say(f'ended {count} processes that an interrupted set-up had left')
        stages.make_ready(workspace, development=options.dev)
    say(f'ready after {time.monotonic() - start:.1f} s')


def _clean(layout: Layout) -> None:
    """Remove everything that set-up and the tools made, except runs."""
    building.clear(layout)
    names = ('log', '.pytest_cache', '.mypy_cache', '.ruff_cache', '.hypothesis')
    for path in [layout.venv, *(layout.root / name for name in names)]:
        packages.remove(path)
    for path in layout.cache.iterdir():
        if path != layout.lock:
            packages.remove(path)
    say('removed .venv, build, install, log and all caches; runs/ stays')


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(prog='tools/setup.sh', description=__doc__)
    parser.add_argument(
        '--dev', action='store_true', help='also install what make check and make test need'
    )
    parser.add_argument('--clean', action='store_true', help='remove everything that set-up made')
    return parser
