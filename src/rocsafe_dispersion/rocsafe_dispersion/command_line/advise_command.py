# SPDX-License-Identifier: Apache-2.0
"""The command `advise`: which agent, what to find out next, which procedures, without ROS."""

import argparse
import dataclasses
import json
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_dispersion.estimator_options import estimator_options
from rocsafe_dispersion.identification.evidence import Evidence, Report
from rocsafe_dispersion.identification.flight_reports import flight_reports
from rocsafe_dispersion.identification.posterior import Identification, identify
from rocsafe_dispersion.identification.procedures import (
    SHIPPED,
    RankedSection,
    question,
    rank_sections,
    read_sections,
)
from rocsafe_dispersion.identification.sensor_report import SensorReport
from rocsafe_dispersion.identification.signatures import placards, signatures
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
        found = identify(evidence)
        document = document_of(
            evidence, found, rank_sections(sections, question(evidence, found), options.count)
        )
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


def document_of(
    evidence: Evidence, found: Identification, procedures: Sequence[RankedSection]
) -> dict[str, Any]:
    """Return the advice as values for JSON."""
    return {
        'agents': [
            {
                'name': name,
                'category': agents()[name].category if name in agents() else '',
                'probability': round(probability, 6),
            }
            for name, probability in found.probabilities
        ],
        'categories': {name: round(value, 6) for name, value in found.categories.items()},
        'entropy_bit': round(found.entropy_bit, 4),
        'next_observations': [
            {'observation': one.observation, 'gain_bit': round(one.gain_bit, 4)}
            for one in found.next_observations
        ],
        'notes': _notes(evidence),
        'evidence': _plain(evidence),
        'procedures': [_procedure(one, evidence) for one in procedures],
    }


def _evidence(options: argparse.Namespace) -> Evidence:
    """Return the evidence of file, readings and command line together."""
    found = Evidence() if options.evidence is None else read_values(options.evidence, Evidence)
    said = [Report(observation=name, is_true=True) for name in options.saw]
    said += [Report(observation=name, is_true=False) for name in options.no]
    if options.un is not None and found.un_number not in (None, options.un):
        raise ValueError(f'--un {options.un}: the file says un_number {found.un_number}')
    return Evidence(
        reports=(*found.reports, *said),
        sensors=(*found.sensors, *map(_sensor, options.sensor), *_flown(options.readings)),
        un_number=found.un_number if options.un is None else options.un,
    )


def _flown(path: Path | None) -> tuple[SensorReport, ...]:
    if path is None:
        return ()
    options = estimator_options(path)
    log = options.log()
    GasSpool(options.spool_directory).restore(log)
    return flight_reports(log.readings())


def _sensor(text: str) -> SensorReport:
    kind, _, reading = text.partition('=')
    try:
        value = float(reading)
    except ValueError:
        raise ValueError(f'--sensor {text}: must be KIND=READING, a number') from None
    return SensorReport(sensor=kind, reading=value)


def _notes(evidence: Evidence) -> list[str]:
    """Return what the reader must know about the evidence."""
    notes = []
    number = evidence.un_number
    if number is not None and number not in placards().values():
        notes.append(f'UN {number} is not in the table: it speaks against those that are')
    if evidence.sensors and not any(report.is_seen for report in evidence.sensors):
        notes.append('no detector shows gas: their silence counts only where they were in the gas')
    return notes


def _plain(evidence: Evidence) -> dict[str, Any]:
    content = dataclasses.asdict(evidence)
    for row, report in zip(content['sensors'], evidence.sensors, strict=True):
        row |= {'unit': report.kind.unit, 'is_seen': report.is_seen}
    return content


def _procedure(ranked: RankedSection, evidence: Evidence) -> dict[str, Any]:
    """Return a section with the reports, their times and places, because of which it is there."""
    words = set(ranked.because_of)
    reports = [
        dataclasses.asdict(report)
        for report in evidence.reports
        if report.is_true and words & set(report.observation.split('_')[1:])
    ]
    return {
        'file': ranked.section.file,
        'heading': ranked.section.heading,
        'score': round(ranked.score, 4),
        'because_of': list(ranked.because_of),
        'reports': reports,
        'text': ranked.section.text,
    }


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
