# SPDX-License-Identifier: Apache-2.0
"""The command `localize`: sources from a survey file, without ROS."""

import argparse
import json
import sys
from collections.abc import Sequence

import numpy as np

from rocsafe_hazard.next_places import MeasuringPlace
from rocsafe_radiation.command_line.file_survey import file_survey
from rocsafe_radiation.command_line.localize_arguments import AUTO, parser
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.detection.detector import response_of
from rocsafe_radiation.errors import RadiationError
from rocsafe_radiation.localization.estimates import Localization
from rocsafe_radiation.localization.localize import LocalizationOptions
from rocsafe_radiation.physics.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.products.assessment import (
    Assessment,
    AssessmentOptions,
    assess,
    suggested_waypoints,
)
from rocsafe_radiation.products.cordon import DEFAULT_LEVELS_USVH
from rocsafe_radiation.products.dose_map import LARGEST_CELLS
from rocsafe_radiation.products.files import write_products
from rocsafe_radiation.products.source_document import (
    assessment_document,
    place_of,
    source_document,
)
from rocsafe_radiation.readings.readings_file import ReadingsFile, read_readings

EXIT_OK, EXIT_REFUSED = 0, 2
MOST_LINES_NAMED = 5


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, localise, print, and return the exit code."""
    options = parser().parse_args(arguments)
    notes: list[str] = []
    try:
        readings = read_readings(options.file, options.height, options.ground)
        notes = _notes(readings)
        survey = file_survey(readings, options)
        assessment = assess(survey, _options(options, readings), largest_cells=LARGEST_CELLS)
        if options.out is not None:
            write_products(options.out, assessment, readings.frame)
    except (RadiationError, OSError) as error:
        sys.stderr.write(f'error: {"; ".join([str(error), *notes])}\n')
        return EXIT_REFUSED
    places = suggested_waypoints(assessment, options.next)
    if options.json:
        document = assessment_document(assessment, readings.frame)
        document['notes'] = notes
        document['next_places'] = [
            place_of(np.array(one.place_m), readings.frame) for one in places
        ]
        sys.stdout.write(json.dumps(document, indent=1) + '\n')
    else:
        lines = [*notes, *_lines(assessment.found, readings)]
        lines += _advice(assessment, places, readings)
        sys.stdout.write('\n'.join(lines) + '\n')
    return EXIT_OK


def _options(options: argparse.Namespace, readings: ReadingsFile) -> AssessmentOptions:
    model = options.model
    if model == AUTO:
        model = PAPER_MODEL if readings.models == {PAPER_MODEL} else AIR_MODEL
    kernel = Kernel(
        is_lossy=model == AIR_MODEL,
        nuclide=options.nuclide,
        response=response_of(options.detector),
    )
    up_m, up_std_m = options.source_height
    return AssessmentOptions(
        known=LocalizationOptions(
            kernel=kernel,
            source_up_m=up_m,
            source_up_std_m=up_std_m,
            position_std_m=options.fix_error,
        ),
        method=options.method,
        rule=StoppingRule(
            false_alarm=options.errors,
            missed=options.errors,
            ellipse_95_m=options.ellipse,
            smallest_usvh=options.smallest,
        ),
        levels_usvh=tuple(options.levels or DEFAULT_LEVELS_USVH),
    )


def _advice(
    assessment: Assessment, places: Sequence[MeasuringPlace], readings: ReadingsFile
) -> list[str]:
    rule = assessment.options.rule
    limits = f'errors {rule.false_alarm:.2g}, ellipses within {rule.ellipse_95_m:g} m'
    enough = 'enough' if assessment.verdict.is_enough else 'not enough yet'
    lines = [f'the evidence is {enough}: {assessment.verdict.reason} ({limits})']
    for place in places:
        named = place_of(np.array(place.place_m), readings.frame)
        where = ', '.join(f'{name} {value}' for name, value in named.items())
        lines.append(f'measure next at {where}')
    return lines


def _notes(readings: ReadingsFile) -> list[str]:
    notes = [
        f'{len(lines)} rows left out: {reason} ({_named(lines)})'
        for reason, lines in readings.dropped.items()
    ]
    if readings.backward_steps:
        notes.append(f'the clock went backwards {readings.backward_steps} times; rows kept')
    return notes


def _named(lines: Sequence[int]) -> str:
    named = ', '.join(map(str, lines[:MOST_LINES_NAMED]))
    more = ' and more' if len(lines) > MOST_LINES_NAMED else ''
    return f'line{"s" if len(lines) > 1 else ""} {named}{more}'


def _lines(found: Localization, readings: ReadingsFile) -> list[str]:
    chances = ', '.join(f'{k}: {p:.3f}' for k, p in enumerate(found.order_probabilities))
    lines = [
        f'{found.reading_count} readings, background {found.background_usvh:.3g} uSv/h'
        + (' (uneven)' if found.is_structured else ''),
        f'probability of the number of sources: {chances}',
    ]
    document = source_document(found, readings.frame)
    for number, source in enumerate(document['sources'], 1):
        low, high = source['dose_rate_at_1m_95_usvh']
        place = source['place']
        where = ', '.join(f'{name} {value}' for name, value in place.items())
        lines.append(
            f'source {number}: {where}; within {source["ellipse_95_m"][0]:.2f} x '
            f'{source["ellipse_95_m"][1]:.2f} m (95 %); '
            f'{source["dose_rate_at_1m_usvh"]:.4g} uSv/h at 1 m ({low:.4g} to {high:.4g})'
        )
    lines += [f'not as assumed: {doubt}' for doubt in found.doubts]
    return lines if found.sources else [*lines, 'no source found']


if __name__ == '__main__':
    raise SystemExit(main())
