# SPDX-License-Identifier: Apache-2.0
"""The file of a scene's solids: written by ``rocsafe scene solids``, read by the hazard nodes.

It is a NumPy archive (``.npz``), which ``numpy.load`` opens without this package. Coordinates are
metres to the east, north and up of the origin.

============== =================== ==============================================================
array          type and shape      content
============== =================== ==============================================================
format         text                ``rocsafe-solids 1``
origin         float64 (3,)        latitude and longitude in degrees, altitude above the WGS84
                                   ellipsoid in metres
names          text (k,)           of each thing
materials      text (k,)           of each thing
fills          float64 (k,)        share of a thing's volume that its material takes
triangle_ends  int64 (k,)          the triangles of thing i end before this index, and begin where
                                   those of thing i - 1 end
corners        float32 (n, 3, 3)   triangle, corner, coordinate; anticlockwise seen from outside
grids          float64 (g, 3)      west, south and cell size of each grid of heights, the finest
                                   first
heights_0, ... float64 (rows,      height of the ground at the points of grid 0, ...; the first
               columns)            row in the south, the first column in the west
============== =================== ==============================================================
"""

import io
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.solids.scene_solids import SceneSolids, Thing
from rocsafe_geo.storage.archive import Arrays, read_archive
from rocsafe_geo.storage.durable import write_whole
from rocsafe_geo.terrain.height_grid import GridFrame, HeightGrid

FORMAT = 'rocsafe-solids 1'
SUFFIX = '.npz'


def write_solids(path: Path, solids: SceneSolids) -> None:
    """Write `solids` to `path`; at any moment the file holds its old or its new content.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    buffer = io.BytesIO()
    np.savez_compressed(buffer, **_arrays(solids))
    write_whole(path, buffer.getvalue())


def read_solids(path: Path) -> SceneSolids:
    """Return the solids in the file at `path`.

    Raises
    ------
    ValueError
        In one line, if the file is not there or holds no such solids.
    """
    return read_archive('solids', path, _solids)


def _arrays(solids: SceneSolids) -> dict[str, Any]:
    origin, things = solids.origin, solids.things
    corners = [thing.corners_enu_m.astype(np.float32) for thing in things]
    frames = [grid.frame for grid in solids.ground]
    return {
        'format': np.array(FORMAT),
        'origin': np.array([origin.latitude_deg, origin.longitude_deg, origin.altitude_m]),
        'names': np.array([thing.name for thing in things], np.str_),
        'materials': np.array([thing.material for thing in things], np.str_),
        'fills': np.array([thing.fill for thing in things], np.float64),
        'triangle_ends': np.cumsum([len(each) for each in corners], dtype=np.int64),
        'corners': np.concatenate([np.zeros((0, 3, 3), np.float32), *corners]),
        'grids': np.array([(frame.west_m, frame.south_m, frame.cell_m) for frame in frames]),
        **{f'heights_{i}': grid.heights for i, grid in enumerate(solids.ground)},
    }


def _solids(arrays: Arrays) -> SceneSolids:
    if str(arrays['format']) != FORMAT:
        raise ValueError(f'format = {str(arrays["format"])!r} must be {FORMAT!r}')
    latitude, longitude, altitude = arrays['origin'].tolist()
    corners = np.split(arrays['corners'], arrays['triangle_ends'])[:-1]
    rows = zip(
        arrays['names'].tolist(),
        arrays['materials'].tolist(),
        arrays['fills'].tolist(),
        corners,
        strict=True,
    )
    return SceneSolids(
        origin=GeoPosition(latitude, longitude, altitude),
        things=tuple(
            Thing(name=name, material=material, fill=fill, corners_enu_m=own)
            for name, material, fill, own in rows
        ),
        ground=tuple(
            _grid(place, arrays[f'heights_{i}']) for i, place in enumerate(arrays['grids'])
        ),
    )


def _grid(place: FloatArray, heights: FloatArray) -> HeightGrid:
    west, south, cell = place.tolist()
    rows, columns = heights.shape
    frame = GridFrame(west_m=west, south_m=south, cell_m=cell, columns=columns, rows=rows)
    return HeightGrid(frame, heights)
