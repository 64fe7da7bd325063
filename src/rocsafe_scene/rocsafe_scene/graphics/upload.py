# SPDX-License-Identifier: Apache-2.0
"""Upload of meshes, grids and images to Panda3D."""

from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray
from panda3d import core

from rocsafe_geo.terrain.height_grid import HeightGrid
from rocsafe_scene.mesh.mesh import Floats, Mesh

_ROW = np.dtype(
    [('point', '<f4', 3), ('normal', 'i1', 4), ('colour', 'u1', 4), ('place', '<f4', 2)]
)
# The largest number of 16 bits is reserved: it means no corner.
_MOST_16_BIT = 65535
# Costs half of trilinear filtering on a processor; the difference is hardly visible.
_MIPMAPPED = core.SamplerState.FTLinearMipmapNearest, core.SamplerState.FTLinear


def _format() -> Any:
    array = core.GeomVertexArrayFormat()
    array.addColumn(core.InternalName.getVertex(), 3, core.Geom.NTFloat32, core.Geom.CPoint)
    array.addColumn(core.InternalName.getNormal(), 4, core.Geom.NTInt8, core.Geom.CNormal)
    array.addColumn(core.InternalName.getColor(), 4, core.Geom.NTUint8, core.Geom.CColor)
    array.addColumn(core.InternalName.getTexcoord(), 2, core.Geom.NTFloat32, core.Geom.CTexcoord)
    layout = core.GeomVertexFormat()
    layout.addArray(array)
    return core.GeomVertexFormat.registerFormat(layout)


def geom_node(name: str, mesh: Mesh) -> Any:
    """Return a Panda3D node that draws `mesh`."""
    rows = np.empty(len(mesh.points), _ROW)
    rows['point'] = mesh.points
    rows['normal'][:, :3] = np.rint(127.0 * mesh.normals)
    rows['colour'], rows['place'] = mesh.colours, mesh.places
    data = core.GeomVertexData(name, _format(), core.Geom.UHStatic)
    data.uncleanSetNumRows(len(rows))
    memoryview(data.modifyArray(0)).cast('B')[:] = rows.view(np.uint8).data
    triangles = core.GeomTriangles(core.Geom.UHStatic)
    is_small = len(rows) < _MOST_16_BIT
    triangles.setIndexType(core.Geom.NTUint16 if is_small else core.Geom.NTUint32)
    indices = triangles.modifyVertices()
    indices.uncleanSetNumRows(3 * len(mesh.triangles))
    corners = mesh.triangles.astype(np.uint16 if is_small else np.uint32)
    memoryview(indices).cast('B')[:] = corners.data.cast('B')
    geom = core.Geom(data)
    geom.addPrimitive(triangles)
    node = core.GeomNode(name)
    node.addGeom(geom)
    return node


def grid_meshes(grid: HeightGrid, cells: int, hole: HeightGrid | None = None) -> Iterator[Mesh]:
    """Yield a height grid in chunks of `cells` x `cells`, without the cells that `hole` covers."""
    frame, normals = grid.frame, grid.normals()
    points = np.column_stack([frame.places(), grid.heights.ravel()])
    for row in range(0, frame.rows - 1, cells):
        for column in range(0, frame.columns - 1, cells):
            rows = np.arange(row, min(row + cells, frame.rows - 1))
            columns = np.arange(column, min(column + cells, frame.columns - 1))
            corner: Floats = (rows[:, None] * frame.columns + columns).ravel()
            if hole is not None:
                corner = corner[~_is_in(points[corner] + 0.5 * frame.cell_m, hole)]
            if len(corner):
                yield _cells(points, normals.reshape(-1, 3), corner, frame.columns)


def _is_in(places: Floats, hole: HeightGrid) -> Floats:
    return hole.covers(places[:, :2])


def _cells(points: Floats, normals: Floats, corner: Floats, columns: int) -> Mesh:
    a, b, c, d = corner, corner + 1, corner + columns + 1, corner + columns
    # Cells are cut from south-west to north-east, as in `HeightGrid.height_at`.
    triangles = np.concatenate([np.column_stack([a, b, c]), np.column_stack([a, c, d])])
    used, inverse = np.unique(triangles, return_inverse=True)
    return Mesh(
        points=points[used],
        normals=normals[used],
        places=points[used, :2],
        colours=np.full((len(used), 4), 255, np.uint8),
        triangles=inverse.reshape(-1, 3).astype(np.int32),
    )


def colour_texture(name: str, image: NDArray[np.uint8], *, is_tile: bool = False) -> Any:
    """Return a mip-mapped texture of `image`: blue, green, red, maybe alpha; row 0 at v = 0."""
    layout = core.Texture.FRgb if image.shape[2] == 3 else core.Texture.FRgba
    wrap = core.SamplerState.WMRepeat if is_tile else core.SamplerState.WMMirror
    return _texture(name, image, layout, _MIPMAPPED, wrap)


def grey_texture(name: str, image: NDArray[np.uint8]) -> Any:
    """Return a mip-mapped texture of brightness, mirrored beyond its edges; row 0 at v = 0."""
    return _texture(name, image, core.Texture.FRed, _MIPMAPPED)


def class_texture(name: str, classes: NDArray[np.uint8]) -> Any:
    """Return a texture of class numbers, never interpolated; row 0 at v = 0."""
    return _texture(name, classes, core.Texture.FRed, (core.SamplerState.FTNearest,) * 2)


def height_texture(name: str, heights: NDArray[np.float32]) -> Any:
    """Return a texture of heights in metres; row 0 at v = 0."""
    filters = (core.SamplerState.FTLinear,) * 2
    return _texture(name, heights, core.Texture.FR32, filters, core.SamplerState.WMClamp)


def _texture(
    name: str,
    values: NDArray[Any],
    layout: Any,
    filters: tuple[Any, Any],
    wrap: Any = core.SamplerState.WMMirror,
) -> Any:
    """Return a texture with filters for minification and magnification."""
    texture = core.Texture(name)
    rows, columns = values.shape[:2]
    kind = core.Texture.TFloat if values.dtype == np.float32 else core.Texture.TUnsignedByte
    texture.setup2dTexture(columns, rows, kind, layout)
    _fill(texture, values)
    texture.setMinfilter(filters[0])
    texture.setMagfilter(filters[1])
    _wrap(texture, wrap)
    return texture


def _fill(texture: Any, values: NDArray[Any]) -> None:
    texture.setCompression(core.Texture.CMOff)
    texture.setKeepRamImage(False)
    raw = np.ascontiguousarray(values)
    texture.setRamImage(raw.data.cast('B'))


def _wrap(texture: Any, mode: Any) -> None:
    texture.setWrapU(mode)
    texture.setWrapV(mode)
