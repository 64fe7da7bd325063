# SPDX-License-Identifier: Apache-2.0
"""The command `advise`: which agent, what to find out next, which procedures, without ROS."""

import argparse
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rocsafe_dispersion.estimator_options import estimator_options
from rocsafe_dispersion.identification.advice import advice, advice_document
from rocsafe_dispersion.identification.evidence import Evidence, Report
from rocsafe_dispersion.identification.evidence_log import EvidenceLog, ReportSpool
from rocsafe_dispersion.identification.procedures import SHIPPED, read_sections
from rocsafe_dispersion.identification.sensor_report import SensorReport
from rocsafe_dispersion.identification.signatures import signatures
from rocsafe_dispersion.mission_gas.gas_spool import GasSpool
from rocsafe_geo.limits import require_between
from rocsafe_geo.storage.value_file import read_values
from rocsafe_hazard.row_spool import SpoolError

EXIT_OK, EXIT_REFUSED = 0, 2
MOST_SHOWN = 8
ADVICE_FILE = 'advice.json'


def main(arguments: Sequence[str] | None = None) -> int:
    """Read the evidence, weigh it, print, write, and return the exit code."""
    options = parser().parse_args(arguments)
    try:
        require_between('--count', options.count, 1, 100)
        evidence = _evidence(options)
        sections = read_sections(options.procedures)
        document = advice_document(advice(evidence, sections, options.count))
        if options.out is not None:
            options.out.mkdir(parents=True, exist_ok=True)
            text = json.dumps(document, indent=1) + '\n'
            (options.out / ADVICE_FILE).write_text(text, encoding='utf-8')
    except (ValueError, OSError, SpoolError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_REFUSED
    sys.stdout.write(json.dumps(document, indent=2) + '\n' if options.json else _text(document))
    return EXIT_OK


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(
        prog='rocsafe advise',
        description='Estimate from observations which agent was released, and rank sections of '
        'procedures by how well they fit.',
        epilog='Observations: ' + ', '.join(signatures().observations),
    )
    found.add_argument(
        'evidence',
        nargs='?',
        type=Path,
        metavar='EVIDENCE.yaml',
        help='file of observations; its keys are in docs/dispersion.md',
    )
    found.add_argument(
        '--readings',
        type=Path,
        metavar='FILE',
        help='also use the readings of a run: its params/estimator.yaml',
    )
    for name, value, text in (
        ('--saw', 'OBSERVATION', 'was observed; may be repeated'),
        ('--no', 'OBSERVATION', 'was looked for and is absent; may be repeated'),
        (
            '--sensor',
            'KIND=READING',
            'reading of a gas sensor, in the unit of its kind; may be repeated',
        ),
    ):
        found.add_argument(name, action='append', default=[], metavar=value, help=text)
    found.add_argument('--un', type=int, metavar='NUMBER', help='UN number on a placard')
    found.add_argument(
        '--procedures',
        type=Path,
        default=SHIPPED,
        metavar='DIR',
        help='folder of procedures in Markdown (default: the examples that are supplied)',
    )
    found.add_argument(
        '--count', type=int, default=5, metavar='N', help='largest number of sections (default: 5)'
    )
    found.add_argument('--out', type=Path, metavar='DIR', help=f'also write {ADVICE_FILE} there')
    found.add_argument('--json', action='store_true', help='print JSON instead of a table')
    return found


def _evidence(options: argparse.Namespace) -> Evidence:
    """Return the evidence of file, readings and command line together."""
    found = Evidence() if options.evidence is None else read_values(options.evidence, Evidence)
    said = [Report(observation=name, is_true=True) for name in options.saw]
    said += [Report(observation=name, is_true=False) for name in options.no]
    if options.un is not None and found.un_number not in (None, options.un):
        raise ValueError(f'--un {options.un}: the file says un_number {found.un_number}')
    flown = _flown(options.readings)
    numbers = (options.un, found.un_number, flown.un_number)
    return Evidence(
        reports=(*found.reports, *said, *flown.reports),
        sensors=(*found.sensors, *map(_sensor, options.sensor), *flown.sensors),
        un_number=next((n for n in numbers if n is not None), None),
    )


def _flown(path: Path | None) -> Evidence:
    """Return what the detectors of a flight showed, and what people reported during it."""
    log = EvidenceLog()
    if path is not None:
        directory = estimator_options(path).spool_directory
        ReportSpool(directory).restore(log)
        for reading in GasSpool(directory).gas():
            log.add_gas(reading)
    return log.evidence()


def _sensor(text: str) -> SensorReport:
    kind, _, reading = text.partition('=')
    try:
        value = float(reading)
    except ValueError:
        raise ValueError(f'--sensor {text}: must be KIND=READING, a number') from None
    return SensorReport(sensor=kind, reading=value)


def _text(document: dict[str, Any]) -> str:
    lines = [
        f'{row["probability"]:8.4f}  {row["name"]} {row["category"]}'.rstrip()
        for row in document['agents'][:MOST_SHOWN]
    ]
    lines += [f'note: {note}' for note in document['notes']]
    lines.append('find out next:')
    lines += [
        f'{row["gain_bit"]:8.3f}  bit by {row["observation"]}'
        for row in document['next_observations'][:3]
    ]
    lines.append('procedures:')
    lines += [
        f'{row["score"]:8.3f}  {row["file"]}: {row["heading"]} [{", ".join(row["because_of"])}]'
        for row in document['procedures']
    ]
    return '\n'.join(lines) + '\n'


if __name__ == '__main__':
    raise SystemExit(main())
