# SPDX-License-Identifier: Apache-2.0
"""Options of a data set."""

import math
from dataclasses import dataclass

from rocsafe_geo.limits import require_count
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_scene.scene.sunlight import WEATHERS

SPLITS = ('train', 'val', 'test')
FORMATS = ('jpg', 'png')
LARGEST_SIDE_PX = 4096


@dataclass(frozen=True, slots=True, kw_only=True)
class DatasetOptions:
    """Size, cameras and splits of a data set; equal options give equal images.

    Attributes
    ----------
    count
        Number of images.
    seed
        Seed of everything random.
    size_px
        Width and height of an image, pixels.
    fov_deg
        Full angle across the width, degrees.
    height_m
        Least and largest height of the camera above the ground, metres.
    nadir_share
        Share of the images that look straight down (within 6 degrees), 0 to 1.
    weathers
        Kinds of weather, drawn with equal probability.
    image_format
        jpg or png.
    jpeg_quality
        Quality of JPEG files, 1 to 100.
    oversampling
        Factor of resolution, 1 to 4, see `OversampledCamera` of `rocsafe_scene`.
    per_arrangement
        Number of images with the same placement of objects and the same light.
    splits
        Shares of `SPLITS`, sum 1.
    least_pixels
        Instances with fewer pixels are not annotated.
    """

    count: int
    seed: int = 0
    size_px: tuple[int, int] = (640, 480)
    fov_deg: float = 60.0
    height_m: tuple[float, float] = (14.0, 60.0)
    nadir_share: float = 0.5
    weathers: tuple[str, ...] = tuple(WEATHERS)
    image_format: str = 'jpg'
    jpeg_quality: int = 92
    oversampling: int = 1
    per_arrangement: int = 20
    splits: tuple[float, float, float] = (0.7, 0.15, 0.15)
    least_pixels: int = 25

    def __post_init__(self) -> None:
        for name, low, high in (
            ('count', 1, 1_000_000), ('seed', 0, 2**31 - 1), ('jpeg_quality', 1, 100),
            ('oversampling', 1, 4), ('per_arrangement', 1, 10_000), ('least_pixels', 1, 10**6),
        ):  # fmt: skip
            require_count(name, getattr(self, name), low, high)
        if not all(16 <= side <= LARGEST_SIDE_PX for side in self.size_px):
            raise ValueError(f'size_px is {self.size_px}: sides must be 16 to {LARGEST_SIDE_PX}')
        if not 5.0 <= self.fov_deg <= 120.0:
            raise ValueError(f'fov_deg is {self.fov_deg:g}: must be 5 to 120')
        low_m, high_m = self.height_m
        if not 3.0 <= low_m <= high_m <= 200.0:
            raise ValueError(
                f'height_m is {low_m:g} to {high_m:g}: must rise and lie within 3 to 200'
            )
        if not 0.0 <= self.nadir_share <= 1.0:
            raise ValueError(f'nadir_share is {self.nadir_share:g}: must be 0 to 1')
        if self.image_format not in FORMATS:
            raise ValueError(f'image_format is {self.image_format!r}: must be jpg or png')
        self._require_weathers()
        self._require_splits()

    def _require_weathers(self) -> None:
        unknown = [name for name in self.weathers if name not in WEATHERS]
        if unknown or not self.weathers:
            raise ValueError(
                f'weathers are {", ".join(self.weathers) or "none"}: must be of '
                f'{", ".join(WEATHERS)}'
            )

    def _require_splits(self) -> None:
        if len(self.splits) != len(SPLITS) or min(self.splits) < 0.0:
            raise ValueError(f'splits are {self.splits}: must be three shares of at least 0')
        if not math.isclose(sum(self.splits), 1.0, abs_tol=1e-6):
            raise ValueError(f'splits sum to {sum(self.splits):g}: must be 1')

    @property
    def lens(self) -> PinholeCamera:
        """Intrinsics of all images."""
        return PinholeCamera(math.radians(self.fov_deg), *self.size_px)

    @property
    def arrangements(self) -> int:
        """Number of arrangements."""
        return -(-self.count // self.per_arrangement)
