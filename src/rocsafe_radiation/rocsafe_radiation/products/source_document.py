# SPDX-License-Identifier: Apache-2.0
"""Sources found, as JSON and as GeoJSON (RFC 7946)."""

import math
from typing import Any

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_radiation.localization.estimates import Localization, SourceEstimate
from rocsafe_radiation.products.assessment import Assessment

ELLIPSE_CORNERS = 72
# Digits of degrees for a millimetre on the ground.
DEGREE_DIGITS = 8


def source_document(found: Localization, frame: LocalFrame | None) -> dict[str, Any]:
    """Return the sources found; places in degrees with `frame`, else in metres."""
    return {
        'method': found.method,
        'reading_count': found.reading_count,
        'source_count_probability': [round(p, 6) for p in found.order_probabilities],
        'background_usvh': found.background_usvh,
        'background_std_usvh': found.background_std_usvh,
        'background_is_uneven': found.is_structured,
        'is_understood': found.is_understood,
        'doubts': list(found.doubts),
        'misfit_standard_deviations': round(found.dispersion, 3),
        'sources': [_source(source, frame) for source in found.sources],
    }


def assessment_document(assessment: Assessment, frame: LocalFrame | None) -> dict[str, Any]:
    """Return the sources found, whether the evidence is enough, and the error rates."""
    rule = assessment.options.rule
    return {
        **source_document(assessment.found, frame),
        'is_enough': assessment.verdict.is_enough,
        'verdict': assessment.verdict.reason,
        'false_alarm_probability': rule.false_alarm,
        'missed_probability': rule.missed,
        'smallest_source_usvh': rule.smallest_usvh,
    }


def source_geojson(found: Localization, frame: LocalFrame) -> dict[str, Any]:
    """Return each source as a point and its 95 % ellipse as a polygon."""
    features = []
    for number, source in enumerate(found.sources, 1):
        properties = {'source': number, **_source(source, frame)}
        del properties['place']
        longitude, latitude = _lonlat(frame, source.position_enu_m)
        features.append(_feature('Point', [longitude, latitude], {**properties, 'kind': 'source'}))
        ring = [_lonlat(frame, corner) for corner in _ellipse(source)]
        features.append(
            _feature('Polygon', [[*ring, ring[0]]], {**properties, 'kind': 'ellipse_95'})
        )
    # A foreign member (RFC 7946, 6.1): without a source there is no feature to carry the doubts.
    return {
        'type': 'FeatureCollection',
        'features': features,
        'is_understood': found.is_understood,
        'doubts': list(found.doubts),
    }


def place_of(enu: FloatArray, frame: LocalFrame | None) -> dict[str, float]:
    """Return a place in degrees with `frame`, else in metres."""
    if frame is None:
        east, north, up = enu.tolist()
        return {'east_m': round(east, 3), 'north_m': round(north, 3), 'up_m': round(up, 3)}
    latitude, longitude, altitude = frame.to_geodetic(enu)[0]
    return {
        'latitude_deg': round(float(latitude), DEGREE_DIGITS),
        'longitude_deg': round(float(longitude), DEGREE_DIGITS),
        'altitude_m': round(float(altitude), 3),
    }


def _source(source: SourceEstimate, frame: LocalFrame | None) -> dict[str, Any]:
    long_m, short_m, angle = source.ellipse_95()
    return {
        'place': place_of(source.position_enu_m, frame),
        'ellipse_95_m': [round(long_m, 4), round(short_m, 4)],
        'ellipse_angle_from_east_deg': round(math.degrees(angle), 2),
        'position_covariance_m2': source.covariance_m2.tolist(),
        'dose_rate_at_1m_usvh': source.dose_rate_at_1m_usvh,
        'dose_rate_at_1m_std_usvh': source.dose_rate_at_1m_std_usvh,
        'dose_rate_at_1m_95_usvh': list(source.interval_95_usvh()),
        'detection_log_likelihood_ratio': source.detection_llr,
    }


def _ellipse(source: SourceEstimate) -> FloatArray:
    """Return the corners of the ellipse, anticlockwise, east, north, up."""
    long_m, short_m, angle = source.ellipse_95()
    turns = np.linspace(0.0, 2.0 * math.pi, ELLIPSE_CORNERS, endpoint=False)
    along, across = long_m * np.cos(turns), short_m * np.sin(turns)
    east = along * math.cos(angle) - across * math.sin(angle)
    north = along * math.sin(angle) + across * math.cos(angle)
    return source.position_enu_m + np.stack([east, north, np.zeros_like(east)], axis=1)


def _lonlat(frame: LocalFrame, enu: Any) -> list[float]:
    latitude, longitude, _ = frame.to_geodetic(enu)[0]
    return [round(float(longitude), DEGREE_DIGITS), round(float(latitude), DEGREE_DIGITS)]


def _feature(kind: str, coordinates: Any, properties: dict[str, Any]) -> dict[str, Any]:
    return {
        'type': 'Feature',
        'geometry': {'type': kind, 'coordinates': coordinates},
        'properties': properties,
    }
