# SPDX-License-Identifier: Apache-2.0
"""Settings of lens, shutter and sensor; by default they have no effect."""

from dataclasses import dataclass
from typing import Any

from rocsafe_geo.limits import require_between, require_finite
from rocsafe_geo.option import option

# Coefficients of the Brown-Conrady model in OpenCV's order.
DISTORTION_TERMS = ('k1', 'k2', 'p1', 'p2', 'k3')


def _effect(doc: str, low: float, high: float) -> Any:
    return option(0.0, doc, low, high)


@dataclass(frozen=True, slots=True, kw_only=True)
class Effects:
    """Effects of lens, shutter and sensor; zero switches an effect off.

    Attributes
    ----------
    distortion
        Coefficients k1, k2, p1, p2, k3 of the Brown-Conrady model, as in OpenCV and CameraInfo. At
        most five; missing ones are 0. Empty: no distortion.
    exposure_ev
        The image is brighter by a factor 2 ** exposure_ev.
    vignetting
        Share of natural vignetting, cos^4 of the angle from the axis; 0 to 1.
    full_well_e
        Electrons of the brightest pixel, which sets photon noise; 0: no photon noise.
    read_noise_e
        Standard deviation of the read noise, electrons; needs `full_well_e`.
    shutter_s
        Exposure time, seconds; motion during it blurs the image.
    readout_s
        Time from the first to the last row of a rolling shutter, seconds.
    """

    distortion: tuple[float, ...] = ()
    exposure_ev: float = _effect('brighter by 2 to this power', -10.0, 10.0)
    vignetting: float = _effect('share of cos^4 of the angle from the axis', 0.0, 1.0)
    full_well_e: float = _effect('electrons of the brightest pixel; 0: no noise', 0.0, 1e6)
    read_noise_e: float = _effect('standard deviation, electrons', 0.0, 1e4)
    shutter_s: float = _effect('time that a pixel collects light, s', 0.0, 1.0)
    readout_s: float = _effect('from the first row to the last, s', 0.0, 1.0)

    def __post_init__(self) -> None:
        for name, setting in type(self).__dataclass_fields__.items():
            if 'min' in setting.metadata:
                low, high = setting.metadata['min'], setting.metadata['max']
                object.__setattr__(
                    self, name, require_between(name, getattr(self, name), low, high)
                )
        self._check_distortion()
        if self.read_noise_e and not self.full_well_e:
            raise ValueError(
                f'read_noise_e is {self.read_noise_e:g}: must be 0 without full_well_e'
            )

    def _check_distortion(self) -> None:
        if len(self.distortion) > len(DISTORTION_TERMS):
            raise ValueError(
                f'distortion has {len(self.distortion)} values: must have '
                f'{len(DISTORTION_TERMS)} at most ({", ".join(DISTORTION_TERMS)})'
            )
        given = [require_finite(f'distortion[{i}]', v) for i, v in enumerate(self.distortion)]
        whole = tuple(given + [0.0] * (len(DISTORTION_TERMS) - len(given)))
        object.__setattr__(self, 'distortion', whole if any(whole) else ())

    @property
    def are_none(self) -> bool:
        """Whether there are no effects."""
        return self == NO_EFFECTS

    @property
    def need_motion(self) -> bool:
        """Whether the motion of the camera has an effect."""
        return self.shutter_s > 0.0 or self.readout_s > 0.0

    @property
    def need_light(self) -> bool:
        """Whether brightness changes."""
        return bool(self.exposure_ev or self.vignetting or self.full_well_e)


NO_EFFECTS = Effects()
