# SPDX-License-Identifier: Apache-2.0
"""Photographs of scenes from straight above, which come with this package.

Each is a JPEG file with north at the top, and a JSON file beside it with the width of its pixels
and the boxes of what stands there. `tools/ground_photographs.py` makes both.
"""

import json
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

import cv2
import numpy as np

from rocsafe_geo.arrays import FloatArray, ImageArray
from rocsafe_scene.errors import GroundError
from rocsafe_scene.flat_ground.scene_box import SceneBox
from rocsafe_scene.ground.ground_patch import GroundBounds, Patch

FOLDER = Path(__file__).parent / 'photographs'
# Name of the scene without objects: meadow everywhere.
NO_SCENE = 'none'
# Names of the scenes with a photograph in this package, and of the empty one.
SCENE_NAMES = (*sorted(path.stem for path in FOLDER.glob('*.jpg')), NO_SCENE)
# Width over which a photograph fades into what lies around it, metres.
FADING_M = 8.0


@dataclass(frozen=True, slots=True, eq=False)
class GroundPhotograph:
    """A photograph of level ground about the mission origin, and smaller copies of it.

    Parameters
    ----------
    image
        (rows, columns, 3) Blue, green, red; north at the top. The mission origin is its centre.
    texel_m
        Width of a pixel on the ground, metres.
    """

    image: ImageArray
    texel_m: float
    _levels: list[ImageArray] = field(init=False)

    def __post_init__(self) -> None:
        object.__setattr__(self, '_levels', [self.image])

    @property
    def half_m(self) -> tuple[float, float]:
        """Half extents, east and north, metres."""
        rows, columns = self.image.shape[:2]
        return 0.5 * columns * self.texel_m, 0.5 * rows * self.texel_m

    def covers(self, bounds: GroundBounds) -> bool:
        """Return whether `bounds` lie where the photograph does not fade."""
        east, north = (half - FADING_M for half in self.half_m)
        return (
            -east <= bounds.west_m
            and bounds.east_m <= east
            and -north <= bounds.south_m
            and bounds.north_m <= north
        )

    def patch(self, bounds: GroundBounds, resolution_m: float) -> Patch:
        """Return the part of the photograph that shows all of `bounds`, which it must cover.

        Its pixels are at most `resolution_m` wide, or those of the photograph.
        """
        image, matrix = self._level(resolution_m)
        corners = np.array(
            [[bounds.west_m, bounds.north_m, 1], [bounds.east_m, bounds.south_m, 1]]
        )
        (left, top), (right, bottom) = (corners @ matrix.T)[:, :2]
        column, row = max(0, int(left) - 1), max(0, int(top) - 1)
        shift = np.array([[1.0, 0.0, -column], [0.0, 1.0, -row], [0.0, 0.0, 1.0]])
        return Patch(image[row : int(bottom) + 3, column : int(right) + 3], shift @ matrix)

    def laid_over(self, below: Patch, resolution_m: float) -> Patch:
        """Return `below` with the photograph on it, faded out along the photograph's edges."""
        image, matrix = self._level(resolution_m)
        to_ground = np.linalg.inv(below.pixel_from_ground)
        rows, columns = below.image.shape[:2]
        above = cv2.warpAffine(
            image,
            (matrix @ to_ground)[:2],
            (columns, rows),
            flags=cv2.INTER_LINEAR | cv2.WARP_INVERSE_MAP,
            borderMode=cv2.BORDER_REPLICATE,
        )
        east = np.arange(columns) * to_ground[0, 0] + to_ground[0, 2]
        north = np.arange(rows) * to_ground[1, 1] + to_ground[1, 2]
        shares = [
            np.clip((half - np.abs(at)) / FADING_M, 0.0, 1.0).astype(np.float32)
            for half, at in zip(self.half_m, (east, north), strict=True)
        ]
        share = np.minimum(shares[0][None], shares[1][:, None])
        return Patch(
            cv2.blendLinear(above, below.image, share, 1.0 - share), below.pixel_from_ground
        )

    def _level(self, resolution_m: float) -> tuple[ImageArray, FloatArray]:
        """Return the smallest copy that is fine enough, and the matrix ground -> pixel."""
        number = max(0, int(np.floor(np.log2(resolution_m / self.texel_m))))
        while len(self._levels) <= number and min(self._levels[-1].shape[:2]) > 1:
            rows, columns = self._levels[-1].shape[:2]
            size = (max(1, columns // 2), max(1, rows // 2))
            self._levels.append(cv2.resize(self._levels[-1], size, interpolation=cv2.INTER_AREA))
        image = self._levels[min(number, len(self._levels) - 1)]
        rows, columns = image.shape[:2]
        east, north = self.half_m
        across, down = 0.5 * columns / east, 0.5 * rows / north
        matrix = np.array(
            [[across, 0.0, across * east - 0.5], [0.0, -down, down * north - 0.5], [0.0, 0.0, 1.0]]
        )
        return image, matrix


def read_photograph(scene: str) -> GroundPhotograph | None:
    """Return the photograph of a scene of `SCENE_NAMES`, None for `NO_SCENE`.

    Raises
    ------
    GroundError
        If its files cannot be read.
    """
    if scene == NO_SCENE:
        return None
    image = cv2.imread(str(FOLDER / f'{scene}.jpg'))
    if image is None:
        raise GroundError(f'scene {scene!r}: {FOLDER / scene}.jpg cannot be read')
    return GroundPhotograph(np.asarray(image), float(_about(scene)['texel_m']))


def read_boxes(scene: str) -> tuple[SceneBox, ...]:
    """Return the boxes of a scene of `SCENE_NAMES`.

    Raises
    ------
    GroundError
        If its file cannot be read.
    """
    if scene == NO_SCENE:
        return ()
    rows = _about(scene)['boxes']
    return tuple(SceneBox(**{name: _tupled(value) for name, value in row.items()}) for row in rows)


def write_photograph(
    path: Path, photograph: GroundPhotograph, boxes: tuple[SceneBox, ...], quality: int
) -> None:
    """Write a photograph as a JPEG file at `path`, and the JSON file beside it."""
    cv2.imwrite(str(path), photograph.image, [cv2.IMWRITE_JPEG_QUALITY, quality])
    rows = ',\n'.join(json.dumps(asdict(box)) for box in boxes)
    text = f'{{"texel_m": {photograph.texel_m}, "boxes": [\n{rows}\n]}}\n'
    path.with_suffix('.json').write_text(text)


def _about(scene: str) -> dict[str, Any]:
    path = FOLDER / f'{scene}.json'
    try:
        content: dict[str, Any] = json.loads(path.read_text())
    except (OSError, ValueError) as error:
        raise GroundError(f'scene {scene!r}: {path}: {error}') from error
    return content


def _tupled(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value
