# SPDX-License-Identifier: Apache-2.0
"""Options of the node ``localizer``."""

import math
from dataclasses import dataclass, field

from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.kernel import Kernel
from rocsafe_radiation.localization import LocalizationOptions
from rocsafe_radiation.nuclide import DEFAULT_NUCLIDE, nuclide
from rocsafe_radiation.order_search import LARGEST_ORDER
from rocsafe_radiation.reading_log import ReadingLog

AUTO_MODEL = 'auto'
MODELS = (AUTO_MODEL, PAPER_MODEL, AIR_MODEL)


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizerOptions:
    """Options of the localizer."""

    vehicles: tuple[str, ...] = field(
        default=(), metadata={'doc': 'namespaces of the vehicles that carry a detector'}
    )
    model: str = field(
        default=AUTO_MODEL,
        metadata={'doc': 'law of the dose rate: paper, air, or auto: what the readings say'},
    )
    nuclide: str = field(default=DEFAULT_NUCLIDE, metadata={'doc': 'whose photons air attenuates'})
    origin_latitude_deg: float = field(
        default=0.0,
        metadata={'doc': 'WGS84 latitude of the mission origin, degrees; 0, 0: the first reading'},
    )
    origin_longitude_deg: float = field(
        default=0.0, metadata={'doc': 'WGS84 longitude of the mission origin, degrees'}
    )
    origin_altitude_m: float = field(
        default=0.0,
        metadata={'doc': 'altitude of the ground there above the ellipsoid, metres', 'max': 1e4},
    )
    source_height_m: float = field(
        default=0.5,
        metadata={'doc': 'expected height of sources above the ground, metres', 'min': -100.0},
    )
    source_height_std_m: float = field(
        default=1.0,
        metadata={'doc': 'standard deviation of that height, metres', 'min': 0.0, 'max': 1e3},
    )
    sensitivity_cps_per_usvh: float = field(
        default=0.0,
        metadata={
            'doc': 'counts a second for 1 uSv/h; 0: from counts and dose rate of each reading',
            'min': 0.0,
            'max': 1e7,
        },
    )
    largest_order: int = field(
        default=LARGEST_ORDER,
        metadata={'doc': 'most sources looked for', 'min': 0, 'max': LARGEST_ORDER},
    )
    period_s: float = field(
        default=5.0,
        metadata={'doc': 'wall time between two fits, seconds', 'min': 0.1, 'max': 3600.0},
    )

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise ValueError(f'model = {self.model!r} must be one of: {", ".join(MODELS)}')
        nuclide(self.nuclide)
        self.origin()
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')

    def origin(self) -> GeoPosition:
        """Return the origin of the mission, on the ground.

        Raises
        ------
        ValueError: if it is out of range.
        """
        return GeoPosition(
            latitude_deg=self.origin_latitude_deg,
            longitude_deg=self.origin_longitude_deg,
            altitude_m=self.origin_altitude_m,
        )

    def looks_a_fit(self, look_period_s: float) -> int:
        """Return how many looks make a period."""
        return math.ceil(self.period_s / look_period_s)

    def localization(self, log: ReadingLog) -> LocalizationOptions:
        """Return what is known before the readings of `log`."""
        is_paper = self.model == PAPER_MODEL or (
            self.model == AUTO_MODEL and log.models == {PAPER_MODEL}
        )
        return LocalizationOptions(
            kernel=Kernel(is_lossy=not is_paper, nuclide=self.nuclide),
            source_up_m=self.source_height_m,
            source_up_std_m=self.source_height_std_m,
            largest_order=self.largest_order,
        )
