# SPDX-License-Identifier: Apache-2.0
"""Arguments of the command `localize`."""

import argparse
import math
from pathlib import Path

from rocsafe_geo.argument import number
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.detection.detector import DETECTOR_NAMES, IDEAL
from rocsafe_radiation.localization.estimates import METHODS, ML_METHOD
from rocsafe_radiation.localization.localize import LocalizationOptions
from rocsafe_radiation.physics.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE, nuclide_names

AUTO = 'auto'
COLUMNS = """\
columns of the file, comma separated, with a row of names; others are ignored:
  latitude_deg, longitude_deg, altitude_m   WGS84, metres above any one datum
  or east_m, north_m, up_m                  metres in any local frame, up above the ground
  dose_rate_usvh                            microsievert per hour; or _nsvh, _msvh, _svh (per
                                            hour) or _usvps (microsievert per second)
  or counts, live_time_s                    with --sensitivity; best give both
  dose_rate_std_usvh, time_ns, vehicle      optional
  saturated                                 1: the detector was saturated; left out (without the
                                            column: values that pile up at the largest one)
  reference_counts                          of a window of the spectrum above the lines of the
                                            source: they predict the background of counts
Rows without a valid place and value are left out; their number and lines are printed.
"""


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(
        prog='rocsafe localize',
        description='Find gamma sources in a file of readings, with their uncertainty.',
        epilog=COLUMNS,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    found.add_argument(
        'file', type=Path, metavar='READINGS.csv', help='file of readings; columns: below'
    )
    _add_physics(found.add_argument_group('prior knowledge'))
    _add_ground(found.add_argument_group('ground'))
    _add_method(found.add_argument_group('search'))
    _add_output(found.add_argument_group('output'))
    return found


def _add_physics(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        '--model',
        choices=(AUTO, PAPER_MODEL, AIR_MODEL),
        default=AUTO,
        help='law of the dose rate (default: that of the file, else air)',
    )
    group.add_argument(
        '--nuclide',
        choices=nuclide_names(),
        default=DEFAULT_NUCLIDE,
        metavar='NAME',
        help=f'nuclide whose photons air attenuates (default: {DEFAULT_NUCLIDE})',
    )
    group.add_argument(
        '--sensitivity',
        type=number(1e-6, 1e7),
        default=0.0,
        metavar='CPS',
        help='counts a second for 1 uSv/h (default: from counts and dose rate)',
    )
    group.add_argument(
        '--height',
        type=number(0.0, 1e4),
        default=math.nan,
        metavar='M',
        help='height above the ground of a file without altitudes, metres',
    )
    _add_measurement(group)


def _add_measurement(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        '--detector',
        choices=DETECTOR_NAMES,
        default=IDEAL,
        help='kind of detector, which counts photons that air and soil scatter, too '
        f'(default: {IDEAL}, readings are dose rates)',
    )
    known = LocalizationOptions()
    group.add_argument(
        '--fix-error',
        type=number(0.0, 100.0),
        default=known.position_std_m,
        metavar='M',
        help='standard deviation of each coordinate of the fixes, metres '
        f'(default: {known.position_std_m:g})',
    )
    group.add_argument(
        '--source-height',
        type=number(-100.0, 1e3),
        nargs=2,
        default=(known.source_up_m, known.source_up_std_m),
        metavar=('M', 'STD'),
        help='height of sources above the ground and its standard deviation, metres '
        f'(default: {known.source_up_m:g} {known.source_up_std_m:g})',
    )


def _add_ground(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        '--ground',
        type=number(-1e3, 1e4),
        default=math.nan,
        metavar='M',
        help='altitude of level ground, in the datum of the file, metres (default: that of the '
        'lowest reading, if the file begins with a take-off; never enough evidence then)',
    )
    group.add_argument(
        '--terrain',
        default='',
        metavar='FILE',
        help='heights of ground that is not level, for a file of degrees: a GeoTIFF, or what '
        '`rocsafe scene solids` writes',
    )
    group.add_argument(
        '--terrain-at',
        type=number(-180.0, 1e4),
        nargs=3,
        action='append',
        default=[],
        metavar=('LAT', 'LON', 'ALT'),
        help='a place on the ground with its altitude in the datum of the file: the heights of '
        '--terrain are shifted to agree; may be repeated (default: same datum)',
    )


def _add_method(group: argparse._ArgumentGroup) -> None:
    rule = StoppingRule()
    group.add_argument(
        '--method',
        choices=METHODS,
        default=ML_METHOD,
        help='poisson-ml: maximum likelihood; belief-grid: yes-or-no readings, known to a cell '
        f'(default: {ML_METHOD})',
    )
    group.add_argument(
        '--errors',
        type=number(1e-6, 0.49),
        default=rule.false_alarm,
        metavar='P',
        help='probability of each wrong decision at which the evidence is enough '
        f'(default: {rule.false_alarm:g})',
    )
    group.add_argument(
        '--ellipse',
        type=number(1e-3, 1e4),
        default=rule.ellipse_95_m,
        metavar='M',
        help='longest half axis of a 95 %% ellipse that is precise enough, metres '
        f'(default: {rule.ellipse_95_m:g})',
    )
    group.add_argument(
        '--smallest',
        type=number(1e-3, 1e9),
        default=rule.smallest_usvh,
        metavar='USVH',
        help='dose rate at 1 m of the weakest source that matters, uSv/h '
        f'(default: {rule.smallest_usvh:g}, 1 GBq of Cs-137)',
    )


def _add_output(group: argparse._ArgumentGroup) -> None:
    group.add_argument(
        '--levels',
        type=number(1e-3, 1e9),
        nargs='+',
        metavar='USVH',
        help='dose rates of cordons, uSv/h at 1 m (default: 2.5 25 100 1000 100000)',
    )
    group.add_argument(
        '--next',
        type=int,
        choices=range(101),
        default=0,
        metavar='N',
        help='also print N places at which to measure next',
    )
    group.add_argument('--json', action='store_true', help='print JSON instead of a table')
    group.add_argument(
        '--out',
        type=Path,
        metavar='DIR',
        help='also write sources.json and, for places in degrees, sources.geojson, '
        'cordons.geojson, cordons.kml and dose_map.tif',
    )
