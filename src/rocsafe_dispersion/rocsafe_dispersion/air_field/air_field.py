# SPDX-License-Identifier: Apache-2.0
"""Gas, particles and wind at any place and time of a mission."""

from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_dispersion.plume.filaments import FilamentCloud, Filaments
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.wind.site_wind import SiteWind
from rocsafe_geo.wind.wind_field import WindField

# Latitude and longitude in degrees, altitude in metres.
GeoPlace = tuple[float, float, float]
L_PER_M3 = 1000.0
# Points of the air below a vehicle over which an open path sums.
COLUMN_POINTS = 40


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReleasedCloud:
    """The filaments of one release, and of what; None: particles."""

    agent: Agent | None
    cloud: FilamentCloud


class AirField:
    """What a sensor at a place meets; a pure function of time and place.

    Parameters
    ----------
    frame
        Frame of wind and clouds.
    ground_altitude_m
        Altitude of the ground, metres; it is level unless `wind` is that of a site.
    wind
        The wind.
    clouds
        What is released.
    """

    def __init__(
        self,
        frame: LocalFrame,
        ground_altitude_m: float,
        wind: WindField,
        clouds: tuple[ReleasedCloud, ...],
    ) -> None:
        self._frame, self._ground_m = frame, ground_altitude_m
        self._wind, self._clouds = wind, clouds
        self._time_s: float | None = None
        self._filaments: list[Filaments] = []

    def place_m(self, place: GeoPlace) -> FloatArray:
        """Return east, north and height above the ground, (1, 3), metres."""
        found = self._frame.to_enu(*place)
        ground = self._ground_m
        if isinstance(self._wind, SiteWind):
            ground += float(self._wind.ground_up_m(found[:, :2])[0])
        found[:, 2] = np.maximum(place[2] - ground, 0.0)
        return found

    def gases_g_m3(self, time_s: float, place: GeoPlace) -> list[tuple[Agent, float]]:
        """Return each release's chemical and its concentration, g/m^3."""
        at = self.place_m(place)
        return [
            (released.agent, float(filaments.concentrations_g_m3(at)[0]))
            for released, filaments in zip(self._clouds, self._at(time_s), strict=True)
            if released.agent is not None
        ]

    def columns_g_m2(self, time_s: float, place: GeoPlace) -> list[tuple[Agent, float]]:
        """Return each release's chemical and its sum straight down to the ground, g/m^2."""
        at = self.place_m(place)
        step_m = float(at[0, 2]) / COLUMN_POINTS
        column = np.repeat(at, COLUMN_POINTS, axis=0)
        column[:, 2] = step_m * (np.arange(COLUMN_POINTS) + 0.5)
        return [
            (released.agent, step_m * float(filaments.concentrations_g_m3(column).sum()))
            for released, filaments in zip(self._clouds, self._at(time_s), strict=True)
            if released.agent is not None
        ]

    def particles_per_l(self, time_s: float, place: GeoPlace) -> float:
        """Return the concentration of released particles, 1/l."""
        at = self.place_m(place)
        return sum(
            float(filaments.concentrations_g_m3(at)[0]) / L_PER_M3
            for released, filaments in zip(self._clouds, self._at(time_s), strict=True)
            if released.agent is None
        )

    def wind_mps(self, time_s: float, place: GeoPlace) -> FloatArray:
        """Return the velocity of the air towards east, north and up, (3,), m/s."""
        return self._wind.velocities_mps(time_s, self.place_m(place))[0]

    def _at(self, time_s: float) -> list[Filaments]:
        # All vehicles ask for the same moments: the clouds move once.
        if time_s != self._time_s:
            self._filaments = [released.cloud.at(time_s) for released in self._clouds]
            self._time_s = time_s
        return self._filaments
