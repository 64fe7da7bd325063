# SPDX-License-Identifier: Apache-2.0
"""Releases of gas or particles estimated from the readings of a run: ``release.json`` and more."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from rocsafe_geo.wind.wind_vector import WindVector
from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products.estimator_process import run_estimator


@dataclass(frozen=True, slots=True, kw_only=True)
class Release:
    """A release as estimated: place, area of its region of 95 %, rate with its 95 % interval."""

    latitude_deg: float
    longitude_deg: float
    region_95_m2: float
    rate: float
    rate_unit: str
    rate_95: tuple[float, float]


@dataclass(frozen=True, slots=True, kw_only=True)
class HighestGas:
    """The highest reading of the sensor used, in ppm of what it is made for, or particles/l."""

    value: float
    unit: str
    vehicle: str
    time_ns: int
    latitude_deg: float
    longitude_deg: float
    height_agl_m: float
    is_saturated: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class Zone:
    """Ground above a response level: as expected, and the outer bound of 95 %."""

    level: str
    ppm: float
    expected_m2: float
    outer_95_m2: float
    is_cut_by_the_map: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class ReleaseEstimates:
    """All estimated releases and the verdict.

    Attributes
    ----------
    wind_towards_mps
        Mean wind that was measured, towards east and north, m/s.
    figure
        Readings and zones over time, as SVG.
    """

    releases: tuple[Release, ...]
    zones: tuple[Zone, ...]
    agent: str
    sensor: str
    reading_count: int
    is_enough: bool
    verdict: str
    highest_reading: HighestGas
    wind_towards_mps: tuple[float, float]
    figure: str

    @property
    def sensor_name(self) -> str:
        """Name of the sensor in words."""
        return sensor_name(self.sensor)

    @property
    def wind(self) -> WindVector:
        """The mean wind that was measured."""
        east, north = self.wind_towards_mps
        return WindVector(towards_east_mps=east, towards_north_mps=north)


def sensor_name(kind: str) -> str:
    """Return the name of a kind of detector in words."""
    return kind.replace('_', ' ').replace('pid 10 6 ev', 'PID 10.6 eV')


def estimate_releases(parameters: Path, folder: Path) -> ReleaseEstimates:
    """Estimate releases from what the estimator with the file `parameters` kept.

    Their files are written to `folder`.

    Raises
    ------
    OrchestratorError
        If there are no estimates, with the reason.
    """
    run_estimator('rocsafe_dispersion', 'locate-release', [str(parameters), f'--out={folder}'])
    try:
        content = json.loads((folder / 'release.json').read_text(encoding='utf-8'))
        return _estimates(content, (folder / 'gas.svg').read_text(encoding='utf-8'))
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise OrchestratorError(f'release.json cannot be read: {error}') from error


def _estimates(content: Mapping[str, Any], figure: str) -> ReleaseEstimates:
    east, north = content['wind_towards_mps']
    return ReleaseEstimates(
        releases=tuple(map(_release, content['releases'])),
        zones=tuple(Zone(**zone) for zone in content['threat_zones']),
        agent=content['agent'],
        sensor=content['sensor'],
        reading_count=content['reading_count'],
        is_enough=content['is_enough'],
        verdict=content['verdict'],
        highest_reading=HighestGas(**content['highest_reading']),
        wind_towards_mps=(east, north),
        figure=figure,
    )


def _release(content: Mapping[str, Any]) -> Release:
    low, high = content['rate_95']
    return Release(
        latitude_deg=content['latitude_deg'],
        longitude_deg=content['longitude_deg'],
        region_95_m2=content['region_95_m2'],
        rate=content['rate'],
        rate_unit=content['rate_unit'],
        rate_95=(low, high),
    )
