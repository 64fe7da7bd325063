# SPDX-License-Identifier: Apache-2.0
"""An assessment of releases <-> messages."""

import math
from collections.abc import Sequence

import numpy as np
from builtin_interfaces.msg import Time
from geometry_msgs.msg import Point
from nav_msgs.msg import OccupancyGrid
from std_msgs.msg import ColorRGBA
from visualization_msgs.msg import Marker, MarkerArray

from rocsafe_dispersion.agents.agent_table import PARTICLES
from rocsafe_dispersion.estimation.amount import L_PER_M3, counted_per_m3
from rocsafe_dispersion.estimation.found_release import FoundRelease
from rocsafe_dispersion.mission_gas.gas_log import PER_M3, GasFlightReading, WindFlightReading
from rocsafe_dispersion.mission_gas.release_assessment import ReleaseAssessment
from rocsafe_dispersion.zones.threat_zones import ThreatZone
from rocsafe_geo.frame import LocalFrame
from rocsafe_hazard.conversions import MAP_FRAME, grid_message
from rocsafe_interfaces.msg import (
    GasReading,
    ParticleReading,
    ReleaseEstimate,
    ReleaseEstimateArray,
    WindReading,
)
from rocsafe_ros.conversions import ns_of_stamp, point_of_position, stamp_of_ns

# Cells of the plume: 0 is 0.01 ppm, of particles 1/l, or less, each 10 is a factor of 4, 100 is a
# million times as much or more.
LOWEST_PPM, LOWEST_PER_L, DECADES = 0.01, 1.0, 6.0
COUNTER = 'particle_counter'
LINE_HEIGHT_M = 0.1
# Colours of the levels 1 to 3 (red, green, blue), and widths of lines in metres.
LEVEL_RGB = ((1.0, 0.85, 0.0), (1.0, 0.5, 0.0), (0.85, 0.0, 0.0))
EXPECTED_M, OUTER_M = 1.0, 0.4


def gas_flight_reading_of(vehicle: str, message: GasReading) -> GasFlightReading:
    """Return the reading of a message."""
    return GasFlightReading(
        vehicle=vehicle,
        time_ns=ns_of_stamp(message.header.stamp),
        sensor=message.sensor,
        unit=message.unit,
        calibration_gas=message.calibration_gas,
        latitude_deg=message.position.latitude,
        longitude_deg=message.position.longitude,
        altitude_m=message.position.altitude,
        raw=message.raw,
        corrected=message.corrected,
        std=message.std,
        limit=message.limit,
        is_saturated=message.saturated,
    )


def particle_flight_reading_of(vehicle: str, message: ParticleReading) -> GasFlightReading:
    """Return the fluorescent particles of a message; NaN where it counts none at all."""
    # What the total means as a concentration tells how much air was counted.
    litres = message.total / message.particles_per_l if message.particles_per_l > 0.0 else math.nan
    values, noise = counted_per_m3(np.array([float(message.fluorescent)]), np.array([litres]))
    return GasFlightReading(
        vehicle=vehicle,
        time_ns=ns_of_stamp(message.header.stamp),
        sensor=COUNTER,
        unit=PER_M3,
        calibration_gas=PARTICLES.name,
        latitude_deg=message.position.latitude,
        longitude_deg=message.position.longitude,
        altitude_m=message.position.altitude,
        raw=float(values[0]),
        corrected=float(values[0]),
        std=float(noise[0]),
        limit=L_PER_M3 / litres,
        is_saturated=message.saturated,
    )


def wind_flight_reading_of(vehicle: str, message: WindReading) -> WindFlightReading:
    """Return the reading of a message."""
    return WindFlightReading(
        vehicle=vehicle,
        time_ns=ns_of_stamp(message.header.stamp),
        altitude_m=message.position.altitude,
        towards_east_mps=message.towards_east_mps,
        towards_north_mps=message.towards_north_mps,
    )


def releases_message(
    assessment: ReleaseAssessment, frame: LocalFrame, time_ns: int
) -> ReleaseEstimateArray:
    """Return the releases found, with the stamp of the newest reading."""
    found, flight = assessment.found, assessment.flight
    east, north = flight.wind_towards_mps
    gains = (*found.gains, *[math.nan] * len(found.releases))
    message = ReleaseEstimateArray(
        releases=[
            _release_message(number, release, gains[number - 1], frame)
            for number, release in enumerate(found.releases, 1)
        ],
        rate_unit=found.amount.rate_unit,
        agent=flight.agent.name,
        sensor=flight.sensor,
        wind_towards_east_mps=east,
        wind_towards_north_mps=north,
        wind_turned_deg=math.degrees(found.turn_rad),
        width_factor=found.spread_y,
        height_factor=found.spread_z,
        reading_count=len(flight.survey.values_g_m3),
        is_enough=assessment.verdict.is_enough,
        verdict=assessment.verdict.reason,
    )
    message.header.stamp = stamp_of_ns(time_ns)
    message.header.frame_id = 'earth'
    return message


def _release_message(
    number: int, release: FoundRelease, gain: float, frame: LocalFrame
) -> ReleaseEstimate:
    east, north = release.place_m
    towards_east, towards_north = release.velocity_mps or (math.nan, math.nan)
    return ReleaseEstimate(
        id=number,
        position=point_of_position(frame.position_of((east, north, 0.0))),
        position_covariance=release.covariance_m2.ravel().tolist(),
        region_95_m2=release.region_m2,
        rate=release.rate_g_s,
        rate_low=release.rate_low_g_s,
        rate_high=release.rate_high_g_s,
        moving_probability=release.moves,
        velocity_east_mps=towards_east,
        velocity_north_mps=towards_north,
        start_s=release.start.time_s,
        detection_gain=gain,
    )


def plume_message(assessment: ReleaseAssessment, time_ns: int) -> OccupancyGrid:
    """Return the mean, log-scaled: 0 at 0.01 ppm and below, 100 at 1e4 ppm and above.

    Particles: 1/l and 1e6/l. Without a plume the map has no cells.
    """
    found, counted = assessment.plume, assessment.found.amount
    if found is None:
        return grid_message(np.zeros((0, 0)), (0.0, 0.0), 1.0, time_ns)
    lowest = LOWEST_PER_L if counted.is_particles else LOWEST_PPM
    shown = np.maximum(found.mean_g_m3 * counted.shown(assessment.flight.agent) / lowest, 1.0)
    percent = 100.0 * np.log10(shown) / DECADES
    grid = found.grid
    return grid_message(percent, (grid.west_m, grid.south_m), grid.cell_m, time_ns)


def zone_markers(zones: Sequence[ThreatZone], time_ns: int) -> MarkerArray:
    """Return each zone as lines on the ground: thick as expected, thin the outer bound of 95 %.

    The first marker deletes those of the last message.
    """
    stamp = stamp_of_ns(time_ns)
    clear = Marker(action=Marker.DELETEALL)
    clear.header.stamp, clear.header.frame_id = stamp, MAP_FRAME
    markers = [clear]
    for zone in zones:
        for kind, area in (('expected', zone.expected), ('outer', zone.outer)):
            for part in area.geoms:
                for ring in (part.exterior, *part.interiors):
                    corners = list(ring.coords)
                    name = f'{zone.level.label} {kind}'
                    markers.append(_line(name, zone, kind, corners, len(markers), stamp))
    return MarkerArray(markers=markers)


def _line(
    name: str,
    zone: ThreatZone,
    kind: str,
    corners: list[tuple[float, ...]],
    number: int,
    stamp: Time,
) -> Marker:
    marker = Marker(type=Marker.LINE_STRIP, action=Marker.ADD, id=number, ns=name)
    marker.header.stamp, marker.header.frame_id = stamp, MAP_FRAME
    marker.scale.x = EXPECTED_M if kind == 'expected' else OUTER_M
    red, green, blue = LEVEL_RGB[int(zone.level.name[-1]) - 1]
    marker.color = ColorRGBA(r=red, g=green, b=blue, a=1.0)
    marker.pose.orientation.w = 1.0
    marker.points = [Point(x=x, y=y, z=LINE_HEIGHT_M) for x, y, *_ in corners]
    return marker
