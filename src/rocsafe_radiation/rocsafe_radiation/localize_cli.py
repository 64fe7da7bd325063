# SPDX-License-Identifier: Apache-2.0
"""`localize`: sources from a survey file, without ROS."""

import argparse
import dataclasses
import json
import math
import sys
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rocsafe_radiation.cordon import DEFAULT_LEVELS_USVH
from rocsafe_radiation.errors import RadiationError
from rocsafe_radiation.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.kernel import Kernel
from rocsafe_radiation.localization import Localization, LocalizationOptions, localize
from rocsafe_radiation.nuclide import DEFAULT_NUCLIDE, nuclide_names
from rocsafe_radiation.products import write_products
from rocsafe_radiation.readings_file import ReadingsFile, read_readings
from rocsafe_radiation.source_document import place_of, source_document
from rocsafe_radiation.spectral_window import background_shape
from rocsafe_radiation.stopping import StoppingRule
from rocsafe_radiation.survey import Survey, survey_of
from rocsafe_radiation.waypoint_choice import candidate_places, next_waypoints

Array = NDArray[np.float64]
EXIT_OK, EXIT_REFUSED = 0, 2
AUTO = 'auto'
COLUMNS = """\
columns of the file, comma separated, with a row of names; others do not matter:
  latitude_deg, longitude_deg, altitude_m   WGS84, metres above any one datum
  or east_m, north_m, up_m                  metres in any local frame, up above the ground
  dose_rate_usvh                            microsievert per hour; or _nsvh, _msvh, _svh (per
                                            hour) or _usvps (microsievert per second)
  or counts, live_time_s                    with --sensitivity; or both, which is best
  dose_rate_std_usvh, time_ns, vehicle      if there are any
  reference_counts                          of a window of the spectrum above the lines of the
                                            source: they foretell the background of counts
Rows without a valid place and value are left out and counted.
"""


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, localise, print, and return the exit code."""
    options = _parser().parse_args(arguments)
    try:
        readings = read_readings(options.file, options.height)
        known = _options(options, readings)
        survey = _survey(readings, options.sensitivity)
        found = localize(survey, known)
        if options.out is not None:
            levels = options.levels or DEFAULT_LEVELS_USVH
            write_products(options.out, found, survey, known.kernel, readings.frame, levels)
    except (RadiationError, OSError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_REFUSED
    places = _next_places(found, survey, known, options.next)
    if options.json:
        document = source_document(found, readings.frame)
        document['is_enough'] = StoppingRule().is_enough(found)
        document['next_places'] = [place_of(one, readings.frame) for one in places]
        sys.stdout.write(json.dumps(document, indent=1) + '\n')
    else:
        lines = [*_notes(readings), *_lines(found, readings), *_advice(found, places, readings)]
        sys.stdout.write('\n'.join(lines) + '\n')
    return EXIT_OK


def _parser() -> argparse.ArgumentParser:
    parser = argparse.ArgumentParser(
        prog='rocsafe localize',
        description='Find gamma sources in a file of readings, and say how sure that is.',
        epilog=COLUMNS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument('file', type=Path, metavar='READINGS.csv')
    parser.add_argument(
        '--model',
        choices=(AUTO, PAPER_MODEL, AIR_MODEL),
        default=AUTO,
        help='law of the dose rate (default: what the file says, else air)',
    )
    parser.add_argument(
        '--nuclide',
        choices=nuclide_names(),
        default=DEFAULT_NUCLIDE,
        metavar='NAME',
        help=f'whose photons air attenuates (default: {DEFAULT_NUCLIDE})',
    )
    parser.add_argument(
        '--sensitivity',
        type=_number('sensitivity', 1e-6, 1e7),
        default=0.0,
        metavar='CPS',
        help='counts a second for 1 uSv/h (default: from counts and dose rate)',
    )
    parser.add_argument(
        '--height',
        type=_number('height', 0.0, 1e4),
        default=math.nan,
        metavar='M',
        help='metres above the ground, of a file without altitudes',
    )
    parser.add_argument(
        '--levels',
        type=_number('level', 1e-3, 1e9),
        nargs='+',
        metavar='USVH',
        help='dose rates of cordons, uSv/h at 1 m (default: 2.5 25 100 1000 100000)',
    )
    parser.add_argument(
        '--next',
        type=int,
        choices=range(101),
        default=0,
        metavar='N',
        help='also say at which N places to measure next to place the sources better',
    )
    parser.add_argument('--json', action='store_true', help='print JSON instead of a table')
    parser.add_argument(
        '--out',
        type=Path,
        metavar='DIR',
        help='also write sources.json and, of places in degrees, sources.geojson, '
        'cordons.geojson, cordons.kml and dose_map.tif',
    )
    return parser


def _number(name: str, low: float, high: float) -> Callable[[str], float]:
    def parse(text: str) -> float:
        try:
            value = float(text)
        except ValueError:
            value = math.nan
        if not low <= value <= high:
            raise argparse.ArgumentTypeError(
                f'{name} = {text}: must be within {low:g} to {high:g}'
            )
        return value

    return parse


def _options(options: argparse.Namespace, readings: ReadingsFile) -> LocalizationOptions:
    model = options.model
    if model == AUTO:
        model = PAPER_MODEL if readings.models == {PAPER_MODEL} else AIR_MODEL
    return LocalizationOptions(kernel=Kernel(is_lossy=model == AIR_MODEL, nuclide=options.nuclide))


def _survey(readings: ReadingsFile, sensitivity: float) -> Survey:
    survey = survey_of(readings.observations, sensitivity)
    reference = np.array(readings.reference_counts, np.float64)
    if not reference.sum() > 0.0:
        return survey
    shape = background_shape(survey.positions_enu_m, reference)
    return dataclasses.replace(survey, background_shape=shape)


def _next_places(
    found: Localization, survey: Survey, known: LocalizationOptions, count: int
) -> list[Array]:
    """Return the places, east, north, up, from which a reading tells most."""
    candidates = candidate_places(survey, known.source_up_m)
    exposure = float(np.median(survey.exposures))
    chosen = next_waypoints(found, candidates, exposure, known.kernel, count)
    return [np.array(one.position_enu_m) for one in chosen]


def _advice(found: Localization, places: list[Array], readings: ReadingsFile) -> list[str]:
    rule = StoppingRule()
    limits = f'errors {rule.false_alarm:.0%}, ellipses within {rule.ellipse_95_m:g} m'
    enough = 'enough' if rule.is_enough(found) else 'not enough yet'
    lines = [f'the evidence is {enough} ({limits})']
    for place in places:
        where = ', '.join(f'{k} {v}' for k, v in place_of(place, readings.frame).items())
        lines.append(f'measure next at {where}')
    return lines


def _notes(readings: ReadingsFile) -> list[str]:
    notes = [f'{count} rows left out: {reason}' for reason, count in readings.dropped.items()]
    if readings.backward_steps:
        notes.append(f'the clock went backwards {readings.backward_steps} times; rows kept')
    return notes


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
    return lines if found.sources else [*lines, 'no source found']


if __name__ == '__main__':
    raise SystemExit(main())
