# SPDX-License-Identifier: Apache-2.0
"""Which files of a map there are, and what they are worth."""

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from rocsafe_geo.regions.area import SurveyArea
from rocsafe_mapping.mosaic.mapmaker import Mapmaker
from rocsafe_mapping.options import MosaicOptions
from rocsafe_mapping.photographs.label_images import LABELS
from rocsafe_mapping.products.map_products import QUALITY_JSON, ProductOptions

TILES = 'tiles'


@dataclass(frozen=True, slots=True, kw_only=True)
class MapFiles:
    """The files of a map.

    Attributes
    ----------
    geotiff, quality, tiles
        Absolute paths; empty while there is none.
    ground_resolution_m
        Side of a pixel of the GeoTIFF.
    is_final
        Whether the GeoTIFF holds all photographs.
    is_georeferenced
        Whether nothing contradicts the measurements.
    stated_error_m
        Standard error of the ground's place; NaN while it is not known.
    """

    geotiff: str = ''
    quality: str = ''
    tiles: str = ''
    ground_resolution_m: float = 0.0
    is_final: bool = False
    is_georeferenced: bool = False
    stated_error_m: float = math.nan


def files_before(options: MosaicOptions) -> MapFiles:
    """Return the files of a map that grows; a GeoTIFF of an earlier run counts as it lies."""
    geotiff = Path(options.output_path).absolute()
    return MapFiles(
        geotiff=str(geotiff) if geotiff.exists() else '',
        tiles=str(options.products / TILES) if options.live_tiles else '',
        ground_resolution_m=options.ground_resolution_m,
    )


def product_options_of(
    options: MosaicOptions, maker: Mapmaker, region: SurveyArea | None
) -> ProductOptions:
    """Return what shall be written of a mission's map.

    Label images that the collector kept beside the photographs are mapped, too.
    """
    frame = maker.frame
    labels = Path(options.store_directory) / LABELS
    return ProductOptions(
        geotiff=Path(options.output_path).absolute(),
        folder=options.products,
        region=region.polygon(frame.frame) if region is not None and frame is not None else None,
        labels=labels if labels.is_dir() else None,
    )


def files_after(before: MapFiles, options: MosaicOptions, quality: Mapping[str, Any]) -> MapFiles:
    """Return the files of a finished map with this `quality`."""
    return replace(
        before,
        geotiff=str(Path(options.output_path).absolute()),
        quality=str(options.products / QUALITY_JSON),
        ground_resolution_m=quality['ground_resolution_m'],
        is_final=True,
        is_georeferenced=quality['is_georeferenced'],
        stated_error_m=quality['stated_error_m']['rms'],
    )
