# SPDX-License-Identifier: Apache-2.0
"""What the page shows of a scenario before it is planned: its ground, homes and camera."""

from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import yaml

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_geo.regions.area_files import read_area, read_areas
from rocsafe_geo.storage.yaml_source import YamlError, parse_yaml

CAMERA = ('horizontal_fov_deg', 'image_width_px', 'image_height_px')
# Kinds of files that are text; a packed one is opened by the command line.
IMPORTED = ('.geojson', '.json', '.kml', '.plan', '.csv')
Rings = list[list[list[float]]]


def outline_of(text: str, folder: Path) -> dict[str, Any]:
    """Return region, exclusions, homes and camera of a scenario; what cannot be read is left out.

    Parameters
    ----------
    folder
        Of the scenario: paths in it are relative to this.
    """
    try:
        scenario = parse_yaml(text, 'scenario')
    except YamlError:
        scenario = None
    if not isinstance(scenario, dict):
        scenario = {}
    vehicles = [one for one in _list(scenario.get('vehicles')) if isinstance(one, dict)]
    camera = scenario.get('camera')
    return {
        'region': _rings_of(scenario.get('region'), folder),
        'exclusions': [
            rings
            for one in _list(scenario.get('exclusions'))
            if (rings := _rings_of(one, folder))
        ],
        'vehicles': [
            {'name': str(one.get('name', '')), 'home': _place(one.get('home'))}
            for one in vehicles
        ],
        'camera': {
            key: camera[key]
            for key in CAMERA
            if isinstance(camera, dict) and isinstance(camera.get(key), int | float)
        },
    }


def areas_of(name: str, text: str) -> list[Rings]:
    """Return the polygons of a file that somebody imports, rings of latitude and longitude.

    Raises
    ------
    ValueError
        Naming what is wrong with it.
    """
    suffix = Path(name).suffix.lower()
    if suffix not in IMPORTED:
        raise ValueError(f'{name[:80]!r}: must be one of {", ".join(IMPORTED)}')
    with TemporaryDirectory() as folder:
        path = Path(folder) / f'region{suffix}'
        path.write_text(text, encoding='utf-8')
        try:
            return [_rings(area) for area in read_areas(path)]
        except ValueError as error:
            raise ValueError(str(error).replace(str(path), name[:80])) from error


def with_whole_paths(text: str, folder: Path) -> str:
    """Return a scenario in which files beside it are named by their whole paths.

    A draft lies in another folder than the scenario that it begins with.
    """
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
    except yaml.YAMLError:
        return text
    for node in sorted(_scalars(root), key=lambda node: -node.start_mark.index):
        # A word such as `scene` is a path only if there is such a file.
        is_relative = node.value and not Path(node.value).is_absolute()
        if is_relative and len(node.value) < 1000 and (folder / node.value).is_file():
            path = yaml.safe_dump(str((folder / node.value).resolve()), width=10_000)
            path = path.removesuffix('...\n').strip()
            text = text[: node.start_mark.index] + path + text[node.end_mark.index :]
    return text


def _scalars(node: yaml.Node | None) -> Iterator[yaml.ScalarNode]:
    """Yield the texts of a document, keys of mappings left out."""
    if isinstance(node, yaml.ScalarNode) and node.tag == 'tag:yaml.org,2002:str':
        yield node
    elif isinstance(node, yaml.MappingNode):
        for _, value in node.value:
            yield from _scalars(value)
    elif isinstance(node, yaml.SequenceNode):
        for value in node.value:
            yield from _scalars(value)


def _rings_of(value: Any, folder: Path) -> Rings:
    if not isinstance(value, Mapping):
        return []
    if 'file' in value:
        try:
            return _rings(read_area(folder / str(value['file'])))
        except (ValueError, OSError):
            return []
    rings = [value.get('polygon'), *_list(value.get('holes'))]
    found = [[_place(corner) for corner in _list(ring)] for ring in rings]
    return [ring for ring in found if len(ring) >= 3 and None not in ring]  # type: ignore[misc]


def _rings(area: SurveyArea) -> Rings:
    return [
        [[corner.latitude_deg, corner.longitude_deg] for corner in ring]
        for ring in (area.boundary, *area.holes)
    ]


def _place(value: Any) -> list[float] | None:
    if not isinstance(value, list | tuple) or len(value) < 2:
        return None
    if not all(isinstance(part, int | float) for part in value[:2]):
        return None
    return [float(value[0]), float(value[1])]


def _list(value: Any) -> Sequence[Any]:
    return value if isinstance(value, list | tuple) else ()
