# SPDX-License-Identifier: Apache-2.0
"""The map of what is where: a GeoTIFF of classes, and the area of each."""

import json
from collections.abc import Iterator, Mapping
from pathlib import Path

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.storage.durable import write_whole
from rocsafe_mapping.drawing.coarse_view import NO_PHOTO
from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.placed_photo import PlacedPhoto, drawn
from rocsafe_mapping.drawing.renderer import Renderer
from rocsafe_mapping.errors import MappingError
from rocsafe_mapping.photographs.label_images import LabelImages
from rocsafe_mapping.products.cog import write_cog

LABELS_TIF, LABELS_JSON = 'labels.tif', 'labels.json'
TILE_PX, VALUES = 256, 256
# The value where nothing is known.
UNKNOWN = 0
Tiles = Iterator[tuple[Window, NDArray[np.uint8]]]


def write_labels(
    folder: Path,
    renderer: Renderer,
    placed_photos: Mapping[str, PlacedPhoto],
    images: LabelImages,
) -> None:
    """Write ``labels.tif`` and ``labels.json``: what each value means and how much there is of it.

    Parameters
    ----------
    folder
        Where they go.
    renderer, placed_photos
        Of the map.
    images
        Label images, named like the files of the photographs.

    Raises
    ------
    MappingError
        If they cannot be written.
    ValueError
        If a label image is not as large as its photograph.
    """
    counts = np.zeros(VALUES, np.int64)

    def counted(tiles: Tiles) -> Tiles:
        for window, labels in tiles:
            np.add(counts, np.bincount(labels.ravel(), minlength=VALUES), out=counts)
            yield window, labels

    tiles = _label_tiles(renderer, placed_photos, images)
    colours = {label.value: label.colour for label in images.classes}
    path = folder / LABELS_TIF
    write_cog(path, renderer.grid, renderer.window, counted(tiles), palette=colours)
    names = {label.value: label.name for label in images.classes}
    pixel_m2 = renderer.grid.resolution_m**2
    rows = [
        {
            'value': value,
            'class': names.get(value, str(value)),
            'colour': list(colours.get(value, ())),
            'area_m2': round(float(counts[value]) * pixel_m2, 2),
        }
        for value in np.flatnonzero(counts).tolist()
        if value != UNKNOWN
    ]
    try:
        write_whole(folder / LABELS_JSON, json.dumps({'classes': rows}, indent=1).encode() + b'\n')
    except OSError as error:
        raise MappingError(f'cannot write {folder / LABELS_JSON}: {error}') from error


def _label_tiles(
    renderer: Renderer,
    placed_photos: Mapping[str, PlacedPhoto],
    images: LabelImages,
) -> Tiles:
    """Return the labels of the map's tiles, each from the photograph that the map shows there.

    Labels are not blended.
    """
    for tile in renderer.window.tiles(TILE_PX):
        index = renderer.owner_index(tile)
        found = np.full(index.shape, UNKNOWN, np.uint8)
        for number in np.unique(index).tolist():
            name = '' if number == NO_PHOTO else renderer.names[number]
            labels = images.of(Path(name).stem) if name else None
            if labels is None:
                continue
            camera = placed_photos[name].photo.camera
            if labels.shape != (camera.height_px, camera.width_px):
                raise ValueError(
                    f'{name}: label image is {labels.shape[1]} x {labels.shape[0]} pixels, the '
                    f'photograph {camera.width_px} x {camera.height_px}'
                )
            seen = placed_photos[name].pixel_map(renderer.grid, tile)
            picture = drawn(labels, seen, cv2.INTER_NEAREST)
            found[index == number] = picture[index == number]
        if np.any(index != NO_PHOTO):
            yield tile, found
