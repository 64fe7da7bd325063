# SPDX-License-Identifier: Apache-2.0
"""Lens, shutter and sensor in one: from a drawn picture to the photograph."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.cameras.camera import Truth
from rocsafe_scene.optics.distortion import Distortion, lens_to_draw, pixel_rays
from rocsafe_scene.optics.effects import Effects
from rocsafe_scene.optics.motion import Rates
from rocsafe_scene.optics.sensor_response import fall_off, image_of_light, light_of, with_noise
from rocsafe_scene.painting.canvas import Image

# A blur is made of pictures this far apart at most, but of no more than so many.
_BLUR_STEP_PX = 0.7
_MOST_BLUR_STEPS = 64

Map = NDArray[np.float32]


@dataclass(slots=True, eq=False)
class Optics:
    """What makes a photograph by `lens` of a picture by `source`, an ideal pinhole around it.

    Of a rolling shutter each row is that of its own moment: the middle row is exposed at the
    picture's time, the others up to half of `readout_s` earlier and later. The world's own motion
    is that of the moment of the middle row; the camera's is even meanwhile.

    Attributes
    ----------
    lens : of the photograph, its distortion aside.
    effects : of lens, shutter and sensor.
    source : what must be drawn.

    Raises
    ------
    ValueError: if the distortion folds the picture.
    """

    lens: PinholeCamera
    effects: Effects
    source: PinholeCamera = field(init=False)
    _place: tuple[Map, Map] = field(init=False)
    _gain: Map = field(init=False)

    def __post_init__(self) -> None:
        x, y = pixel_rays(self.lens)
        self.source = lens_to_draw(self.lens, self.effects)
        if self.effects.distortion:
            x, y = Distortion(*self.effects.distortion).undistorted(x, y)
        matrix = self.source.matrix
        self._place = (
            (x * matrix[0, 0] + matrix[0, 2]).astype(np.float32),
            (y * matrix[1, 1] + matrix[1, 2]).astype(np.float32),
        )
        gain = fall_off(x, y, self.effects.vignetting) * 2.0**self.effects.exposure_ev
        self._gain = gain.astype(np.float32)[..., None]

    def develop(self, image: Image, rates: Rates | None, rng: np.random.Generator) -> Image:
        """Return the photograph of a picture by `source`.

        Parameters
        ----------
        image : blue, green, red.
        rates : at which each pixel moves, see `pixel_rates`; None: nothing moves.
        rng : of the noise.
        """
        if rates is not None and self.effects.shutter_s > 0.0:
            image = blurred(image, rates * np.float32(self.effects.shutter_s))
        maps = self._maps(rates)
        if maps is not None:
            image = np.asarray(
                cv2.remap(image, *maps, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
            )
        if not self.effects.need_light:
            return image
        light = light_of(image) * self._gain
        if self.effects.full_well_e:
            light = with_noise(light, self.effects, rng)
        return image_of_light(light)

    def truth(self, truth: Truth, rates: Rates | None) -> Truth:
        """Return what is true of each pixel of the photograph: that of the nearest drawn one."""
        maps = self._maps(rates)
        if maps is None:
            return truth
        columns, rows = (
            np.clip(np.rint(each), 0, size - 1).astype(np.intp)
            for each, size in zip(maps, truth.depth_m.shape[::-1], strict=True)
        )
        return Truth(depth_m=truth.depth_m[rows, columns], numbers=truth.numbers[rows, columns])

    def _maps(self, rates: Rates | None) -> tuple[Map, Map] | None:
        """Return column and row of `source` that each pixel shows; None: its own."""
        is_rolling = rates is not None and self.effects.readout_s > 0.0
        if self.source == self.lens:
            return None
        if rates is None or not is_rolling:
            return self._place
        return self._rolled(*self._place, rates)

    def _rolled(self, column: Map, row: Map, rates: Rates) -> tuple[Map, Map]:
        """Return the places of the middle row's moment that the rows' own moments show."""
        height = self.lens.image_height_px
        moments = (np.arange(height, dtype=np.float32) - 0.5 * (height - 1)) / np.float32(height)
        late = (moments * np.float32(self.effects.readout_s))[:, None]
        from_column, from_row = column, row
        # where a point was is reckoned with the rate that it has there: twice is enough
        for _ in range(2):
            there = cv2.remap(
                rates, from_column, from_row, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE
            )
            from_column, from_row = column - there[..., 0] * late, row - there[..., 1] * late
        return from_column, from_row


def blurred(image: Image, ways_px: Rates) -> Image:
    """Return `image` as it smears along the way of each pixel, in light, around its place.

    Parameters
    ----------
    image : blue, green, red, (height, width, 3).
    ways_px : during the exposure, x right and y down, (height, width, 2).
    """
    longest_px = float(np.quantile(np.abs(ways_px), 0.999))
    count = min(_MOST_BLUR_STEPS, math.ceil(longest_px / _BLUR_STEP_PX) + 1)
    if longest_px < 0.05:
        return image
    light = light_of(image)
    rows, columns = np.indices(image.shape[:2], np.float32)
    total = np.zeros_like(light)
    for share in (np.arange(count) + 0.5) / count - 0.5:
        shift = np.float32(share)
        total += cv2.remap(
            light, columns - shift * ways_px[..., 0], rows - shift * ways_px[..., 1],
            cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE,
        )  # fmt: skip
    return image_of_light(total / np.float32(count))
