# SPDX-License-Identifier: Apache-2.0
"""The schema of scene files."""

from datetime import datetime
from typing import Annotated, Any, Literal

from pydantic import AfterValidator, BaseModel, BeforeValidator, ConfigDict, Field

from rocsafe_geo.storage.utc_time import in_utc, time_of_text
from rocsafe_scene.mesh.classes import class_number
from rocsafe_scene.scene.sunlight import DEFAULT_TIME

Weather = Literal['clear', 'overcast', 'wet', 'fog', 'dusk']
Point = tuple[float, float]
Byte = Annotated[int, Field(ge=0, le=255)]
Rgb = tuple[Byte, Byte, Byte]


def _known_class(name: str) -> str:
    class_number(name)
    return name


class Block(BaseModel):
    """Base of all blocks: frozen; unknown keys, conversions and infinities are refused."""

    model_config = ConfigDict(extra='forbid', strict=True, frozen=True, allow_inf_nan=False)


class PlaceBlock(Block):
    """Place of the scene, unless a mission gives it."""

    latitude_deg: float = Field(default=0.0, ge=-89.0, le=89.0)
    longitude_deg: float = Field(default=0.0, ge=-180.0, le=180.0)
    altitude_m: float = Field(default=0.0, ge=-500.0, le=9000.0)


class LightBlock(Block):
    """Time of the sun, and the weather."""

    time: Annotated[datetime, BeforeValidator(time_of_text), AfterValidator(in_utc)] = DEFAULT_TIME
    weather: Weather = 'clear'


class TerrainBlock(Block):
    """Relief near the site and far from it, and density of long grass.

    `dem` and `orthophoto` are GeoTIFFs of a real place. They replace relief and painted ground.
    """

    local_m: float = Field(default=1.2, ge=0.0, le=50.0)
    hills_m: float = Field(default=40.0, ge=0.0, le=1000.0)
    tufts: float = Field(default=1.0, ge=0.0, le=4.0)
    dem: str | None = None
    orthophoto: str | None = None


class GroundBlock(Block):
    """An entry of the ground: marks and earthwork; `with` has the options of its kind."""

    name: Annotated[str, Field(min_length=1, max_length=64)]
    kind: str
    outline: tuple[Point, ...] | None = Field(default=None, min_length=3)
    line: tuple[Point, ...] | None = Field(default=None, min_length=2)
    options: dict[str, Any] = Field(default={}, alias='with')


class ScatterBlock(Block):
    """Random places of many objects: `count` within an outline or around a place."""

    count: int = Field(ge=1, le=5000)
    outline: tuple[Point, ...] | None = Field(default=None, min_length=3)
    around: tuple[float, float] | None = None
    spread_m: tuple[float, float] = (5.0, 5.0)


class WaypointBlock(Block):
    """Place of a moving object at a time, seconds after the start of the mission."""

    time_s: float = Field(ge=0.0)
    at: Point


class ObjectBlock(Block):
    """An object: its maker or mesh, its place, its properties for rays and labels."""

    name: Annotated[str, Field(min_length=1, max_length=64)]
    make: str | None = None
    mesh: str | None = None
    label: Annotated[str, AfterValidator(_known_class)] | None = Field(default=None, alias='class')
    at: Point | None = None
    position: Point | None = None
    line: tuple[Point, ...] | None = Field(default=None, min_length=2)
    scatter: ScatterBlock | None = None
    height_m: float = Field(default=0.0, ge=-100.0, le=1000.0)
    yaw_deg: float = 0.0
    pitch_deg: float = Field(default=0.0, ge=-180.0, le=180.0)
    roll_deg: float = Field(default=0.0, ge=-180.0, le=180.0)
    scale: float = Field(default=1.0, gt=0.0, le=1000.0)
    material: str = ''
    fill: float = Field(default=1.0, gt=0.0, le=1.0)
    temperature_c: float = Field(default=15.0, ge=-90.0, le=2000.0)
    path: tuple[WaypointBlock, ...] = ()
    options: dict[str, Any] = Field(default={}, alias='with')


class SceneDescription(Block):
    """The content of a scene file; coordinates `at` and of lines are in the frame of the scene.

    The origin of the frame is the mission origin; its x axis is turned by `yaw_deg` from east.
    """

    name: Annotated[str, Field(pattern=r'^[A-Za-z0-9][A-Za-z0-9_-]*$', max_length=64)]
    description: str = ''
    seed: int = Field(default=1, ge=0, le=2**31 - 1)
    yaw_deg: float = 0.0
    place: PlaceBlock = PlaceBlock()
    light: LightBlock = LightBlock()
    terrain: TerrainBlock = TerrainBlock()
    ground: tuple[GroundBlock, ...] = ()
    objects: tuple[ObjectBlock, ...] = ()
