# SPDX-License-Identifier: Apache-2.0
"""The simulated air, made from the parameters and the settings file of its node."""

import math
from pathlib import Path

from rocsafe_dispersion.agents.agent_table import released_agent
from rocsafe_dispersion.air_field.air_field import AirField, ReleasedCloud
from rocsafe_dispersion.air_field.air_file import AirFile, Place, ReleaseSettings
from rocsafe_dispersion.air_field.air_options import AirOptions
from rocsafe_dispersion.plume.filaments import FilamentCloud
from rocsafe_dispersion.plume.losses import Losses
from rocsafe_dispersion.plume.release import Release
from rocsafe_dispersion.plume.rise import buoyancy_m4_s3
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.storage.value_file import read_values
from rocsafe_geo.wind.mission_wind import LEAST_WIND_MPS, mission_wind
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.wind_field import WindField


def read_air(options: AirOptions) -> AirFile:
    """Return the settings that a node's parameters name.

    Raises
    ------
    ValueError
        In a line for each mistake.
    """
    return read_values(Path(options.air_file), AirFile) if options.air_file else AirFile()


def air_field(settings: AirFile, seed: int) -> AirField:
    """Return the air of settings.

    Raises
    ------
    ValueError
        If there are releases and too little wind, or a value is out of range.
    """
    latitude, longitude = settings.origin or _first_place(settings)
    frame = LocalFrame(GeoPosition(latitude, longitude, settings.ground_altitude_m))
    wind, layer = mission_wind(settings.wind, seed), settings.wind.layer()
    if layer is None:
        if settings.releases:
            speed = math.hypot(settings.wind.towards_east_mps, settings.wind.towards_north_mps)
            raise ValueError(
                f'the wind is {speed:g} m/s: must be at least {LEAST_WIND_MPS:g} m/s where '
                'something is released'
            )
        return AirField(frame, settings.ground_altitude_m, wind, ())
    clouds = tuple(
        _cloud(release, frame, layer, wind, seed + number)
        for number, release in enumerate(settings.releases)
    )
    return AirField(frame, settings.ground_altitude_m, wind, clouds)


def _first_place(settings: AirFile) -> Place:
    return settings.releases[0].position if settings.releases else (0.0, 0.0)


def _cloud(
    settings: ReleaseSettings, frame: LocalFrame, layer: SurfaceLayer, wind: WindField, seed: int
) -> ReleasedCloud:
    release = _release(settings, frame)
    agent = None if settings.is_particles else released_agent(settings.agent)
    buoyancy = 0.0
    if agent is not None and settings.temperature_c is not None:
        buoyancy = buoyancy_m4_s3(agent, settings.rate_g_s, settings.temperature_c)
    travel = similarity_travel(
        layer,
        settings.height_m,
        start_sigma_m=release.sigma_m,
        buoyancy_m4_s3=buoyancy,
        losses=Losses(
            surface_resistance_s_m=settings.surface_resistance_s_m,
            settling_mps=settings.settling_mps,
            decay_per_s=settings.decay_per_s,
        ),
    )
    return ReleasedCloud(agent=agent, cloud=FilamentCloud(release, travel, wind, seed))


def _release(settings: ReleaseSettings, frame: LocalFrame) -> Release:
    """Return a release in the frame; particles count as if they were grams."""
    altitude = frame.origin.altitude_m

    def place(position: tuple[float, float]) -> tuple[float, float]:
        east, north, _ = frame.to_enu(*position, altitude)[0].tolist()
        return east, north

    return Release(
        place_m=place(settings.position),
        height_m=settings.height_m,
        rate_g_s=settings.rate_g_s or settings.rate_per_s,
        burst_g=settings.burst_g or settings.burst_count,
        start_s=settings.start_s,
        duration_s=settings.duration_s,
        radius_m=settings.radius_m,
        track=tuple((stop.time_s, *place(stop.position)) for stop in settings.track),
    )
