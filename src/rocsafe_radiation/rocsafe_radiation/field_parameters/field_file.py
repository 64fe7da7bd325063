# SPDX-License-Identifier: Apache-2.0
"""Settings of the simulated field that are lists or blocks: one YAML file.

The keys of sources, shields and background are those of a scenario's ``radiation`` block.
"""

from dataclasses import dataclass
from datetime import datetime
from typing import Literal

from rocsafe_geo.position import GeoPosition

# Latitude and longitude, degrees.
Place = tuple[float, float]
LARGEST_HEIGHT_M = 1e4


@dataclass(frozen=True, slots=True, kw_only=True)
class StopSettings:
    """A place that a moving source passes.

    Attributes
    ----------
    time_s
        When it is there, seconds after the start of the mission.
    position
        Latitude and longitude, degrees.
    """

    time_s: float
    position: Place

    def __post_init__(self) -> None:
        _require_places((self.position,))


@dataclass(frozen=True, slots=True, kw_only=True)
class SourceSettings:
    """A gamma source: at a position, along a line, over an area or moving along a track.

    Attributes
    ----------
    name
        Unique among the sources.
    position
        Latitude and longitude, degrees.
    line, area
        Corners of a source that is spread evenly.
    track
        Places that a moving source passes, straight between them.
    height_m
        Height of all of it above the ground, metres.
    nuclide
        What it consists of; by default Cs-137.
    sigma_usvps
        Dose rate at 1 m of all of it in one point, without air, microsievert per second.
    activity_gbq
        Activity, in place of `sigma_usvps`.
    activity_date
        When it had this activity; by default at the start of the mission.
    """

    name: str
    position: Place | None = None
    line: tuple[Place, ...] = ()
    area: tuple[Place, ...] = ()
    track: tuple[StopSettings, ...] = ()
    height_m: float = 0.0
    nuclide: str | None = None
    sigma_usvps: float | None = None
    activity_gbq: float | None = None
    activity_date: datetime | None = None

    def __post_init__(self) -> None:
        shapes = (self.position, self.line, self.area, self.track)
        if sum(map(bool, shapes)) != 1:
            raise ValueError(
                f'source {self.name}: needs exactly one of position, line, area, track'
            )
        if (self.sigma_usvps is None) == (self.activity_gbq is None):
            raise ValueError(f'source {self.name}: needs exactly one of sigma_usvps, activity_gbq')
        _require_places((self.place, *self.corners))
        _require_height('height_m', self.height_m)

    @property
    def corners(self) -> tuple[Place, ...]:
        """All places that describe where it is, none of a source at one position."""
        return self.line or self.area or tuple(stop.position for stop in self.track)

    @property
    def place(self) -> Place:
        """Where it is, or begins, or the mean of its corners."""
        if self.position is not None:
            return self.position
        if self.track:
            return self.track[0].position
        latitudes, longitudes = zip(*self.corners, strict=True)
        return sum(latitudes) / len(latitudes), sum(longitudes) / len(longitudes)


@dataclass(frozen=True, slots=True, kw_only=True)
class ShieldSettings:
    """An upright box that shields, solid or hollow.

    Attributes
    ----------
    material
        What it is made of.
    position
        Latitude and longitude of the middle of its bottom, degrees.
    length_m, width_m, height_m
        Its outer size, metres.
    base_height_m
        Height of its bottom above the ground, metres.
    heading_deg
        Direction of its length, clockwise from north.
    wall_m
        Thickness of its walls, metres; 0: it is solid.
    """

    material: Literal['iron', 'lead', 'concrete', 'water']
    position: Place
    length_m: float
    width_m: float
    height_m: float
    base_height_m: float = 0.0
    heading_deg: float = 0.0
    wall_m: float = 0.0

    def __post_init__(self) -> None:
        _require_places((self.position,))
        _require_height('base_height_m', self.base_height_m)


@dataclass(frozen=True, slots=True, kw_only=True)
class BackgroundSettings:
    """Natural background.

    Attributes
    ----------
    dose_rate_usvh
        Mean terrestrial dose rate at the ground, microsievert per hour; 0: no background at all.
    variation
        Standard deviation of its logarithm from place to place.
    length_m
        Length over which it varies, metres.
    cosmic
        Whether cosmic rays, which grow with altitude, are added.
    """

    dose_rate_usvh: float = 0.0
    variation: float = 0.0
    length_m: float = 60.0
    cosmic: bool = True


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldFile:
    """The content of the file that the parameter `field_file` names.

    Attributes
    ----------
    sources
        What radiates.
    shields
        Boxes that stand in the way; only the model ``shielded`` heeds them and `solids_file`.
    solids_file
        Things of a scene that stand in the way, too, as `rocsafe scene solids` writes them.
    background
        Natural background.
    ground_altitude_m
        Altitude of level ground above the ellipsoid, metres.
    terrain_file
        Heights of ground that is not level: a GeoTIFF, or a file of `rocsafe scene solids`.
    terrain_shift_m
        Added to these heights so that they count from the ellipsoid, metres.
    """

    sources: tuple[SourceSettings, ...] = ()
    shields: tuple[ShieldSettings, ...] = ()
    solids_file: str = ''
    background: BackgroundSettings = BackgroundSettings()
    ground_altitude_m: float = 0.0
    terrain_file: str = ''
    terrain_shift_m: float = 0.0

    def __post_init__(self) -> None:
        _require_height('ground_altitude_m', self.ground_altitude_m)
        _require_height('terrain_shift_m', self.terrain_shift_m)


def _require_places(places: tuple[Place, ...]) -> None:
    for place in places:
        GeoPosition(*place, 0.0)


def _require_height(name: str, value: float) -> None:
    if not -LARGEST_HEIGHT_M <= value <= LARGEST_HEIGHT_M:
        raise ValueError(
            f'{name} = {value} must be within {-LARGEST_HEIGHT_M:g} and {LARGEST_HEIGHT_M:g}'
        )
