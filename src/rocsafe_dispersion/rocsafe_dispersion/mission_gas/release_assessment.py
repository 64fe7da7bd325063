# SPDX-License-Identifier: Apache-2.0
"""What the readings of a flight say: releases, verdict, map, where to measure next."""

import math
from dataclasses import dataclass, field, replace

import numpy as np
import shapely

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_dispersion.estimation.fluctuating_plume import LEAST_SPEED_MPS
from rocsafe_dispersion.estimation.found_release import ReleaseSamples
from rocsafe_dispersion.estimation.locate import LocatedReleases, locate_releases
from rocsafe_dispersion.estimation.measuring_places import MeanAir, measuring_places
from rocsafe_dispersion.estimation.release_options import LocateOptions, SearchArea
from rocsafe_dispersion.mission_gas.gas_log import FlightSurvey, NoSurveyError
from rocsafe_dispersion.mission_gas.release_map import PlumeMap, plume_map
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.losses import NO_LOSSES, Losses
from rocsafe_dispersion.plume.spread import similarity_travel
from rocsafe_dispersion.zones.threat_zones import ThreatZone
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.stability import StabilityClass, layer_of_class
from rocsafe_hazard.next_places import MeasuringPlace, Verdict, are_within

LEAST_BLOCKS = 8
# Plume and zones are made anew in a wind that is away from theirs by more than this share of it.
CHANGED_WIND = 0.1
# Places tried along the longer side of the area: for releases, and to measure at.
CELLS_ACROSS, CANDIDATES_ACROSS = 25, 30


@dataclass(frozen=True, slots=True, kw_only=True)
class AssessmentOptions:
    """How readings are assessed.

    Attributes
    ----------
    stability
        Pasquill class of the air.
    roughness_m
        Roughness length of the ground, metres.
    release_height_m
        Height of releases above the ground, metres.
    losses
        What takes what is released out of the air.
    margin_m
        How far outside of the readings releases may be, metres.
    locate
        How releases are found.
    rule
        When it is enough.
    """

    stability: StabilityClass = 'D'
    roughness_m: float = 0.03
    release_height_m: float = 1.0
    losses: Losses = NO_LOSSES
    margin_m: float = 20.0
    locate: LocateOptions = field(default_factory=LocateOptions)
    rule: ReleaseRule = field(default_factory=ReleaseRule)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class ReleaseAssessment:
    """All that readings say.

    Attributes
    ----------
    flight
        The readings.
    area
        Where releases were looked for, with the regions of those that were found beyond.
    air
        The mean air.
    layer, stability
        The same, as a surface layer, and its Pasquill class.
    found
        What was found.
    rule, verdict
        When it is enough, and whether it is.
    plume
        Map of the plume; None without a release.
    """

    flight: FlightSurvey
    area: SearchArea
    air: MeanAir
    layer: SurfaceLayer
    stability: StabilityClass
    found: LocatedReleases
    rule: ReleaseRule
    verdict: Verdict
    plume: PlumeMap | None

    def is_of_wind(self, towards_mps: tuple[float, float]) -> bool:
        """Return whether the plume is about that of a wind, or there is none to be told."""
        speed = math.hypot(*towards_mps)
        changed = math.dist(towards_mps, self.air.towards_mps) > CHANGED_WIND * speed
        return self.plume is None or speed < LEAST_SPEED_MPS or not changed

    @property
    def zones(self) -> tuple[ThreatZone, ...]:
        """Threat zones, none without a release."""
        return () if self.plume is None else self.plume.zones


def assess(flight: FlightSurvey, options: AssessmentOptions) -> ReleaseAssessment:
    """Return what the readings of a flight say.

    Raises
    ------
    NoSurveyError
        If there are too few readings, or the wind is too weak to tell where gas comes from.
    """
    if len(flight.survey.values_g_m3) < LEAST_BLOCKS:
        raise NoSurveyError('too few readings of gas')
    speed = float(np.median(flight.survey.speeds_mps))
    if speed < LEAST_SPEED_MPS:
        raise NoSurveyError(f'the wind is {speed:.2g} m/s: below {LEAST_SPEED_MPS:g} m/s')
    layer = layer_of_class(options.stability, speed, flight.anemometer_m, options.roughness_m)
    area = search_area(flight.survey.places_m, options.margin_m, options.release_height_m)
    found = locate_releases(
        flight.survey,
        area,
        layer,
        anemometer_m=flight.anemometer_m,
        losses=options.losses,
        options=options.locate,
    )
    area = _with_releases(area, found)
    air = MeanAir(
        towards_mps=flight.wind_towards_mps,
        travel=similarity_travel(layer, options.release_height_m, losses=options.losses),
        reference_mps=float(layer.speed_mps(flight.anemometer_m)),
        release_height_m=options.release_height_m,
    )
    return ReleaseAssessment(
        flight=flight,
        area=area,
        air=air,
        layer=layer,
        stability=options.stability,
        found=found,
        rule=options.rule,
        verdict=options.rule.verdict(found),
        plume=_plume(found, area, air, flight.agent),
    )


def in_wind(assessment: ReleaseAssessment, towards_mps: tuple[float, float]) -> ReleaseAssessment:
    """Return an assessment with plume and zones in another wind, its releases as they are."""
    air = replace(assessment.air, towards_mps=towards_mps)
    plume = _plume(assessment.found, assessment.area, air, assessment.flight.agent)
    flight = replace(assessment.flight, wind_towards_mps=towards_mps)
    return replace(assessment, flight=flight, air=air, plume=plume)


def _plume(
    found: LocatedReleases, area: SearchArea, air: MeanAir, known: Agent
) -> PlumeMap | None:
    groups = [release.samples for release in found.releases]
    return plume_map(groups, area, air, known) if groups else None


def search_area(places_m: FloatArray, margin_m: float, release_height_m: float) -> SearchArea:
    """Return the area around readings at places (n, k, 3)."""
    flat = places_m[:, :, :2].reshape(-1, 2)
    low, high = flat.min(axis=0) - margin_m, flat.max(axis=0) + margin_m
    return SearchArea(
        west_m=float(low[0]),
        south_m=float(low[1]),
        east_m=float(high[0]),
        north_m=float(high[1]),
        cell_m=max(float((high - low).max()) / CELLS_ACROSS, 1.0),
        height_m=release_height_m,
    )


def _with_releases(area: SearchArea, found: LocatedReleases) -> SearchArea:
    """Return the area, larger where regions of releases go beyond it."""
    half = area.cell_m / 2.0
    cells = np.concatenate([np.zeros((0, 2)), *(one.region_m for one in found.releases)])
    lows, highs = cells - half, cells + half
    return replace(
        area,
        west_m=float(lows[:, 0].min(initial=area.west_m)),
        south_m=float(lows[:, 1].min(initial=area.south_m)),
        east_m=float(highs[:, 0].max(initial=area.east_m)),
        north_m=float(highs[:, 1].max(initial=area.north_m)),
    )


def suggested_places(
    assessment: ReleaseAssessment, count: int, within: shapely.Polygon | None = None
) -> list[MeasuringPlace]:
    """Return the places whose readings tell most, at the height flown, within an area.

    First they place the releases that were found, then they look for another one.
    """
    found = assessment.found
    placed: list[ReleaseSamples] = []
    groups = [one.samples for one in found.releases]
    if not groups or assessment.rule.is_placed(found):
        placed, groups = groups, [found.hidden.samples]
    candidates = _candidates(assessment.area, assessment.flight.flight_height_m, within)
    noise = float(np.median(assessment.flight.survey.std_g_m3))
    return measuring_places(groups, candidates, assessment.air, noise, count, placed)


def _candidates(area: SearchArea, height_m: float, within: shapely.Polygon | None) -> FloatArray:
    """Return places of a grid at a height, (n, 3); all of them if none is within the area."""
    longer = max(area.east_m - area.west_m, area.north_m - area.south_m)
    pitch = longer / CANDIDATES_ACROSS
    east, north = np.meshgrid(
        np.arange(area.west_m, area.east_m, pitch), np.arange(area.south_m, area.north_m, pitch)
    )
    # Whole metres: vehicles fly no finer.
    height = math.ceil(height_m)
    places = np.column_stack([east.ravel(), north.ravel(), np.full(east.size, float(height))])
    inside = are_within(places, within)
    return places[inside] if inside.any() else places
