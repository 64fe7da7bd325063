# SPDX-License-Identifier: Apache-2.0
"""A drive as JSON and as GeoJSON (RFC 7946)."""

import math
from typing import Any

from rocsafe_ground.dose.toxic_load import GasExposure
from rocsafe_ground.drive.drive_plan import DrivePlan, DriveStop

Document = dict[str, Any]
DEGREE_DIGITS = 8


def drive_document(plan: DrivePlan) -> Document:
    """Return all figures of a drive."""
    request, forecast = plan.request, plan.forecast
    return {
        'dose_budget_usv': request.dose_budget_usv,
        **_limited(request.load_budget),
        'turn_back_usvh': request.turn_back_usvh,
        'endurance_s': request.vehicle.endurance_s,
        'confidence': request.confidence,
        'draws': request.draws,
        'seed': request.seed,
        'time_s': round(plan.time_s, 3),
        'length_m': round(plan.length_m, 3),
        'dose_usv': {
            'mean': round(forecast.mean_usv, 6),
            'of_dwells': round(plan.standing_usv, 6),
            'low_95': round(forecast.low_usv, 6),
            'high_95': round(forecast.high_usv, 6),
            'upper': round(forecast.upper_usv, 6),
            'probability_within_budget': forecast.probability,
        },
        'proof': {
            'grid_time_s': round(plan.grid_time_s, 3),
            'lower_bound_s': round(plan.bound_s, 3),
            'gap_fraction': round(plan.gap_fraction, 6),
            'seconds_per_usv': round(plan.price_s_per_usv, 6),
        },
        'fastest': {'time_s': round(plan.fastest_s, 3), 'dose_usv': round(plan.fastest_usv, 6)},
        'trade_off': [
            {'dose_budget_usv': round(dose, 6), 'time_s': round(time, 3)}
            for dose, time in plan.curve
        ],
        'oldest_ground_s': round(plan.oldest_s, 3) if math.isfinite(plan.oldest_s) else None,
        'left_out': [{'evidence': one.evidence, 'why': one.why} for one in plan.left_out],
        'stops': [_stop(stop) for stop in plan.stops],
        **({} if plan.gas is None else {'gas': _gas(plan.gas)}),
    }


def _limited(load: float) -> Document:
    return {'load_budget': load} if math.isfinite(load) else {}


def _gas(gas: GasExposure) -> Document:
    known = math.isfinite(gas.load_share)
    return {
        'agent': gas.agent,
        'highest_ppm': round(gas.highest_ppm, 6),
        'highest_upper_95_ppm': round(gas.highest_upper_ppm, 6),
        'toxic_load_of': gas.level,
        'toxic_load_share': round(gas.load_share, 9) if known else None,
        'toxic_load_share_upper_95': round(gas.load_upper_share, 9) if known else None,
        'outside_the_map_s': round(gas.unknown_s, 3),
    }


def _stop(stop: DriveStop) -> Document:
    return {
        'latitude_deg': round(stop.place.latitude_deg, DEGREE_DIGITS),
        'longitude_deg': round(stop.place.longitude_deg, DEGREE_DIGITS),
        'speed_mps': round(stop.speed_mps, 3),
        'dwell_s': stop.dwell_s,
        'evidence': stop.evidence,
        'duration_s': round(stop.duration_s, 3),
        'dose_usv': round(stop.dose_usv, 6),
    }


def drive_geojson(plan: DrivePlan) -> Document:
    """Return the way as a line, the evidence points and the stands for them as points."""
    line = [_lonlat(stop) for stop in plan.stops]
    properties = {
        'kind': 'route',
        'time_s': round(plan.time_s, 3),
        'dose_usv': round(plan.forecast.mean_usv, 6),
        'dose_upper_usv': round(plan.forecast.upper_usv, 6),
        'stroke': '#1f6feb',
    }
    features = [_feature('LineString', line, properties)]
    for stop in plan.stops:
        if stop.evidence:
            stand = {'kind': 'stand', 'evidence': stop.evidence, 'dwell_s': stop.dwell_s}
            features.append(_feature('Point', _lonlat(stop), stand))
    why = {one.evidence: one.why for one in plan.left_out}
    for point in plan.request.evidence:
        place = [point.position.longitude_deg, point.position.latitude_deg]
        about = {
            'kind': 'evidence',
            'id': point.id,
            'evidence_kind': point.kind,
            'priority': point.priority,
            'found_in': point.found_in,
            'left_out': why.get(point.id, ''),
        }
        features.append(_feature('Point', place, about))
    return {'type': 'FeatureCollection', 'features': features}


def _lonlat(stop: DriveStop) -> list[float]:
    place = stop.place
    return [round(place.longitude_deg, DEGREE_DIGITS), round(place.latitude_deg, DEGREE_DIGITS)]


def _feature(kind: str, coordinates: Any, properties: Document) -> Document:
    return {
        'type': 'Feature',
        'geometry': {'type': kind, 'coordinates': coordinates},
        'properties': properties,
    }


def duration_text(seconds: float) -> str:
    """Return a duration as minutes and seconds."""
    if not math.isfinite(seconds):
        return '-'
    minutes, rest = divmod(round(seconds), 60)
    return f'{minutes}:{rest:02d} min'
