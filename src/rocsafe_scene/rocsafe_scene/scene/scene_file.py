# SPDX-License-Identifier: Apache-2.0
"""Reading of scene files, with one line for each mistake."""

from pathlib import Path
from typing import Any

import yaml
from pydantic import ValidationError

from rocsafe_geo.storage.named_file import require_file
from rocsafe_scene.errors import SceneError
from rocsafe_scene.scene.description import SceneDescription

_LONGEST_VALUE = 60
_PLAIN = {'extra_forbidden': 'unknown key', 'missing': 'is missing'}


def read_scene(path: Path) -> SceneDescription:
    r"""Return the description in the file at `path`; paths in it are relative to its folder.

    Raises
    ------
    SceneError
        One line for each mistake: file, key path, value, limit.

    Examples
    --------
    A field with a drum and a car; then a key that there is not:

    >>> from tempfile import TemporaryDirectory
    >>> lines = (
    ...     'name: range',
    ...     'place: {latitude_deg: 53.28, longitude_deg: -9.06, altitude_m: 20.0}',
    ...     'light: {time: 2025-06-01T10:00:00Z, weather: clear}',
    ...     'objects:',
    ...     '  - {name: leaking, make: drum, at: [0, 0]}',
    ...     '  - {name: first_car, make: car, at: [20, 20], yaw_deg: 35.0}',
    ... )
    >>> with TemporaryDirectory() as folder:
    ...     path = Path(folder, 'range.yaml')
    ...     _ = path.write_text('\n'.join(lines))
    ...     scene = read_scene(path)
    ...     _ = path.write_text('name: range\nhills: {}\n')
    ...     try:
    ...         read_scene(path)
    ...     except SceneError as error:
    ...         print(error)
    range.yaml: hills: unknown key
    >>> [(one.name, one.make) for one in scene.objects]
    [('leaking', 'drum'), ('first_car', 'car')]
    """
    content = _content(path)
    try:
        description = SceneDescription.model_validate(content)
    except ValidationError as error:
        lines = (_line(path.name, detail) for detail in error.errors(include_url=False))
        raise SceneError('\n'.join(lines)) from error
    return _with_meshes(description, path.parent)


def _content(path: Path) -> Any:
    try:
        require_file(path)
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
    except OSError as error:
        raise SceneError(f'{path}: {error.strerror}') from error
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        reason = ' '.join(str(error).split())
        raise SceneError(f'{path.name}: is no YAML: {reason}') from error
    if not isinstance(content, dict):
        raise SceneError(f'{path.name}: must be a block of keys (name, terrain, objects, ...)')
    return _tuples(content)


def _tuples(value: Any) -> Any:
    """Return `value` with tuples instead of lists, as strict models want."""
    if isinstance(value, dict):
        return {key: _tuples(element) for key, element in value.items()}
    return tuple(map(_tuples, value)) if isinstance(value, list) else value


def _line(name: str, detail: Any) -> str:
    parts = [f'[{key}]' if isinstance(key, int) else f'.{key}' for key in detail['loc']]
    path = ''.join(parts).removeprefix('.')
    if detail['type'] in _PLAIN:
        return f'{name}: {path}: {_PLAIN[detail["type"]]}'
    value = repr(detail['input'])
    shown = value if len(value) <= _LONGEST_VALUE else value[: _LONGEST_VALUE - 3] + '...'
    return f'{name}: {path} = {shown}: {detail["msg"].removeprefix("Value error, ")}'


def _with_meshes(description: SceneDescription, folder: Path) -> SceneDescription:
    """Return `description` with absolute paths."""
    objects = tuple(
        entry if entry.mesh is None
        else entry.model_copy(update={'mesh': str((folder / entry.mesh).resolve())})
        for entry in description.objects
    )  # fmt: skip
    terrain = description.terrain
    files = {
        name: str((folder / path).resolve())
        for name, path in (('dem', terrain.dem), ('orthophoto', terrain.orthophoto))
        if path is not None
    }
    return description.model_copy(
        update={'objects': objects, 'terrain': terrain.model_copy(update=files)}
    )
