# SPDX-License-Identifier: Apache-2.0
"""An assessment -> messages: sources, dose map, cordons, belief map, suggested viewpoints."""

from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from nav_msgs.msg import OccupancyGrid
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard.conversions import MAP_FRAME, grid_message
from rocsafe_interfaces.msg import HazardSource, HazardSourceArray
from rocsafe_radiation.belief.belief_search import BeliefMap
from rocsafe_radiation.localization.estimates import Localization, SourceEstimate
from rocsafe_radiation.physics.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.products.assessment import Assessment
from rocsafe_radiation.products.cordon import MEAN, Cordon
from rocsafe_radiation.products.dose_map import DoseMap
from rocsafe_radiation.products.level_colours import level_rgb
from rocsafe_radiation.readings.ground import Ground
from rocsafe_ros.conversions import point_of_position, stamp_of_ns

# Cells of the dose map: 0 is 0.1 uSv/h or less, each 10 is a factor of 4, 100 is 1e5 or more.
LOWEST_CELL_USVH, DECADES = 0.1, 6.0
# Lines lie above the ground, so that they can be seen.
LINE_HEIGHT_M = 0.1
LINE_WIDTH_M = {True: 1.0, False: 0.4}


def sources_message(
    assessment: Assessment, frame: LocalFrame | None, time_ns: int
) -> HazardSourceArray:
    """Return the sources found, with the stamp of the newest reading."""
    found, rule = assessment.found, assessment.options.rule
    kernel = assessment.options.known.kernel
    message = HazardSourceArray(
        sources=[
            _source_message(number, source, found, frame)
            for number, source in enumerate(found.sources, 1)
            if frame is not None
        ],
        source_count_probability=list(found.order_probabilities),
        background_usvh=found.background_usvh,
        background_std_usvh=found.background_std_usvh,
        method=found.method,
        model=AIR_MODEL if kernel.is_lossy else PAPER_MODEL,
        is_enough=assessment.verdict.is_enough,
        false_alarm_probability=rule.false_alarm,
        missed_probability=rule.missed,
        verdict=assessment.verdict.reason,
        misfit_standard_deviations=found.dispersion,
        doubts=list(found.doubts),
    )
    message.header.stamp = stamp_of_ns(time_ns)
    message.header.frame_id = 'earth'
    return message


def _source_message(
    number: int, source: SourceEstimate, found: Localization, frame: LocalFrame
) -> HazardSource:
    return HazardSource(
        id=number,
        kind=HazardSource.GAMMA,
        position=point_of_position(frame.position_of(source.position_enu_m)),
        position_covariance=source.covariance_m2.ravel().tolist(),
        dose_rate_at_1m_usvh=source.dose_rate_at_1m_usvh,
        dose_rate_at_1m_std_usvh=source.dose_rate_at_1m_std_usvh,
        detection_log_likelihood_ratio=source.detection_llr,
        reading_count=found.reading_count,
    )


def dose_map_message(found: DoseMap, time_ns: int) -> OccupancyGrid:
    """Return the mean of `found`, log-scaled: 0 at 0.1 uSv/h and below, 100 at 1e5 and above."""
    decades = np.log10(np.maximum(found.mean_usvh, LOWEST_CELL_USVH) / LOWEST_CELL_USVH)
    return grid_message(100.0 * decades / DECADES, found.corner_m, found.cell_m, time_ns)


def belief_message(found: BeliefMap, time_ns: int) -> OccupancyGrid:
    """Return the probability of a source in each cell, percent."""
    return grid_message(100.0 * found.probabilities, found.corner_m, found.cell_m, time_ns)


def cordon_markers(found: Sequence[Cordon], ground: Ground, time_ns: int) -> MarkerArray:
    """Return each cordon as lines on the ground: thick for the mean, thin for the upper 95 %.

    The first marker deletes those of the last message.
    """
    stamp = stamp_of_ns(time_ns)
    clear = Marker(action=Marker.DELETEALL)
    clear.header.stamp, clear.header.frame_id = stamp, MAP_FRAME
    markers = [clear]
    for cordon in found:
        for part in cordon.area.geoms:
            for ring in (part.exterior, *part.interiors):
                corners = np.array(ring.coords)[:, :2]
                corners = np.column_stack([corners, ground.ups_at(corners) + LINE_HEIGHT_M])
                markers.append(_ring_marker(cordon, corners, len(markers), stamp))
    return MarkerArray(markers=markers)


def _ring_marker(cordon: Cordon, corners: FloatArray, number: int, stamp: Time) -> Marker:
    marker = Marker(type=Marker.LINE_STRIP, action=Marker.ADD, id=number)
    marker.header.stamp, marker.header.frame_id = stamp, MAP_FRAME
    marker.ns = f'{cordon.level_usvh:g} uSv/h {cordon.confidence}'
    marker.scale.x = LINE_WIDTH_M[cordon.confidence == MEAN]
    red, green, blue = level_rgb(cordon.level_usvh)
    marker.color = ColorRGBA(r=red / 255.0, g=green / 255.0, b=blue / 255.0, a=1.0)
    marker.pose.orientation.w = 1.0
    marker.points = [Point(x=x, y=y, z=z) for x, y, z in corners.tolist()]
    return marker
