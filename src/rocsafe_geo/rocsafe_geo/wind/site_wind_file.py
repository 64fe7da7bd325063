# SPDX-License-Identifier: Apache-2.0
"""The file of the wind on a site: written by ``rocsafe site-wind``, read by air and vehicles.

It is a NumPy archive (``.npz``), which ``numpy.load`` opens without this package.

=============== ============================ ====================================================
array           type and shape               content
=============== ============================ ====================================================
format          text                         ``rocsafe-site-wind 1``
box             float64 (5,)                 west, south, bottom, cell and layer, metres
cells           int64 (3,)                   columns, rows, layers
open            float64 (4,)                 friction velocity, m/s, Obukhov length, roughness
                                             and height of the open wind, metres
ground, floor   float64 (columns, rows)      as in `SitePattern`
east_0 ... 2,   float32                      velocities at the faces to the east, north and top of
north_0 ... 2                                the cells, for open wind to the east and to the north
=============== ============================ ====================================================
"""

import io
from pathlib import Path
from typing import Any

import numpy as np

from rocsafe_geo.storage.archive import Arrays, read_archive
from rocsafe_geo.storage.durable import write_whole
from rocsafe_geo.wind.air_grid import AirGrid, FaceVelocities
from rocsafe_geo.wind.similarity import SurfaceLayer
from rocsafe_geo.wind.site_wind import SitePattern

FORMAT = 'rocsafe-site-wind 1'


def write_pattern(path: Path, pattern: SitePattern) -> None:
    """Write `pattern` to `path`; at any moment the file holds its old or its new content.

    Raises
    ------
    OSError
        If the file cannot be written.
    """
    grid, layer = pattern.grid, pattern.layer
    faces: dict[str, Any] = {
        f'{name}_{axis}': part
        for name, each in (('east', pattern.east), ('north', pattern.north))
        for axis, part in enumerate(each.parts)
    }
    buffer = io.BytesIO()
    np.savez_compressed(
        buffer,
        format=np.array(FORMAT),
        box=np.array([*grid.corner_m, grid.cell_m, grid.layer_m]),
        cells=np.array(grid.shape),
        open=np.array([
            layer.friction_velocity_mps, layer.obukhov_length_m, layer.roughness_m,
            pattern.height_m,
        ]),
        ground=pattern.ground_m,
        floor=pattern.floor_m,
        **faces,
    )  # fmt: skip
    write_whole(path, buffer.getvalue())


def read_pattern(path: Path) -> SitePattern:
    """Return the pattern in the file at `path`.

    Raises
    ------
    ValueError
        In one line, if the file is not there or holds no such pattern.
    """
    return read_archive('wind', path, _pattern)


def _pattern(arrays: Arrays) -> SitePattern:
    if str(arrays['format']) != FORMAT:
        raise ValueError(f'format = {str(arrays["format"])!r} must be {FORMAT!r}')
    west, south, bottom, cell, layer = arrays['box'].tolist()
    columns, rows, layers = arrays['cells'].tolist()
    friction, length, roughness, height = arrays['open'].tolist()
    east, north = (
        FaceVelocities(east=arrays[f'{name}_0'], north=arrays[f'{name}_1'], up=arrays[f'{name}_2'])
        for name in ('east', 'north')
    )
    return SitePattern(
        grid=AirGrid(
            west_m=west, south_m=south, bottom_m=bottom, cell_m=cell, layer_m=layer,
            columns=columns, rows=rows, layers=layers,
        ),
        ground_m=arrays['ground'],
        floor_m=arrays['floor'],
        east=east,
        north=north,
        layer=SurfaceLayer(
            friction_velocity_mps=friction, obukhov_length_m=length, roughness_m=roughness
        ),
        height_m=height,
    )  # fmt: skip
