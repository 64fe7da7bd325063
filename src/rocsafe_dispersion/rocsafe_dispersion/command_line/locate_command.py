# SPDX-License-Identifier: Apache-2.0
"""The command `locate-release`: releases from a table of readings, without ROS."""

import argparse
import json
import sys
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_dispersion.agents.agent_table import PARTICLES, Agent, agent
from rocsafe_dispersion.detection.gas_sensor import OPEN_PATH
from rocsafe_dispersion.estimation.amount import Amount
from rocsafe_dispersion.estimation.found_release import FoundRelease
from rocsafe_dispersion.estimation.gas_csv import GasFile, read_gas
from rocsafe_dispersion.estimation.gas_survey import averaged
from rocsafe_dispersion.estimation.locate import (
    LocatedReleases,
    locate_releases,
    usual_speed_mps,
)
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.estimation.slow_response import without_delay
from rocsafe_dispersion.estimator_options import estimator_options
from rocsafe_dispersion.mission_gas.gas_log import GasFlightReading
from rocsafe_dispersion.mission_gas.gas_spool import GasSpool
from rocsafe_dispersion.mission_gas.near_field import near_field, near_field_line
from rocsafe_dispersion.mission_gas.release_assessment import (
    ReleaseAssessment,
    assess,
    search_area,
)
from rocsafe_dispersion.mission_gas.release_files import write_release_files
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.losses import Losses
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.stability import CLASSES, StabilityClass, layer_of_class
from rocsafe_hazard.row_spool import SpoolError

# More readings of a table are averaged: time and memory grow with their number.
MOST_FITTED = 300
MOMENTS = (('started', 'start_95_s'), ('ended', 'end_95_s'))
EXIT_OK, EXIT_REFUSED = 0, 2
PARAMETER_FILES = ('.yaml', '.yml')
# Assumptions about a table of readings that says nothing of them.
TABLE_DEFAULTS = {
    'stability': 'D', 'roughness': 0.03, 'release_height': 0.5, 'anemometer': 10.0,
    'margin': 20.0, 'most': 3, 'settling': 0.0, 'decay': 0.0,
}  # fmt: skip
# Assumptions that replace those of a run, and their options of the node ``estimator``.
OF_A_RUN = {
    'agent': 'agent', 'stability': 'stability', 'roughness': 'roughness_m',
    'release_height': 'release_height_m', 'settling': 'settling_mps', 'decay': 'decay_per_s',
}  # fmt: skip


def main(arguments: Sequence[str] | None = None) -> int:
    """Read, estimate, print, write, and return the exit code."""
    options = parser().parse_args(arguments)
    try:
        is_flight = options.file.suffix in PARAMETER_FILES
        document = _of_flight(options) if is_flight else _of_table(options)
    except (ValueError, OSError, SpoolError) as error:
        sys.stderr.write(f'error: {error}\n')
        return EXIT_REFUSED
    sys.stdout.write(json.dumps(document, indent=2) + '\n' if options.json else _text(document))
    return EXIT_OK


def _of_table(options: argparse.Namespace) -> dict[str, Any]:
    if options.out is not None:
        raise ValueError('--out needs params/estimator.yaml of a run, not a table of readings')
    for name, value in TABLE_DEFAULTS.items():
        if getattr(options, name) is None:
            setattr(options, name, value)
    gas = read_gas(options.file, agent(options.agent).g_m3 if options.agent else None)
    survey, responses_s = without_delay(averaged(gas.survey, MOST_FITTED))
    notes = list(gas.notes)
    if responses_s:
        slowest_s = max(responses_s.values())
        notes.append(f'a sensor follows the gas within about {slowest_s:.2g} s: undone')
    gas = replace(gas, survey=survey, notes=tuple(notes))
    area = search_area(gas.survey.places_m, options.margin, options.release_height)
    found = _located(gas, area, options)
    verdict = ReleaseRule().verdict(found)
    known = agent(options.agent) if options.agent else None
    layer = _layer(gas, options)
    return document_of(found, gas.frame, known, layer, options.stability) | {
        'is_enough': verdict.is_enough,
        'verdict': verdict.reason,
        'notes': list(gas.notes),
    }


def _of_flight(given: argparse.Namespace) -> dict[str, Any]:
    """Return what the readings that the node ``estimator`` has kept say; write it to a folder."""
    for name in sorted(TABLE_DEFAULTS.keys() - OF_A_RUN.keys()):
        if getattr(given, name) is not None:
            raise ValueError(f'--{name} is for a table of readings; a run says it itself')
    changed = {
        field: getattr(given, name)
        for name, field in OF_A_RUN.items()
        if getattr(given, name) is not None
    }
    options = replace(estimator_options(given.file), **changed)
    log = options.log()
    GasSpool(options.spool_directory).restore(log)
    assessment = assess(log.survey(), options.assessment())
    document = _assessed(assessment, log.frame)
    document['highest_reading'] = _highest(
        log.highest(assessment.flight.sensor), assessment, log.frame
    )
    if given.out is not None:
        write_release_files(given.out, document, assessment, log.frame)
    return document


def _highest(
    reading: GasFlightReading, assessment: ReleaseAssessment, frame: LocalFrame
) -> dict[str, Any]:
    counted = assessment.found.amount
    height_m = reading.altitude_m - frame.origin.altitude_m
    return {
        'value': reading.corrected * (counted.shown(PARTICLES) if counted.is_particles else 1.0),
        'unit': 'ppm m' if reading.unit == OPEN_PATH else counted.shown_unit,
        'vehicle': reading.vehicle,
        'time_ns': reading.time_ns,
        'latitude_deg': reading.latitude_deg,
        'longitude_deg': reading.longitude_deg,
        'height_agl_m': round(height_m, 2),
        'is_saturated': reading.is_saturated,
    }


def _assessed(assessment: ReleaseAssessment, frame: LocalFrame) -> dict[str, Any]:
    flight = assessment.flight
    layer, stability = assessment.layer, assessment.stability
    return document_of(assessment.found, frame, flight.agent, layer, stability) | {
        'agent': flight.agent.name,
        'sensor': flight.sensor,
        'wind_towards_mps': list(flight.wind_towards_mps),
        'reading_count': len(flight.survey.values_g_m3),
        'is_enough': assessment.verdict.is_enough,
        'verdict': assessment.verdict.reason,
        'threat_zones': [
            {
                'level': zone.level.label,
                'ppm': zone.level.ppm,
                'expected_m2': round(zone.expected.area, 1),
                'outer_95_m2': round(zone.outer.area, 1),
                'is_cut_by_the_map': zone.is_cut,
            }
            for zone in assessment.zones
        ],
    }


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    found = argparse.ArgumentParser(
        prog='rocsafe locate-release',
        description='Find releases of gas or particles, their places and rates, in readings of '
        'concentration and wind. Columns of the file: docs/dispersion.md.',
    )
    found.add_argument(
        'file',
        type=Path,
        metavar='READINGS.csv',
        help='file of readings, or params/estimator.yaml of a run',
    )
    found.add_argument('--agent', help='chemical that was measured; needed for readings in ppm')
    found.add_argument(
        '--stability', choices=CLASSES,
        help='Pasquill class of the stability of the air (default: D, or that of the run)',
    )  # fmt: skip
    found.add_argument(
        '--roughness', type=float, metavar='M',
        help='roughness length of the ground, metres (default: 0.03, or that of the run)',
    )  # fmt: skip
    found.add_argument(
        '--anemometer',
        type=float,
        metavar='M',
        help='height above the ground at which the wind was measured, metres (default: 10)',
    )
    found.add_argument(
        '--release-height',
        type=float,
        metavar='M',
        help='height of the release above the ground, metres (default: 0.5, or that of the run)',
    )
    found.add_argument(
        '--settling',
        type=float,
        metavar='MPS',
        help='speed at which what is released falls, m/s (default: 0, or that of the run)',
    )
    found.add_argument(
        '--decay',
        type=float,
        metavar='PER_S',
        help='share of it that decays in a second, 1/s (default: 0, or that of the run)',
    )
    found.add_argument(
        '--margin',
        type=float,
        metavar='M',
        help='distance around the readings within which releases are searched, metres '
        '(default: 20)',
    )
    found.add_argument(
        '--most', type=int, metavar='N',
        help='largest number of releases (default: 3)',
    )  # fmt: skip
    found.add_argument(
        '--out', type=Path, metavar='DIR', help='also write the files of a run there'
    )
    found.add_argument('--json', action='store_true', help='print JSON instead of a table')
    return found


def document_of(
    found: LocatedReleases,
    frame: LocalFrame | None,
    known: Agent | None,
    layer: SurfaceLayer,
    stability: StabilityClass,
) -> dict[str, Any]:
    """Return what was found as values for JSON; `known` is what was released, if anybody knows."""
    return {
        'releases': [
            _release(release, found.amount, frame)
            | near_field(release.rate_g_s, known, layer, stability)
            for release in found.releases
        ],
        'another': {
            'rate': found.hidden.smallest_g_s,
            'rate_unit': found.amount.rate_unit,
            'ground_share': round(found.hidden.share, 4),
        },
        'number_probabilities': [round(one, 4) for one in found.number_probabilities],
        'gains_of_one_release_more': [round(gain, 2) for gain in found.gains],
        'gain_of_places': round(found.gain_of_places, 2),
        f'backgrounds_{found.amount.concentration_key}': found.background_g_m3.tolist(),
        'plume': {
            'width_factor': found.spread_y,
            'height_factor': found.spread_z,
            'wind_turned_anticlockwise_deg': round(float(np.degrees(found.turn_rad)), 3),
            'wrong_wind_probability': round(found.wrong_wind, 3),
        },
    }


def _located(gas: GasFile, area: SearchArea, options: argparse.Namespace) -> LocatedReleases:
    return locate_releases(
        gas.survey,
        area,
        _layer(gas, options),
        anemometer_m=options.anemometer,
        losses=Losses(settling_mps=options.settling, decay_per_s=options.decay),
        options=LocateOptions(most_releases=options.most),
    )


def _release(release: FoundRelease, amount: Amount, frame: LocalFrame | None) -> dict[str, Any]:
    east, north = release.place_m
    place: dict[str, Any] = {'east_m': east, 'north_m': north}
    if frame is not None:
        position = frame.position_of((east, north, 0.0))
        place = {'latitude_deg': position.latitude_deg, 'longitude_deg': position.longitude_deg}
    return place | {
        'rate': release.rate_g_s,
        'rate_unit': amount.rate_unit,
        'rate_95': [release.rate_low_g_s, release.rate_high_g_s],
        'std_m': np.sqrt(np.diag(release.covariance_m2)).tolist(),
        'region_95_m2': release.region_m2,
        'beyond_probability': round(release.beyond, 3),
        'moves_probability': round(release.moves, 3),
        'velocity_mps': release.velocity_mps,
        'started_before_probability': release.start.beyond,
        'start_95_s': release.start.bounds_s,
        'ended_after_probability': release.end.beyond,
        'end_95_s': release.end.bounds_s,
    }


def _layer(gas: GasFile, options: argparse.Namespace) -> SurfaceLayer:
    speed = usual_speed_mps(gas.survey)
    return layer_of_class(options.stability, speed, options.anemometer, options.roughness)


def _text(document: dict[str, Any]) -> str:
    hidden = document['another']
    share = 100.0 * hidden['ground_share']
    what = 'another' if document['releases'] else 'a release'
    lines = list(document.get('notes', ()))
    if not document['releases']:
        lines.append('no release: the readings are those of a background')
    for release in document['releases']:
        first, second = list(release.items())[:2]
        low, high = release['rate_95']
        place = f'{first[0]} {first[1]:.8g}, {second[0]} {second[1]:.8g}'
        rate = f'{release["rate"]:.3g} {release["rate_unit"]} (95 %: {low:.3g} to {high:.3g})'
        lines.append(f'{place}: {rate}, region of 95 %: {release["region_95_m2"]:.0f} m2')
        for verb, when in MOMENTS:
            if release[when] is not None:
                first_s, last_s = release[when]
                lines.append(f'it {verb} between {first_s:.0f} and {last_s:.0f} s (95 %)')
        if 'dense_gas' in release:
            lines.append(near_field_line(release['dense_gas']))
    where = (
        f'{what} of {hidden["rate"]:g} {hidden["rate_unit"]} may be in {share:.0f} % of the ground'
    )
    if where not in document['verdict']:
        lines.append(where)
    enough = 'enough' if document['is_enough'] else 'not enough'
    lines.append(f'{enough}: {document["verdict"]}')
    return '\n'.join(lines) + '\n'
