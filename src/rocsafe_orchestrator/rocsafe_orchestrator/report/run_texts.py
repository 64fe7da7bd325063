# SPDX-License-Identifier: Apache-2.0
"""Sentences of the report: what a run was, and what its figures do not say."""

from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.summary import RunSummary
from rocsafe_scenario.scenario import Scenario
from rocsafe_view import formats
from rocsafe_view.map_view import MapView

LIMITS = (
    'Not for dosimetry, and no basis for a decision on anybody’s exposure.',
    (
        'Dose rates follow the field model of the scenario alone: no background, no shielding and '
        'no counting noise unless the model has them. They were measured in flight, not at the '
        'ground.'
    ),
    (
        'True sources are marked as the scenario has them. Estimated ones follow from the '
        'readings and the law of the dose rate alone.'
    ),
    (
        'Coverage counts ground inside at least one planned footprint, on flat ground and with a '
        'level camera.'
    ),
    (
        'The lower bound holds for these viewpoints, vehicles and the planner’s model of time; it '
        'says nothing about other viewpoints.'
    ),
    'Positions are WGS84, altitudes above the ellipsoid, not above the sea.',
)


def lead(summary: RunSummary) -> str:
    """Return the run in one or two sentences, as far as it is known."""
    count = len(summary.vehicles)
    text = f'{count} vehicle{"s" if count != 1 else ""}'
    if summary.mission_duration_s is not None:
        text += f' flew {formats.duration(summary.mission_duration_s)}'
    if summary.plan:
        text += f' over a region of {formats.area(summary.plan.region_area_m2)}'
    stored = formats.whole(summary.images_stored)
    if summary.images_expected is not None:
        stored += f' of {formats.whole(summary.images_expected)}'
    text += f'{" and" if summary.mission_duration_s else ""} stored {stored} photographs.'
    top = summary.highest_reading
    if top is not None:
        place = formats.latitude_longitude(top.latitude_deg, top.longitude_deg)
        dose_rate = formats.spaced(formats.dose_rate(top.dose_rate_usvh))
        text += f' The highest dose rate in flight was {dose_rate}, at {place}.'
    return text


def limits(record: RunRecord, view: MapView | None) -> list[str]:
    """Return what the figures do not say."""
    notes = [what_is_simulated(record.scenario), *LIMITS]
    if view is not None and view.readings_per_point > 1:
        notes.append(
            f'Map and charts show the highest of every {view.readings_per_point} readings; '
            'readings.csv has them all.'
        )
    if view is not None and record.log and any(t.is_truth for t in record.log.tracks.values()):
        notes.append('Flown tracks are the true positions of the simulation, readings lie where '
                     'the vehicle believed to be.')  # fmt: skip
    return notes


def what_is_simulated(scenario: Scenario | None) -> str:
    """Return which flights and readings of the run are not real."""
    if scenario is None or not scenario.linked:
        return 'Simulated flight and simulated detectors.'
    metered = scenario.with_simulated_detector
    groups = {
        'Real flight': scenario.linked,
        'Simulated flight': scenario.simulated,
        'Own detector': [vehicle for vehicle in scenario.vehicles if vehicle not in metered],
        'Simulated detector': metered,
    }
    return ' '.join(
        f'{what}: {", ".join(vehicle.name for vehicle in vehicles)}.'
        for what, vehicles in groups.items()
        if vehicles
    )
