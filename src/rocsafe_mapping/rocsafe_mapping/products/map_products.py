# SPDX-License-Identifier: Apache-2.0
"""The files of a finished map: the GeoTIFF and, in a folder, what belongs to it."""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import shapely

from rocsafe_geo.storage.durable import write_whole
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.mosaic.map_alignment import Alignment
from rocsafe_mapping.mosaic.mapmaker import Mapmaker
from rocsafe_mapping.photographs.label_images import LabelImages
from rocsafe_mapping.products.cog import write_cog
from rocsafe_mapping.products.error_map import error_map, write_error_map
from rocsafe_mapping.products.label_products import write_labels
from rocsafe_mapping.products.overlays import write_mbtiles, write_overlays
from rocsafe_mapping.products.pmtiles_file import write_pmtiles
from rocsafe_mapping.products.quality import quality
from rocsafe_mapping.products.quality_page import quality_page, quality_text

QUALITY_JSON, QUALITY_HTML = 'quality.json', 'quality.html'
Step = Callable[[str], None]


@dataclass(frozen=True, slots=True, kw_only=True)
class ProductOptions:
    """Files to which a map is written.

    Attributes
    ----------
    geotiff
        Its file.
    folder
        Of what goes with it.
    region
        That was to be covered, in local metres.
    with_overlays
        Whether a picture with world file and KML is wanted.
    with_tiles
        Whether MBTiles and PMTiles are wanted.
    labels
        Folder of label images, named like the photographs; None for none.
    """

    geotiff: Path
    folder: Path
    region: shapely.Polygon | None = None
    with_overlays: bool = True
    with_tiles: bool = False
    labels: Path | None = None


def write_products(
    maker: Mapmaker,
    alignment: Alignment,
    wanted: ProductOptions,
    step: Step = lambda _stage: None,
    costs: Mapping[str, Mapping[str, float]] | None = None,
) -> dict[str, Any]:
    """Draw the map, write its files and return its quality.

    Parameters
    ----------
    maker, alignment
        Of the photographs.
    wanted
        What to write.
    step
        Is told the name of each finished stage.
    costs
        Seconds by stage, read when the quality is written.

    Raises
    ------
    PlacementError
        If no photograph is placed.
    MappingError
        If a file cannot be written.
    """
    renderer = maker.renderer(with_relief=True)
    step('seams')
    write_cog(wanted.geotiff, renderer.grid, renderer.window, renderer.tiles())
    step('draw')
    if wanted.labels is not None:
        images = LabelImages(wanted.labels)
        write_labels(wanted.folder, renderer, maker.placed_photos(), images)
        step('labels')
    errors = error_map(alignment, renderer)
    document = quality(alignment, maker.block.state, renderer, wanted.region, errors)
    step('quality')
    picture = ''
    try:
        wanted.folder.mkdir(parents=True, exist_ok=True)
        error_picture = write_error_map(wanted.folder, errors, renderer)
        if wanted.with_overlays:
            stem = wanted.folder / wanted.geotiff.stem
            picture = write_overlays(wanted.geotiff, stem)[0].name
            step('overlays')
        if wanted.with_tiles and not alignment.is_local:
            stem = wanted.folder / wanted.geotiff.stem
            write_mbtiles(wanted.geotiff, stem.with_suffix('.mbtiles'))
            write_pmtiles(stem.with_suffix('.mbtiles'), stem.with_suffix('.pmtiles'))
            step('tiles')
        document['costs'] = {name: dict(cost) for name, cost in (costs or {}).items()}
        page = quality_page(document, picture, error_picture)
        write_whole(wanted.folder / QUALITY_JSON, quality_text(document))
        write_whole(wanted.folder / QUALITY_HTML, page.encode())
    except OSError as error:
        raise MappingError(f'cannot write to {wanted.folder}: {error}') from error
    return document
