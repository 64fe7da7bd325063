# SPDX-License-Identifier: Apache-2.0
"""Reader of scenario files and of the files that they name."""

from pathlib import Path
from typing import Any

from pydantic import ValidationError

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.regions.area_files import read_area
from rocsafe_geo.storage.yaml_source import YamlError, read_yaml
from rocsafe_scenario.blocks.block import LatLon
from rocsafe_scenario.blocks.mission import RegionBlock
from rocsafe_scenario.errors import ScenarioError
from rocsafe_scenario.scenario import Scenario
from rocsafe_scenario.scenario_checks import mistakes
from rocsafe_scenario.validation_text import error_lines

# Most mistakes that are listed; the rest is counted.
MOST_LINES = 10


def read_scenario(path: Path, *, speed: float | None = None, seed: int | None = None) -> Scenario:
    """Read and check the scenario at `path`; `speed` and `seed` replace those of the file.

    Regions of files become part of the scenario, and the paths of other files become absolute, so
    that the result does not depend on the file.

    Raises
    ------
    ScenarioError
        One line for each mistake, naming key path, value and limit.
    """
    try:
        content = read_yaml(path)
    except YamlError as error:
        raise ScenarioError(str(error)) from error
    if not isinstance(content, dict):
        raise ScenarioError(f'{path.name}: must be a block of keys (name, region, survey, ...)')
    return scenario_of(_with_options(content, speed, seed), path)


def scenario_of(content: dict[str, Any], path: Path) -> Scenario:
    """Return the scenario of the content of a file, as `read_yaml` reads it.

    Parameters
    ----------
    content
        Keys and values.
    path
        The file, from which other files are named; it need not exist.

    Raises
    ------
    ScenarioError
        As `read_scenario` does.
    """
    scenario = _validated(path.name, content)
    scenario = _with_files(_with_region(scenario, path), path)
    lines = mistakes(scenario)
    if lines:
        raise _error([f'{path.name}: {line}' for line in lines])
    return scenario


def _validated(name: str, content: dict[str, Any]) -> Scenario:
    try:
        return Scenario.model_validate(content)
    except ValidationError as error:
        raise _error(error_lines(name, error, Scenario)) from error


def _error(lines: list[str]) -> ScenarioError:
    shown = lines[:MOST_LINES]
    if len(lines) > MOST_LINES:
        shown.append(f'... and {len(lines) - MOST_LINES} more')
    return ScenarioError('\n'.join(shown))


def _with_options(
    content: dict[str, Any], speed: float | None, seed: int | None
) -> dict[str, Any]:
    """Return `content` with the values of the command line in place of the file's."""
    if seed is not None:
        content = {**content, 'seed': seed}
    clock = content.get('clock', {})
    if speed is not None and isinstance(clock, dict):
        content = {**content, 'clock': {**clock, 'speed': speed}}
    return content


def _with_region(scenario: Scenario, path: Path) -> Scenario:
    """Return `scenario` with the polygons of the region files that it names."""
    drawn = {
        key: tuple(
            _drawn(f'{key}[{index}]', block, path)
            for index, block in enumerate(getattr(scenario, key))
        )
        for key in ('exclusions', 'other_regions')
    }
    region = _drawn('region', scenario.region, path)
    return scenario.model_copy(update={'region': region, **drawn})


def _drawn(key: str, region: RegionBlock, path: Path) -> RegionBlock:
    """Return a region with the polygon of its file, if it names one."""
    if (region.file is None) == (region.polygon is None):
        raise ScenarioError(f'{path.name}: {key}: must have either polygon or file')
    if region.file is None:
        return region
    if region.holes:
        raise ScenarioError(f'{path.name}: {key}.holes: belong into the file {region.file}')
    place = f'{path.name}: {key}.file = {region.file!r}'
    source = path.parent / region.file
    try:
        block = region_block(read_area(source))
        return block.model_copy(update={'sensors': region.sensors})
    except ValueError as error:
        reason = str(error).removeprefix(f'{source}: ')
        raise ScenarioError(f'{place}: {reason}') from error


def region_block(area: SurveyArea) -> RegionBlock:
    """Return `area` as a scenario writes it."""
    return RegionBlock(
        polygon=_places(area.boundary), holes=tuple(_places(hole) for hole in area.holes)
    )


def _places(ring: Any) -> tuple[LatLon, ...]:
    return tuple((point.latitude_deg, point.longitude_deg) for point in ring)


def _with_files(scenario: Scenario, path: Path) -> Scenario:
    """Return `scenario` with the absolute paths of the other files that it names."""
    camera, radiation, wind = scenario.camera, scenario.radiation, scenario.air.wind
    ground = None if camera.ground == 'scene' else camera.ground
    scene = camera.scene_file or f'../scenes/{scenario.scene}.yaml'
    drawn = scene if camera.backend == 'engine' else None
    terrain = scenario.survey.terrain_file or None
    driver = scenario.ground_vehicle
    labels = driver.labels_file or None if driver else None
    for block, key, named, what in (
        ('camera', 'ground', ground, 'scene or the path of a GeoTIFF'),
        ('camera', 'scene_file', drawn, 'the path of a scene'),
        ('survey', 'terrain_file', terrain, 'the path of a GeoTIFF of heights'),
        ('ground_vehicle', 'labels_file', labels, 'the path of a GeoTIFF of labels'),
        ('radiation', 'scene_file', radiation.scene_file or None, 'the path of a scene'),
        ('air.wind', 'scene_file', wind.scene_file or None, 'the path of a scene'),
        ('air.wind', 'record_file', wind.record_file or None, 'the path of a record (CSV)'),
    ):
        if named is None:
            continue
        file = (path.parent / named).resolve()
        if not file.is_file():
            line = f'{block}.{key} = {named!r}: must be {what}'
            raise ScenarioError(f'{path.name}: {line}; no such file')
        scenario = _with_value(scenario, block, {key: str(file)})
    return scenario


def _with_value(block: Any, path: str, values: dict[str, Any]) -> Any:
    """Return a block with `values` in the block at a path of keys, such as ``air.wind``."""
    key, _, rest = path.partition('.')
    own = getattr(block, key)
    own = _with_value(own, rest, values) if rest else own.model_copy(update=values)
    return block.model_copy(update={key: own})
