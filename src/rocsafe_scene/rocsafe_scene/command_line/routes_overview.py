# SPDX-License-Identifier: Apache-2.0
"""Planned and flown routes of a finished run, drawn into an image of its scene."""

import csv
import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import yaml
from numpy.typing import NDArray

from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.regions.area import SurveyArea
from rocsafe_scene.errors import SceneError
from rocsafe_scene.live.overlay import COLOURS, WHITE, Overlay
from rocsafe_scene.mesh.mesh import Floats


@dataclass(frozen=True, slots=True, eq=False)
class RunRoutes:
    """Planned and flown routes by vehicle, metres about the mission origin.

    Attributes
    ----------
    origin
        Mission origin.
    planned : (n, 3)
        Places of the photographs of each vehicle, in order.
    flown : (n, 3)
        Places of the readings of each vehicle, in order.
    """

    origin: GeoPosition
    planned: Mapping[str, Floats]
    flown: Mapping[str, Floats]

    @property
    def survey(self) -> Floats:
        """Places of all photographs planned, without the homes, (n, 3)."""
        return np.concatenate([places[1:-1] for places in self.planned.values()])

    @property
    def survey_middle(self) -> Floats:
        """Centre of all photographed places, (3,)."""
        return np.asarray(0.5 * (self.survey.min(axis=0) + self.survey.max(axis=0)))

    @property
    def reach_m(self) -> float:
        """Half the extent of all photographed places, metres."""
        return 0.5 * float(np.linalg.norm(np.ptp(self.survey, axis=0)))


def read_run(run: Path) -> RunRoutes:
    """Return the routes of a run directory.

    Raises
    ------
    SceneError
        One line, if it is no run directory, or has no planned route.
    """
    try:
        scenario = yaml.safe_load((run / 'scenario.yaml').read_text(encoding='utf-8'))
        plan = json.loads((run / 'plan.json').read_text(encoding='utf-8'))
        origin = _origin(scenario)
        frame = LocalFrame(origin)
        planned = {route['vehicle']: _places(frame, route) for route in plan['routes']}
    except OSError as error:
        raise SceneError(f'--overview = {run}: {error.filename}: {error.strerror}') from error
    except (KeyError, TypeError, ValueError, yaml.YAMLError) as error:
        raise SceneError(f'--overview = {run}: is no run directory: {error!r}') from error
    if not planned:
        raise SceneError(f'--overview = {run}: no route was planned')
    return RunRoutes(origin, planned, _flown(run / 'readings.csv'))


def _origin(scenario: Mapping[str, Any]) -> GeoPosition:
    """Return the mission origin: given by the scenario, else the centroid of the region."""
    given = scenario.get('origin', {})
    altitude = float(given.get('ground_altitude_m', 0.0))
    if given.get('latitude_deg') is not None and given.get('longitude_deg') is not None:
        return GeoPosition(float(given['latitude_deg']), float(given['longitude_deg']), altitude)
    ring = tuple(GeoPosition(*place) for place in scenario['region']['polygon'])
    centroid = SurveyArea(boundary=ring).centroid()
    return GeoPosition(centroid.latitude_deg, centroid.longitude_deg, altitude)


def _places(frame: LocalFrame, route: Mapping[str, Any]) -> Floats:
    stops = [route['home'], *route['viewpoints'], route['home']]
    columns = ('latitude_deg', 'longitude_deg', 'altitude_m')
    values = np.array([[float(stop[name]) for name in columns] for stop in stops])
    return frame.to_enu(values[:, 0], values[:, 1], values[:, 2])


def _flown(path: Path) -> dict[str, Floats]:
    """Return the places of the readings by vehicle; none without the file."""
    found: dict[str, list[list[float]]] = {}
    try:
        with path.open(encoding='utf-8', newline='') as file:
            for row in csv.DictReader(file):
                place = [float(row[name]) for name in ('east_m', 'north_m', 'up_m')]
                found.setdefault(row['vehicle'], []).append(place)
    except (OSError, KeyError, ValueError):
        return {}
    return {name: np.array(places) for name, places in found.items()}


def draw_routes(
    image: NDArray[np.uint8],
    depth_m: Floats,
    lens: PinholeCamera,
    pose: tuple[Floats, Floats],
    routes: RunRoutes,
) -> NDArray[np.uint8]:
    """Return `image` with planned routes as thin lines and flown routes as thick lines.

    Objects in front of a line hide it. `pose` is position and rotation of the camera.
    """
    drawn = Overlay(image=image.copy(), depth_m=depth_m, lens=lens, pose=pose)
    for number, (name, places) in enumerate(routes.planned.items()):
        colour = COLOURS[number % len(COLOURS)]
        if name in routes.flown:
            drawn.line(routes.flown[name], colour, 3)
        drawn.line(places, WHITE, 1)
        drawn.dots(places[1:-1], colour, 4)
    return drawn.image
