# SPDX-License-Identifier: Apache-2.0
"""Detectors: counts from a dose rate, and the dose rate that counts mean.

Sensitivities are those for Cs-137 at the dose rate H*(10). Sources: SBM-20 tube sheet (2.5
cps per uSv/h, 190 us); volume-scaled estimates for CsI(Tl) of 1 and 33 cm^3; Ludlum 44-10 for
NaI(Tl) 2 x 2 inch (900 cpm per uR/h). Relative responses are rough shapes: uncompensated GM tubes
and scintillators over-respond at low energy per dose, because dose there is carried by more
photons.
"""

import math
import zlib
from dataclasses import dataclass, field

import numpy as np

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.physics.scatter import REFERENCE_NUCLIDE, Response, mean_response

NO_DEAD_TIME, NON_PARALYSABLE, PARALYSABLE = 'none', 'non-paralysable', 'paralysable'
# Beyond this share of time dead, a reading is a lower limit.
SATURATION_SHARE = 0.3
# Measured counts a second times dead time where the count rate of a paralysable detector begins to
# fall.
LARGEST_PARALYSABLE_SHARE = 1.0 / math.e
# The largest count that a message field holds.
LARGEST_COUNTS = 2**32 - 1
FLAT = ((20.0, 1.0), (3000.0, 1.0))
GM_RESPONSE = (
    (20.0, 0.3), (40.0, 2.2), (60.0, 2.8), (100.0, 2.2), (200.0, 1.1), (400.0, 0.9),
    (662.0, 1.0), (1250.0, 1.25), (3000.0, 1.6),
)  # fmt: skip
SCINTILLATOR_RESPONSE = (
    (20.0, 2.0), (40.0, 6.0), (60.0, 8.0), (100.0, 7.0), (200.0, 3.6), (400.0, 1.7),
    (662.0, 1.0), (1250.0, 0.55), (3000.0, 0.30),
)  # fmt: skip


@dataclass(frozen=True, slots=True, kw_only=True)
class DetectorModel:
    """A kind of counting detector.

    Attributes
    ----------
    name
        Name of the kind.
    sensitivity_cps_per_usvh
        Counts a second without dead time for one microsievert per hour of Cs-137.
    dead_time_s
        Dead time after each count, seconds.
    dead_time_model
        Whether events within the dead time prolong it.
    dark_rate_cps
        Counts a second without any radiation.
    response
        Energies in keV and sensitivity relative to Cs-137, ascending.
    """

    name: str
    sensitivity_cps_per_usvh: float
    dead_time_s: float
    dead_time_model: str = NON_PARALYSABLE
    dark_rate_cps: float = 0.0
    response: Response = field(default=FLAT, repr=False)

    def __post_init__(self) -> None:
        if not 0.0 < self.sensitivity_cps_per_usvh <= 1e7:
            raise ValueError(
                f'sensitivity_cps_per_usvh = {self.sensitivity_cps_per_usvh} must be above 0 and '
                'at most 1e7'
            )
        if not 0.0 <= self.dead_time_s <= 0.1:
            raise ValueError(f'dead_time_s = {self.dead_time_s} must be within 0 and 0.1')
        if self.dead_time_model not in (NO_DEAD_TIME, NON_PARALYSABLE, PARALYSABLE):
            raise ValueError(f'dead_time_model = {self.dead_time_model!r} is not known')

    def relative_response(self, nuclide_name: str) -> float:
        """Return the counts per dose of a nuclide relative to Cs-137, unshielded."""
        own, reference = (
            mean_response(name, self.response) for name in (nuclide_name, REFERENCE_NUCLIDE)
        )
        return own / reference

    def live_share(self, true_rates_cps: FloatArray) -> FloatArray:
        """Return the share of events that is counted at each true rate, shape (n,)."""
        load = np.asarray(true_rates_cps) * self.dead_time_s
        if self.dead_time_model == NON_PARALYSABLE:
            return np.asarray(1.0 / (1.0 + load))
        if self.dead_time_model == PARALYSABLE:
            return np.asarray(np.exp(-np.minimum(load, 700.0)))
        return np.ones_like(load)

    def is_saturated(self, true_rate_cps: float) -> bool:
        """Return whether more than 0.3 of the time is dead."""
        counted = true_rate_cps * float(self.live_share(np.array(true_rate_cps)))
        folds_back = self.dead_time_model == PARALYSABLE and true_rate_cps * self.dead_time_s > 1.0
        return folds_back or counted * self.dead_time_s > SATURATION_SHARE

    def live_time_s(self, counts: int, window_s: float) -> float:
        """Return the live time that the detector derives from its counts."""
        if self.dead_time_model == PARALYSABLE:
            share = min(counts / window_s * self.dead_time_s, LARGEST_PARALYSABLE_SHARE)
            return window_s * math.exp(-_lambert(share))
        if self.dead_time_model == NON_PARALYSABLE:
            return max(window_s - counts * self.dead_time_s, 1e-6 * window_s)
        return window_s


@dataclass(frozen=True, slots=True, kw_only=True)
class Measurement:
    """Measurement at the end of a window; fields as in RadiationReading."""

    counts: int
    window_s: float
    live_time_s: float
    dose_rate_usvh: float
    dose_rate_std_usvh: float
    is_saturated: bool


def measure(
    detector: DetectorModel,
    equivalent_dose_rate_usvh: float,
    window_s: float,
    generator: np.random.Generator,
) -> Measurement:
    """Return the measurement of `detector` over `window_s` seconds.

    `equivalent_dose_rate_usvh` is the dose rate of Cs-137 that gives as many counts without dead
    time: the sum of the dose rates of all sources, each times its relative response. It is
    averaged over the window. Counts are Poisson with the mean rate * live time.
    """
    rate_cps = (
        detector.sensitivity_cps_per_usvh * equivalent_dose_rate_usvh + detector.dark_rate_cps
    )
    mean = rate_cps * window_s * float(detector.live_share(np.array(rate_cps)))
    counts = int(min(generator.poisson(min(mean, LARGEST_COUNTS / 2.0)), LARGEST_COUNTS))
    live_s = detector.live_time_s(counts, window_s)
    scale = 1.0 / (detector.sensitivity_cps_per_usvh * live_s)
    return Measurement(
        counts=counts,
        window_s=window_s,
        live_time_s=live_s,
        dose_rate_usvh=max(0.0, counts - detector.dark_rate_cps * live_s) * scale,
        # Without a count, the rate may still have been one count a window.
        dose_rate_std_usvh=math.sqrt(max(counts, 1)) * scale,
        is_saturated=detector.is_saturated(rate_cps),
    )


def window_generator(seed: int, vehicle: str, window_index: int) -> np.random.Generator:
    """Return the generator of one window, the same in every run and after every restart."""
    return np.random.default_rng([seed, zlib.crc32(vehicle.encode()), window_index])


def _lambert(share: float) -> float:
    """Return x <= 1 with x exp(-x) = share, by Newton's method from below."""
    x = share
    for _ in range(60):
        slope = (1.0 - x) * math.exp(-x)
        if slope < 1e-9:
            break
        x = min(1.0, x + (share - x * math.exp(-x)) / slope)
    return x


IDEAL = 'ideal'
_KINDS = (
    DetectorModel(
        name='gm_sbm20',
        sensitivity_cps_per_usvh=2.5,
        dead_time_s=190e-6,
        dark_rate_cps=0.2,
        response=GM_RESPONSE,
    ),
    DetectorModel(
        name='csi_1cm3',
        sensitivity_cps_per_usvh=30.0,
        dead_time_s=5e-6,
        dead_time_model=PARALYSABLE,
        response=SCINTILLATOR_RESPONSE,
    ),
    DetectorModel(
        name='csi_33cm3',
        sensitivity_cps_per_usvh=550.0,
        dead_time_s=5e-6,
        dead_time_model=PARALYSABLE,
        response=SCINTILLATOR_RESPONSE,
    ),
    DetectorModel(
        name='nai_2x2',
        sensitivity_cps_per_usvh=1500.0,
        dead_time_s=3e-6,
        dead_time_model=PARALYSABLE,
        response=SCINTILLATOR_RESPONSE,
    ),
)
DETECTORS = {kind.name: kind for kind in _KINDS}
DETECTOR_NAMES = (IDEAL, *DETECTORS)


def response_of(name: str) -> Response:
    """Return the response of a kind of detector; empty for one that reads the dose rate.

    Raises
    ------
    ValueError
        If there is no such kind.
    """
    if name not in DETECTOR_NAMES:
        raise ValueError(f'detector = {name!r} must be one of: {", ".join(DETECTOR_NAMES)}')
    return DETECTORS[name].response if name in DETECTORS else ()
