# SPDX-License-Identifier: Apache-2.0
"""Options of the nodes of this package."""

import math
from dataclasses import dataclass
from pathlib import Path
from typing import ClassVar

from rocsafe_geo.option import option

# Room for any one photograph, however its edges fall on the map's grid.
SMALLEST_MAX_PIXELS = 512 * 512
STORE_DOC = 'directory of the image store'


@dataclass(frozen=True, slots=True, kw_only=True)
class CollectorOptions:
    """Options of the collector node."""

    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles that send photographs')
    store_directory: str = option('images', STORE_DOC)
    reserve_mb: int = option(64, 'space that photographs leave on the disk, MiB', 0, 1_000_000)
    copy_to: str = option(
        '', 'where each stored photograph is copied: a folder or http(s) URL; or nowhere'
    )

    copy_token_file: str = option(
        '', 'file that holds the token of the HTTP repository; or none is needed'
    )
    serve_host: str = option(
        '', 'address at which photographs of other hosts are taken; empty: none are'
    )
    serve_port: int = option(47612, 'its port; 0: any', 0, 65_535)
    serve_token_file: str = option('', 'file with the token that they must bring')
    store_labels: bool = option(
        False, 'keep the label images of simulated photographs beside them'
    )

    def __post_init__(self) -> None:
        _require_text('store_directory', self.store_directory)
        if self.copy_token_file and not self.copy_to:
            raise ValueError(
                f'copy_token_file = {self.copy_token_file!r} needs copy_to, which is empty'
            )
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')


@dataclass(frozen=True, slots=True, kw_only=True)
class MosaicOptions:
    """Options of the mosaic node."""

    MOVED_PARAMETERS: ClassVar = {'live_tiles': 'always true'}

    store_directory: str = option('images', STORE_DOC)
    output_path: str = option('mosaic.tif', 'GeoTIFF that the service mosaic/save writes')
    products_directory: str = option(
        '', 'where quality, overlays and live tiles go; empty: map, beside the GeoTIFF'
    )
    ground_resolution_m: float = option(
        0.1, 'side of a pixel of the map, metres; 0: that of the images', 0.0, 1e3
    )
    max_pixels: int = option(
        25_000_000,
        'limit of width times height of the map; a larger one gets coarser pixels',
        SMALLEST_MAX_PIXELS,
        2**31,
    )

    def __post_init__(self) -> None:
        _require_text('store_directory', self.store_directory)
        _require_text('output_path', self.output_path)
        if not 0.0 <= self.ground_resolution_m < math.inf:
            raise ValueError(
                f'ground_resolution_m = {self.ground_resolution_m} must be at least 0 and finite'
            )

    @property
    def products(self) -> Path:
        """Folder of what goes with the GeoTIFF."""
        if self.products_directory:
            return Path(self.products_directory).absolute()
        return Path(self.output_path).absolute().parent / 'map'


def _require_text(name: str, value: str) -> None:
    if not value:
        raise ValueError(f'{name} must not be empty')
