# SPDX-License-Identifier: Apache-2.0
"""Turns an ideal rendered image into a photograph by a real lens, shutter and sensor."""

import math
from dataclasses import dataclass, field

import cv2
import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import ImageArray
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.cameras.camera import Truth
from rocsafe_scene.optics.distortion import Distortion, lens_to_draw, pixel_rays
from rocsafe_scene.optics.effects import Effects
from rocsafe_scene.optics.motion import Rates
from rocsafe_scene.optics.sensor_response import fall_off, image_of_light, light_of, with_noise

# Motion blur sums shifted images at most this far apart, px, and at most so many.
_BLUR_STEP_PX = 0.7
_MOST_BLUR_STEPS = 64

Map = NDArray[np.float32]


@dataclass(slots=True, eq=False)
class Optics:
    """Makes photographs by `lens` from images by `source`, an ideal pinhole with a wider view.

    With a rolling shutter each row has its own time: the middle row is exposed at the time of the
    image, the others up to half of `readout_s` earlier or later. Objects are where they are at the
    middle row; the camera moves uniformly meanwhile.

    Attributes
    ----------
    lens
        Intrinsics of the photograph, without distortion.
    effects
        Effects of lens, shutter and sensor.
    source
        Pinhole camera by which images must be rendered.

    Raises
    ------
    ValueError
        If the distortion folds the image over itself.
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

    def develop(
        self, image: ImageArray, rates: Rates | None, rng: np.random.Generator
    ) -> ImageArray:
        """Return the photograph made from an image by `source`.

        Parameters
        ----------
        image
            Image by `source`: blue, green, red.
        rates
            Image velocities, see `pixel_rates`; None: the camera stands still.
        rng
            Generator of the noise.
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
        """Return depth and instance of each pixel: those of the nearest rendered pixel."""
        maps = self._maps(rates)
        if maps is None:
            return truth
        columns, rows = (
            np.clip(np.rint(each), 0, size - 1).astype(np.intp)
            for each, size in zip(maps, truth.depth_m.shape[::-1], strict=True)
        )
        return Truth(depth_m=truth.depth_m[rows, columns], numbers=truth.numbers[rows, columns])

    def _maps(self, rates: Rates | None) -> tuple[Map, Map] | None:
        """Return column and row in `source` of each pixel; None if they are its own."""
        is_rolling = rates is not None and self.effects.readout_s > 0.0
        if self.source == self.lens:
            return None
        if rates is None or not is_rolling:
            return self._place
        return self._rolled(*self._place, rates)

    def _rolled(self, column: Map, row: Map, rates: Rates) -> tuple[Map, Map]:
        """Return the places in the image of the middle row that each row sees at its own time."""
        height = self.lens.image_height_px
        moments = (np.arange(height, dtype=np.float32) - 0.5 * (height - 1)) / np.float32(height)
        late = (moments * np.float32(self.effects.readout_s))[:, None]
        from_column, from_row = column, row
        # A point moves at the rate of the place it comes from: two iterations are enough.
        for _ in range(2):
            there = cv2.remap(
                rates, from_column, from_row, cv2.INTER_NEAREST, borderMode=cv2.BORDER_REPLICATE
            )
            from_column, from_row = column - there[..., 0] * late, row - there[..., 1] * late
        return from_column, from_row


def blurred(image: ImageArray, ways_px: Rates) -> ImageArray:
    """Return `image` blurred along the path of each pixel, in linear light, centred on the pixel.

    Parameters
    ----------
    image : (height, width, 3)
        Image: blue, green, red.
    ways_px : (height, width, 2)
        Path of each pixel during the exposure, px, x right and y down.
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
