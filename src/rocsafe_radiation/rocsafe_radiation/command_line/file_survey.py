# SPDX-License-Identifier: Apache-2.0
"""The survey of a file of readings over the ground that the options tell."""

import argparse
import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.ground_heights import ShiftedHeights, read_heights, shift_to_m
from rocsafe_radiation.readings.detector_agreement import unlike_detectors
from rocsafe_radiation.readings.ground import Ground, GroundError, ground_over
from rocsafe_radiation.readings.readings_file import (
    AGAIN,
    DEAD,
    FAR,
    UNIT,
    ReadingsFile,
    ReadingsFileError,
)
from rocsafe_radiation.readings.row_checks import dead_caveats, repeat_caveats
from rocsafe_radiation.readings.spectral_window import background_shape
from rocsafe_radiation.readings.survey import RadiationSurvey, survey_of

# A file whose readings rise less above the lowest one does not begin on the ground.
LEAST_CLIMB_M = 5.0
# Nor does one that rises by less than so many times the median deviation of its altitudes: the
# lowest of 10 000 readings with Gaussian errors lies 6 of them below the median.
LEAST_CLIMB_SPREADS = 9.0
# Nor does one whose climb has no reading over so many metres, the most that surveys fly above the
# ground (EU open category): the lowest altitude is wrong.
LARGEST_GAP_M = 120.0
# Where more rows differ from the others, the others may be the wrong ones.
LARGEST_SHARE_LEFT_OUT = 1.0 / 3.0
# A third of the dose rate of cosmic rays at sea level (UNSCEAR 2000, annex B: 0.031 uSv/h), to
# which detectors respond in part.
LEAST_NATURAL_USVH = 0.01


def file_survey(readings: ReadingsFile, options: argparse.Namespace) -> RadiationSurvey:
    """Return the survey of a file, over the ground that the options tell.

    Raises
    ------
    RadiationError
        In one line, if the ground, or the counts for a dose, are not known.
    """
    if not options.sensitivity > 0.0 and any(
        math.isnan(one.dose_rate_usvh) for one in readings.observations
    ):
        raise ReadingsFileError(
            f'{options.file}: has counts without dose rates: --sensitivity must tell the counts a '
            'second for 1 uSv/h'
        )
    survey = survey_of(readings.observations, options.sensitivity)
    if not survey.size:
        return survey
    is_guessed = readings.is_ground_guessed and not options.terrain
    if is_guessed:
        _require_climb(survey)
    if options.terrain:
        survey = replace(survey, ground=_ground(readings, survey, options))
    _require_above_ground(survey)
    caveats = [*_caveats(readings, survey, is_guessed), *_unlike(readings, survey, options)]
    survey = replace(survey, caveats=tuple(caveats))
    reference = np.array(readings.reference_counts, np.float64)
    if not reference.sum() > 0.0:
        return survey
    shape = background_shape(survey.positions_enu_m, reference)
    return replace(survey, background_shape=shape)


def _caveats(
    readings: ReadingsFile, survey: RadiationSurvey, is_ground_guessed: bool
) -> Iterator[str]:
    """Yield why the readings prove nothing."""
    if is_ground_guessed:
        yield 'the ground is not given: taken to be as low as the lowest reading'
    yield from dead_caveats(len(readings.dropped.get(DEAD, ())))
    yield from repeat_caveats(len(readings.dropped.get(AGAIN, ())))
    for reason in (FAR, UNIT):
        left_out = len(readings.dropped.get(reason, ()))
        total = left_out + survey.size
        if left_out > LARGEST_SHARE_LEFT_OUT * total:
            yield f'{left_out} of {total} rows are left out, or the others are wrong: {reason}'
    level_usvh = float(survey.net_counts.sum() / survey.exposures.sum())
    if level_usvh < LEAST_NATURAL_USVH and not (readings.models or readings.reference_counts):
        yield (
            f'the mean dose rate, {level_usvh:.2g} uSv/h, is below that of nature: is the unit '
            'another?'
        )


def _unlike(
    readings: ReadingsFile, survey: RadiationSurvey, options: argparse.Namespace
) -> Iterator[str]:
    """Yield which detectors differ over the same ground.

    Raises
    ------
    ReadingsFileError
        In one line that names them, if one sensitivity is given for all.
    """
    vehicles = [one.vehicle for one in readings.observations]
    places = np.column_stack([survey.positions_enu_m[:, :2], survey.heights_m])
    found = unlike_detectors(vehicles, places, survey.net_counts, survey.exposures)
    if found is None:
        return
    first, second, factor = found
    what = f'at the same places {second!r} reads {factor:.2g} times what {first!r} reads'
    if options.sensitivity > 0.0:
        raise ReadingsFileError(
            f'{options.file}: --sensitivity is that of one detector: {what}; give dose rates, or '
            'a file for each'
        )
    yield f'the detectors differ: {what}'


def _ground(
    readings: ReadingsFile, survey: RadiationSurvey, options: argparse.Namespace
) -> Ground:
    """Return the ground of ``--terrain``.

    Raises
    ------
    GroundError
        In one line, if there is none.
    """
    if readings.frame is None:
        raise GroundError('--terrain needs places in degrees: the file has east_m and north_m')
    try:
        heights = read_heights(options.terrain)
        known = [GeoPosition(*place) for place in options.terrain_at]
        shifted = ShiftedHeights(heights=heights, shift_m=shift_to_m(heights, known))
    except ValueError as error:
        raise GroundError(str(error)) from error
    return ground_over(shifted, readings.frame, survey.positions_enu_m[:, :2])


def _require_climb(survey: RadiationSurvey) -> None:
    climb_m = float(np.median(survey.heights_m))
    spread_m = float(np.median(np.abs(survey.heights_m - climb_m)))
    least_m = max(LEAST_CLIMB_M, LEAST_CLIMB_SPREADS * spread_m)
    ups_m = np.sort(survey.heights_m)
    if np.diff(ups_m[ups_m <= climb_m]).max(initial=0.0) > LARGEST_GAP_M:
        raise GroundError(
            f'the ground is not known: the lowest reading is {climb_m:.1f} m below the median, '
            'with a gap in between, which is no take-off; give --ground or --terrain'
        )
    if climb_m < least_m:
        raise GroundError(
            f'the ground is not known: the lowest reading is only {climb_m:.1f} m below the '
            f'median, {least_m:.1f} m show a take-off; give --ground or --terrain'
        )


def _require_above_ground(survey: RadiationSurvey) -> None:
    height_m = float(np.median(survey.heights_m))
    if height_m <= 0.0:
        raise GroundError(
            f'the readings are {-height_m:.1f} m below the ground: must be above; give --ground '
            'in the datum of the file, or with --terrain a place of known altitude by --terrain-at'
        )
