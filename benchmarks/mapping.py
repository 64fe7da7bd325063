# SPDX-License-Identifier: Apache-2.0
"""Measures the map: how many photographs it ties, how far it is off, and what it costs.

``python benchmarks/mapping.py CASE ... --data FOLDER`` prints a table with the targets beside the
measured values. FOLDER holds ``synth20`` and ``brighton_beach``. Foreign tools are measured in the
same run where ``--foreign PYTHON`` names an interpreter that has stitching and pycolmap.
"""

import argparse
import sys
from collections.abc import Callable
from pathlib import Path

from mapping_accuracy import brighton, derailment, synth20, true20
from mapping_faults import robust
from mapping_figures import Row, peak_mb
from mapping_kill import kill
from mapping_load import live, scale
from rich.console import Console
from rich.table import Table

from rocsafe_mapping.allocation import keep_freed_memory


def main() -> int:
    """Measure the cases that were asked for."""
    options = _parser().parse_args()
    keep_freed_memory()
    table = Table('case', 'measured', 'target')
    for case in options.cases or sorted(CASES):
        for row in CASES[case](options):
            table.add_row(*row)
    table.add_row('peak memory of all', f'{peak_mb()} MB', '')
    Console(width=160).print(table)
    return 0


CASES: dict[str, Callable[[argparse.Namespace], list[Row]]] = {
    'brighton': brighton,
    'derailment': derailment,
    'kill': kill,
    'live': live,
    'robust': robust,
    'scale': scale,
    'synth20': synth20,
    'true20': true20,
}


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument('cases', nargs='*', metavar='CASE', help=', '.join(CASES))
    parser.add_argument('--data', type=Path, required=True, metavar='FOLDER')
    parser.add_argument('--foreign', metavar='PYTHON', help='has stitching and pycolmap')
    parser.add_argument('--resolution', type=float, default=0.05, help='of `derailment`, m')
    parser.add_argument('--count', type=int, default=1000, help='photographs of `scale`')
    parser.add_argument('--mosaic-kills', type=int, default=5, help='of `kill`')
    parser.add_argument('--seeds', type=int, default=5, help='flights of each case of `robust`')
    parser.add_argument('--rate', type=float, default=60.0, help='images a minute of `live`')
    return parser


if __name__ == '__main__':
    sys.exit(main())
