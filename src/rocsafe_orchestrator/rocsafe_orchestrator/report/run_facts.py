# SPDX-License-Identifier: Apache-2.0
"""Facts of a run as names and texts: survey, radiation, estimates, processes."""

import math
from collections.abc import Iterator

from markupsafe import Markup

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.wind.wind_vector import WindVector
from rocsafe_orchestrator.products.run_record import RunRecord
from rocsafe_orchestrator.products.source_estimates import SourceEstimates
from rocsafe_orchestrator.products.summary import RunSummary
from rocsafe_orchestrator.report.map_facts import map_facts
from rocsafe_orchestrator.report.sections.source_texts import dose_rate_of, half_axes_of, place_of
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_scenario.blocks.air import ReleaseBlock
from rocsafe_scenario.blocks.radiation import SourceBlock
from rocsafe_view import formats

Facts = list[tuple[str, str]]
_S_PER_H = 3600.0
# What lasts longer lasts as long as the mission.
_LONG_S = 86_400.0
_UNITS = {
    'rate_g_s': 'g/s', 'burst_g': 'g at once', 'rate_per_s': 'particles/s',
    'burst_count': 'particles at once',
}  # fmt: skip
_CODE = Markup('<code>{}</code>')


def fact_columns(record: RunRecord, summary: RunSummary) -> dict[str, Facts]:
    """Return all facts by the heading of their column."""
    return {
        'Survey': survey_facts(record.plan, summary) if record.plan else [],
        'Radiation, as simulated': field_facts(record) if record.has_radiation else [],
        'Releases, as simulated': release_facts(record),
        'Sources, as estimated': estimate_facts(record.estimates) if record.estimates else [],
        'Map': map_facts(record.path),
        'Run': run_facts(record, summary),
        'Software': list(summary.versions.items()),
    }


def survey_facts(plan: SurveyPlan, summary: RunSummary) -> Facts:
    """Return how the survey was planned."""
    camera, coverage, effort = plan.request.camera, plan.request.coverage, plan.request.effort
    fov = f'{math.degrees(camera.horizontal_fov_rad):.1f}°'
    image = f'{camera.image_width_px} × {camera.image_height_px} px, {fov} across'
    exclusions = plan.request.exclusions
    bound = f'{formats.duration(plan.lower_bound_s)} ({plan.lower_bound_method})'
    overlap = f'{formats.percent(coverage.overlap_fraction, 0)} ({coverage.spacing_rule})'
    return [
        ('Method', effort.method),
        ('Viewpoints', formats.whole(plan.viewpoint_count)),
        ('Height above ground', formats.length(coverage.height_agl_m)),
        ('Camera', image),
        ('Overlap', overlap),
        ('Spacing', f'{plan.spacing_m:.2f}{formats.GAP}m'),
        ('Makespan', formats.duration(plan.makespan_s)),
        ('Lower bound', bound),
        ('Gap', f'at most {formats.upper_percent(plan.gap_fraction)} above optimal'),
        ('Objective', effort.objective.replace('_', ' ')),
        ('Nearest two vehicles', _nearest(plan, summary)),
        *_flight_facts(plan),
        ('Largest hole', _hole(plan)),
        *([('Exclusions', str(len(exclusions)))] if exclusions else []),
        ('Plan', _CODE.format(plan.plan_id)),
    ]


def _flight_facts(plan: SurveyPlan) -> Iterator[tuple[str, str]]:
    """Yield what is special of the flights: late take-offs, battery changes."""
    late = [f'{r.vehicle.name} by {formats.clock(r.delay_s)}' for r in plan.routes if r.delay_s]
    if late:
        yield 'Take-off delayed', ', '.join(late)
    swaps = [f'{r.vehicle.name} {len(r.sorties) - 1} ×' for r in plan.routes if len(r.sorties) > 1]
    if swaps:
        yield 'Battery changes', ', '.join(swaps)


def _nearest(plan: SurveyPlan, summary: RunSummary) -> str:
    """Return the least distance of two vehicles in the air: planned, asked for and flown."""
    words = []
    if math.isfinite(plan.minimum_separation_m):
        words.append(f'{formats.length(plan.minimum_separation_m)} by plan')
    if plan.request.separation.distance_m:
        words.append(f'{formats.length(plan.request.separation.distance_m)} asked for')
    if summary.nearest is not None:
        a, b = summary.nearest.vehicles
        words.append(f'{formats.length(summary.nearest.distance_m)} flown ({a} and {b})')
    return ', '.join(words) or 'never two in the air'


def _hole(plan: SurveyPlan) -> str:
    """Return the area of the largest part of the regions that no photograph is to show."""
    return formats.area(plan.largest_hole_m2) if plan.largest_hole_m2 > 0.0 else 'none'


def field_facts(record: RunRecord) -> Facts:
    """Return the model of the radiation field and its sources, as far as they are known."""
    scenario = record.scenario
    if scenario is None:
        return []
    rows: Facts = [
        ('Model', scenario.radiation.model),
        ('Source radius', f'{scenario.radiation.source_radius_m:g}{formats.GAP}m'),
    ]
    for source in scenario.radiation.sources:
        place = formats.latitude_longitude(*source.place)
        height = f'{source.height_m:g}{formats.GAP}m above ground'
        shape = f', {source.shape_text}' if source.shape_text else ''
        rows.append((source.name, f'{_strength(source)}; {place}, {height}{shape}'))
    return rows


def release_facts(record: RunRecord) -> Facts:
    """Return the wind, and the releases of the scenario with the nearest one that was found."""
    scenario = record.scenario
    if scenario is None or not scenario.air.is_used:
        return []
    east, north = scenario.survey.airspace.wind_mps
    wind = WindVector(towards_east_mps=east, towards_north_mps=north)
    air = scenario.air.wind
    blown = f'{wind.speed_mps:.1f}{formats.GAP}m/s from {wind.from_deg:.0f}°'
    height = f'{air.height_m:g}{formats.GAP}m'
    rows: Facts = [('Wind', f'{blown} at {height}; stability {air.stability}')]
    for release in scenario.air.releases:
        amounts = ', '.join(
            f'{amount:g}{formats.GAP}{_UNITS[key]}' for key, amount in release.amounts.items()
        )
        place = formats.latitude_longitude(*release.position)
        text = f'{release.agent}, {amounts}; {place}, {release.height_m:g}{formats.GAP}m above'
        rows.append((release.name, f'{text} ground{_start(release)}{_found_off(record, release)}'))
    return rows


def _start(release: ReleaseBlock) -> str:
    """Return when it starts and whether it moves, where that says anything."""
    parts = [
        f'from {formats.clock(release.start_s)}' if release.start_s > 0.0 else '',
        f'for {formats.duration(release.duration_s)}' if release.duration_s < _LONG_S else '',
        'moves' if release.track else '',
    ]
    return ''.join(f', {part}' for part in parts if part)


def _found_off(record: RunRecord, release: ReleaseBlock) -> str:
    """Return how far from it the nearest release was found, empty where none was."""
    told = record.releases
    found = told.releases if told else ()
    if not told or not found or (told.agent == 'particles') != (release.agent == 'particles'):
        return ''
    frame = LocalFrame(GeoPosition(*release.position, 0.0))
    places = [frame.enu_of(GeoPosition(r.latitude_deg, r.longitude_deg, 0.0)) for r in found]
    off = min(math.hypot(place[0], place[1]) for place in places)
    return f'; the nearest found is {formats.length(off)} away'


def estimate_facts(found: SourceEstimates) -> Facts:
    """Return the sources that the readings tell of."""
    chances = ', '.join(
        f'{k}: {formats.probability(p)}' for k, p in enumerate(found.source_count_probability)
    )
    rows: Facts = [('Probability of 0, 1, ... sources', chances)]
    for number, source in enumerate(found.sources, 1):
        where = f'{place_of(source)}, 95{formats.GAP}% ellipse {half_axes_of(source)}'
        rows.append((f'Source {number}', f'{where}; {dose_rate_of(source)} at 1{formats.GAP}m'))
    return rows


def _strength(source: SourceBlock) -> str:
    if source.sigma_usvps is None:
        return source.strength_text
    at_one_metre = formats.spaced(formats.dose_rate(source.sigma_usvps * _S_PER_H))
    return f'{at_one_metre} at 1{formats.GAP}m'


def plan_rows(record: RunRecord) -> list[list[str]]:
    """Return a row for each plan of a mission that had more than one, the first one first."""
    if not record.further:
        return []
    return [
        [
            plan.plan_id[:8],
            formats.whole(plan.viewpoint_count),
            formats.sentence_list([r.vehicle.name for r in plan.routes if r.viewpoints]),
            formats.duration(plan.makespan_s),
            formats.length(plan.total_length_m),
        ]
        for plan in record.plans
    ]


def run_facts(record: RunRecord, summary: RunSummary) -> Facts:
    """Return how the run went."""
    restarts = ', '.join(
        f'{name} {count} ×' for name, count in summary.processes_restarted.items()
    )
    command = record.info.get('command')
    line = ' '.join(map(str, command)) if isinstance(command, list) else str(command or '')
    return [
        ('Command', _CODE.format(line) if line else ''),
        ('Readings', formats.whole(summary.reading_count)),
        ('Messages recorded', formats.whole(summary.message_count)),
        ('Real-time factor', formats.figures(summary.real_time_factor or math.nan)),
        ('Wall time', formats.duration(summary.wall_time_s)),
        ('Processes restarted', restarts or 'none'),
    ]
