# SPDX-License-Identifier: Apache-2.0
"""Sentences of the report: the kind of run, and the limits of its figures."""

from dataclasses import dataclass

from rocsafe_orchestrator.products.release_estimates import ReleaseEstimates
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.summary import HighestReading, RunSummary, VehicleFigures
from rocsafe_orchestrator.report.sections.source_texts import strongest
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


@dataclass(frozen=True, slots=True, kw_only=True)
class Verdict:
    """How a run ended in a word or two; `kind` chooses colour and sign."""

    kind: str
    sign: str
    words: str


def verdict(summary: RunSummary) -> Verdict:
    """Return how a run ended: complete only if nothing is missing and the evidence is enough."""
    if summary.outcome == 'failed':
        return Verdict(kind='failed', sign='✕', words='Failed')
    if summary.outcome == 'cancelled':
        return Verdict(kind='cancelled', sign='◼', words='Cancelled')
    if summary.outcome != 'complete':
        return Verdict(kind='unknown', sign='?', words='Not finished')
    if lacks := _lacks(summary):
        return Verdict(kind='partial', sign='!', words=f'Flown, {lacks}')
    return Verdict(kind='complete', sign='✓', words='Complete')


def _lacks(summary: RunSummary) -> str:
    """Return what a mission that was flown to its end still lacks; empty if nothing."""
    found, gas, expected = summary.estimates, summary.releases, summary.images_expected
    if expected is not None and summary.viewpoints_photographed < expected:
        return 'photographs missing'
    is_doubtful = found is not None and found.verdict and not found.is_enough
    if is_doubtful or (gas is not None and not gas.is_enough):
        return 'evidence not enough yet'
    return ''


def lead(summary: RunSummary) -> str:
    """Return the run in a few sentences, as far as it is known."""
    fliers = [vehicle for vehicle in summary.vehicles if not vehicle.is_ground_vehicle]
    text = f'{len(fliers)} vehicle{"s" if len(fliers) != 1 else ""}'
    if summary.mission_duration_s is not None:
        text += f' flew {_flown(summary)}'
    if summary.plan:
        text += f' over a region of {formats.area(summary.plan.region_area_m2)}'
    drivers = [vehicle for vehicle in summary.vehicles if vehicle.is_ground_vehicle]
    stored = summary.images_stored - sum(one.images_stored for one in drivers)
    if stored or summary.images_expected is not None or not summary.plan:
        both = ' and' if summary.mission_duration_s else ''
        text += f'{both} stored {formats.whole(stored)} photographs'
    if summary.images_expected is not None:
        seen, expected = summary.viewpoints_photographed, summary.images_expected
        part = 'all' if seen == expected else f'{formats.whole(seen)} of'
        text += f' of {part} {formats.whole(expected)} viewpoints'
    text += ''.join(f'. {_driven(one)}' for one in drivers if one.flown_duration_s is not None)
    return f'{text}.{_highest(summary)}{_at_one_metre(summary)}{_gas(summary.releases)}'


def _flown(summary: RunSummary) -> str:
    """Return how long the vehicles of the air flew."""
    if any(vehicle.is_ground_vehicle for vehicle in summary.vehicles):
        fliers = [vehicle for vehicle in summary.vehicles if not vehicle.is_ground_vehicle]
        longest_s = max((one.flown_duration_s or 0.0 for one in fliers), default=0.0)
        return f'up to {formats.duration(longest_s)}'
    return formats.duration(summary.mission_duration_s)


def _driven(driver: VehicleFigures) -> str:
    """Return how far a ground vehicle drove."""
    shots = formats.whole(driver.images_stored)
    return (
        f'{driver.name} drove {formats.length(driver.flown_length_m)} in '
        f'{formats.duration(driver.flown_duration_s)} and stored {shots} photographs'
    )


def _highest(summary: RunSummary) -> str:
    top = summary.highest_reading
    if top is None:
        return ''
    place = formats.latitude_longitude(top.latitude_deg, top.longitude_deg)
    dose_rate = formats.spaced(formats.dose_rate(top.dose_rate_usvh))
    return f' The highest dose rate was {dose_rate}, measured {height_of(top)} at {place}.'


def _at_one_metre(summary: RunSummary) -> str:
    source = strongest(summary.estimates)
    if source is None:
        return ''
    dose_rate = formats.spaced(formats.dose_rate(source.dose_rate_at_1m_usvh))
    return f' At 1{formats.GAP}m from the strongest source it is about {dose_rate}, as estimated.'


def _gas(found: ReleaseEstimates | None) -> str:
    """Return the highest reading of gas, and what is said of releases."""
    if found is None:
        return ''
    top = found.highest_reading
    place = formats.latitude_longitude(top.latitude_deg, top.longitude_deg)
    height = formats.length(top.height_agl_m)
    return (
        f' The highest reading of {found.sensor_name} was {gas_reading(found)}, measured {height} '
        f'above the ground at {place}. {found.agent.capitalize()}: {found.verdict}.'
    )


def gas_reading(found: ReleaseEstimates) -> str:
    """Return the highest reading; a saturated sensor tells only a lower bound."""
    top = found.highest_reading
    bound = 'over ' if top.is_saturated else ''
    return f'{bound}{formats.figures(top.value)}{formats.GAP}{top.unit}'


def height_of(top: HighestReading) -> str:
    """Return how high above the ground, or else the ellipsoid, a reading was measured."""
    if top.height_agl_m is not None:
        return f'{formats.length(top.height_agl_m)} above the ground'
    return f'at an altitude of {formats.length(top.altitude_m)}'


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
    if scenario is None or not scenario.real_names:
        return 'Simulated flight and simulated detectors.'
    driver, metered = scenario.driver_name, scenario.metered_names
    is_real = driver in scenario.real_names
    groups = {
        'Real flight': [vehicle.name for vehicle in scenario.linked],
        'Real drive': [driver] if driver and is_real else [],
        'Simulated flight': [vehicle.name for vehicle in scenario.simulated],
        'Simulated drive': [driver] if driver and not is_real else [],
        'Own detector': [name for name in scenario.all_names if name not in metered],
        'Simulated detector': metered,
    }
    return ' '.join(f'{what}: {", ".join(names)}.' for what, names in groups.items() if names)
