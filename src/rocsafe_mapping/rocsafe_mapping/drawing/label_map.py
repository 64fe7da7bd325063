# SPDX-License-Identifier: Apache-2.0
"""A map of label images, drawn with the poses of their photographs."""

from collections.abc import Callable, Iterator, Mapping

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_mapping.drawing.grid import Window
from rocsafe_mapping.drawing.ownership import NO_PHOTO
from rocsafe_mapping.drawing.placed_photo import PlacedPhoto, drawn
from rocsafe_mapping.drawing.renderer import Renderer

UNKNOWN = 0
Labels = NDArray[np.uint8]


def label_tiles(
    renderer: Renderer,
    placed_photos: Mapping[str, PlacedPhoto],
    labels_of: Callable[[str], Labels | None],
    side: int,
) -> Iterator[tuple[Window, Labels]]:
    """Return the labels of the map's tiles, each from the photograph that the map shows there.

    Labels are not blended: each pixel has the label of the photograph that the map shows there.

    Parameters
    ----------
    renderer, placed_photos
        Of the map.
    labels_of
        Returns the label image of a photograph by name, as large as the photograph, 0 where
        nothing is known; None where there is none.
    side
        Of a tile, a multiple of 16.
    """
    for tile in renderer.window.tiles(side):
        index = renderer.owner_index(tile)
        found = np.full(index.shape, UNKNOWN, np.uint8)
        for number in np.unique(index).tolist():
            name = '' if number == NO_PHOTO else renderer.names[number]
            labels = labels_of(name) if name else None
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
