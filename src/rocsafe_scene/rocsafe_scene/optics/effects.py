# SPDX-License-Identifier: Apache-2.0
"""What lens, shutter and sensor do to a picture; by default nothing."""

from dataclasses import dataclass, field
from typing import Any

from rocsafe_geo.limits import require_between, require_finite

# Coefficients of the Brown-Conrady model in OpenCV's order.
DISTORTION_TERMS = ('k1', 'k2', 'p1', 'p2', 'k3')


def _effect(doc: str, low: float, high: float) -> Any:
    return field(default=0.0, metadata={'doc': doc, 'min': low, 'max': high})


@dataclass(frozen=True, slots=True, kw_only=True)
class Effects:
    """Lens and sensor of a camera; zero switches each effect off.

    Attributes
    ----------
    distortion
        K1, k2, p1, p2, k3 of the Brown-Conrady model, as OpenCV and CameraInfo have them; empty:
        none. At most five, those left out are 0.
    exposure_ev
        Brighter by a factor 2 ** exposure_ev.
    vignetting
        Share of the natural fall-off, cos^4 of the angle from the axis.
    full_well_e
        Electrons of the brightest pixel, for photon noise; 0: no photon noise.
    read_noise_e
        Standard deviation, electrons; needs `full_well_e`.
    shutter_s
        Time that a pixel collects light: what moves meanwhile is blurred.
    readout_s
        Time from the first row to the last of a rolling shutter.
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
        """Whether a photograph is the picture as drawn."""
        return self == NO_EFFECTS

    @property
    def need_motion(self) -> bool:
        """Whether the motion of the camera shows."""
        return self.shutter_s > 0.0 or self.readout_s > 0.0

    @property
    def need_light(self) -> bool:
        """Whether brightness changes, be it by blending rows of light."""
        return bool(self.exposure_ev or self.vignetting or self.full_well_e)


NO_EFFECTS = Effects()
