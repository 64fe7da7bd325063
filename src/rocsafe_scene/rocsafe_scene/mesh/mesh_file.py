# SPDX-License-Identifier: Apache-2.0
"""Meshes from files: Wavefront OBJ and glTF binary, with their colours."""

import json
import struct
from dataclasses import replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_geo.pinhole import rotation_of_quaternion
from rocsafe_geo.storage.named_file import require_file
from rocsafe_scene.errors import SceneError
from rocsafe_scene.mesh.mesh import Floats, Mesh, joined, made, unit

_GLTF_MAGIC, _JSON_CHUNK, _BIN_CHUNK = b'glTF', 0x4E4F534A, 0x004E4942
_COMPONENTS = {5120: np.int8, 5121: np.uint8, 5122: np.int16, 5123: np.uint16, 5125: np.uint32,
               5126: np.float32}  # fmt: skip
_WIDTHS = {'SCALAR': 1, 'VEC2': 2, 'VEC3': 3, 'VEC4': 4, 'MAT4': 16}
_GREY = (150, 150, 150)
# glTF has y up and z ahead; ours has z up and x ahead.
_OURS_FROM_GLTF = np.array([[0.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])


def read_mesh(name: str) -> Mesh:
    """Return the mesh of a GLB or OBJ file: metres, z up and x ahead (GLB: y up, z ahead).

    Raises
    ------
    SceneError
        One line, if there is no such file or no mesh in it.
    """
    path = Path(name)
    readers = {'.obj': _read_obj, '.glb': _read_glb}
    reader = readers.get(path.suffix.lower())
    if reader is None:
        raise SceneError(f'mesh = {name}: must be a .glb or .obj file')
    try:
        require_file(path)
        mesh = reader(path)
    except OSError as error:
        raise SceneError(f'mesh = {name}: {error.strerror}') from error
    except (ValueError, KeyError, IndexError, struct.error) as error:
        raise SceneError(f'mesh = {name}: is damaged: {error}') from error
    if not len(mesh.triangles) or not np.isfinite(mesh.points).all():
        raise SceneError(f'mesh = {name}: holds no triangles, or points that are not finite')
    return mesh


def _read_obj(path: Path) -> Mesh:
    points: list[list[float]] = []
    triangles: list[tuple[int, int, int]] = []
    for line in path.read_text(encoding='utf-8', errors='replace').splitlines():
        word, *rest = line.split() or ['']
        if word == 'v':
            points.append([float(value) for value in rest[:3]])
        elif word == 'f':
            corners = [int(item.split('/')[0]) for item in rest]
            corners = [c - 1 if c > 0 else len(points) + c for c in corners]
            triangles += [(corners[0], b, c) for b, c in pairwise(corners[1:])]
    if not triangles:
        raise ValueError('no faces')
    return faceted(np.array(points), np.array(triangles), _GREY)


def faceted(points: Floats, triangles: Floats, colour: tuple[int, int, int]) -> Mesh:
    """Return a mesh of flat triangles over shared points."""
    corners = points[triangles.ravel()]
    a, b, c = corners[0::3], corners[1::3], corners[2::3]
    normals = np.repeat(unit(np.cross(b - a, c - a)), 3, axis=0)
    order = np.arange(len(corners)).reshape(-1, 3)
    return made(corners, normals, corners[:, :2] + corners[:, 2:], order, colour)


def _read_glb(path: Path) -> Mesh:
    document, binary = _chunks(path.read_bytes())
    scene = document['scenes'][document.get('scene', 0)]
    parts: list[Mesh] = []
    for node in scene.get('nodes', []):
        _collect(document, binary, node, np.eye(4), parts)
    if not parts:
        raise ValueError('no mesh')
    return joined(parts).transformed(_OURS_FROM_GLTF)


def _chunks(data: bytes) -> tuple[dict[str, Any], bytes]:
    if data[:4] != _GLTF_MAGIC:
        raise ValueError('not a glTF binary')
    document: dict[str, Any] = {}
    binary, place = b'', 12
    while place < len(data):
        size, kind = struct.unpack_from('<II', data, place)
        content = data[place + 8 : place + 8 + size]
        if kind == _JSON_CHUNK:
            document = json.loads(content)
        elif kind == _BIN_CHUNK:
            binary = content
        place += 8 + size
    return document, binary


def _collect(
    document: dict[str, Any], binary: bytes, index: int, above: Floats, parts: list[Mesh]
) -> None:
    node = document['nodes'][index]
    matrix = above @ _matrix(node)
    if 'mesh' in node:
        for primitive in document['meshes'][node['mesh']]['primitives']:
            parts.append(_primitive(document, binary, primitive, matrix))
    for child in node.get('children', []):
        _collect(document, binary, child, matrix, parts)


def _matrix(node: dict[str, Any]) -> Floats:
    if 'matrix' in node:
        return np.array(node['matrix'], float).reshape(4, 4).T
    turn = rotation_of_quaternion(node.get('rotation', (0.0, 0.0, 0.0, 1.0)))
    matrix = np.eye(4)
    matrix[:3, :3] = turn * np.array(node.get('scale', (1.0, 1.0, 1.0)))
    matrix[:3, 3] = node.get('translation', (0.0, 0.0, 0.0))
    return matrix


def _primitive(
    document: dict[str, Any], binary: bytes, primitive: dict[str, Any], matrix: Floats
) -> Mesh:
    points = _accessor(document, binary, primitive['attributes']['POSITION'])
    placed = points @ matrix[:3, :3].T + matrix[:3, 3]
    if 'indices' in primitive:
        corners = _accessor(document, binary, primitive['indices']).astype(int).ravel()
    else:
        corners = np.arange(len(points))
    mesh = faceted(placed, corners.reshape(-1, 3), _colour(document, primitive))
    if 'NORMAL' not in primitive['attributes']:
        return mesh
    normals = _accessor(document, binary, primitive['attributes']['NORMAL'])
    smooth = unit(normals @ np.linalg.inv(matrix[:3, :3]))[corners]
    return replace(mesh, normals=smooth)


def _colour(document: dict[str, Any], primitive: dict[str, Any]) -> tuple[int, int, int]:
    """Return the base colour of a primitive's material, linear in the file, as sRGB bytes."""
    if 'material' not in primitive:
        return _GREY
    material = document['materials'][primitive['material']]
    factor = material.get('pbrMetallicRoughness', {}).get('baseColorFactor', (0.3, 0.3, 0.3, 1.0))
    red, green, blue = (round(255 * max(0.0, min(1.0, v)) ** (1 / 2.2)) for v in factor[:3])
    return red, green, blue


def _accessor(document: dict[str, Any], binary: bytes, index: int) -> Floats:
    accessor = document['accessors'][index]
    view = document['bufferViews'][accessor['bufferView']]
    kind = np.dtype(_COMPONENTS[accessor['componentType']])
    width = _WIDTHS[accessor['type']]
    start = view.get('byteOffset', 0) + accessor.get('byteOffset', 0)
    stride = view.get('byteStride', kind.itemsize * width)
    count = accessor['count']
    if start + stride * (count - 1) + kind.itemsize * width > len(binary):
        raise ValueError(f'accessor {index} reaches beyond the file')
    rows = np.lib.stride_tricks.as_strided(
        np.frombuffer(binary, np.uint8)[start:], (count, kind.itemsize * width), (stride, 1)
    )
    return np.ascontiguousarray(rows).view(kind).astype(float)
