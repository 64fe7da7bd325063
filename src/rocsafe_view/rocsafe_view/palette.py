# SPDX-License-Identifier: Apache-2.0
"""Colours: dose rates on a logarithmic scale, and one colour a vehicle.

Dose rates use "plasma" (Smith and van der Walt, 2015, CC0), which is even in lightness, told apart
by the colour-blind and far from the greens and greys of the ground. Vehicles use eight colours any
two of which are 20 or more apart in CIELAB, to all and to the three kinds of colour-blind people
(Machado, Oliveira, Fernandes, 2009), with a contrast of 2.3 on light and dark.
"""

import math
from collections.abc import Iterable, Sequence
from dataclasses import dataclass

# Every 16th of plasma's 256 colours, from 20 on: the darkest tell nothing on a dark ground.
_PLASMA = (
    (59, 4, 154), (84, 2, 163), (107, 0, 168), (126, 3, 168), (145, 17, 160), (162, 29, 154),
    (178, 42, 143), (193, 59, 129), (205, 74, 118), (217, 88, 106), (227, 104, 95),
    (237, 121, 83), (244, 140, 70), (250, 160, 57), (253, 180, 47), (251, 205, 39),
    (240, 249, 33),
)  # fmt: skip
VEHICLE_COLOURS = (
    '#0a7bbf', '#d55e00', '#80aa80', '#5600ff', '#56562b', '#ff56ff', '#aa5680', '#802bd5',
)  # fmt: skip
# Concentrations of gas: from blue-green to white, of one hue, so that nobody takes it for a dose.
_GAS = ((0, 74, 84), (0, 121, 124), (0, 168, 157), (99, 212, 192), (214, 250, 240))
_DECADES_SHOWN = 4
# Beyond it, the numbers of a finer scale do not fit on the page of a phone.
_DECADES_OF_FINE_TICKS = 2.2
_LOWEST_USVH = 1e-3


@dataclass(frozen=True, slots=True, kw_only=True)
class DoseScale:
    """A logarithmic colour scale of dose rates from `low_usvh` to `high_usvh`.

    Raises
    ------
    ValueError
        Unless 0 < low_usvh < high_usvh.
    """

    low_usvh: float
    high_usvh: float

    def __post_init__(self) -> None:
        if not 0.0 < self.low_usvh < self.high_usvh < math.inf:
            raise ValueError(
                f'low_usvh = {self.low_usvh} must be positive and below '
                f'high_usvh = {self.high_usvh}'
            )

    def fraction(self, dose_rate_usvh: float) -> float:
        """Return where `dose_rate_usvh` lies on the scale, 0 to 1."""
        if dose_rate_usvh <= self.low_usvh:
            return 0.0
        span = math.log(self.high_usvh / self.low_usvh)
        return min(math.log(dose_rate_usvh / self.low_usvh) / span, 1.0)

    def colour(self, dose_rate_usvh: float) -> str:
        """Return the colour of `dose_rate_usvh` as ``#rrggbb``."""
        return ramp_colour(self.fraction(dose_rate_usvh))

    def ticks(self) -> list[float]:
        """Return the ends of the scale, and between them 1, 2 and 5 of each decade, or 1 alone."""
        decades = math.log10(self.high_usvh / self.low_usvh)
        steps = (1.0, 2.0, 5.0) if decades < _DECADES_OF_FINE_TICKS else (1.0,)
        first = math.floor(math.log10(self.low_usvh))
        last = math.ceil(math.log10(self.high_usvh))
        candidates = (step * 10.0**power for power in range(first, last + 1) for step in steps)
        edge = 1.0 + 1e-9
        between = [c for c in candidates if self.low_usvh * edge < c < self.high_usvh / edge]
        return [self.low_usvh, *between, self.high_usvh]


def scale_of(dose_rates_usvh: Iterable[float], tail: float = 0.0) -> DoseScale:
    """Return a scale that holds `dose_rates_usvh`, at most four decades down from the highest.

    Its ends are 1, 2 or 5 times a power of ten, at least one decade apart. Of the lowest rates a
    fraction `tail` may lie below it.
    """
    values = sorted(value for value in dose_rates_usvh if math.isfinite(value) and value > 0.0)
    if not values:
        return DoseScale(low_usvh=0.1, high_usvh=10.0)
    high = _round_up(max(values[-1], 10 * _LOWEST_USVH))
    least = values[int(tail * (len(values) - 1))]
    low = _round_down(max(least, high / 10.0**_DECADES_SHOWN, _LOWEST_USVH))
    return DoseScale(low_usvh=min(low, high / 10.0), high_usvh=high)


def ramp_colour(fraction: float) -> str:
    """Return plasma's colour at `fraction`, 0 to 1, as ``#rrggbb``."""
    return _between(_PLASMA, fraction)


def gas_colour(fraction: float) -> str:
    """Return the colour of a concentration at `fraction` of its scale, 0 to 1, as ``#rrggbb``."""
    return _between(_GAS, fraction)


def gradient(stops: int = 9) -> str:
    """Return the scale from low to high as a CSS gradient."""
    colours = (ramp_colour(number / (stops - 1)) for number in range(stops))
    return f'linear-gradient(90deg,{",".join(colours)})'


def vehicle_colours(vehicles: Sequence[str]) -> dict[str, str]:
    """Return the colour of each vehicle; beyond the set they repeat."""
    return {
        name: VEHICLE_COLOURS[number % len(VEHICLE_COLOURS)]
        for number, name in enumerate(vehicles)
    }


def _between(stops: Sequence[tuple[int, int, int]], fraction: float) -> str:
    """Return the colour at `fraction` of the way along `stops`, 0 to 1."""
    place = min(max(fraction, 0.0), 1.0) * (len(stops) - 1)
    below = min(int(place), len(stops) - 2)
    share = place - below
    parts = zip(stops[below], stops[below + 1], strict=True)
    return '#' + ''.join(f'{round(a + (b - a) * share):02x}' for a, b in parts)


def _round_up(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return next(s * power for s in (1.0, 2.0, 5.0, 10.0) if value <= s * power * (1 + 1e-9))


def _round_down(value: float) -> float:
    power = 10.0 ** math.floor(math.log10(value))
    return next(s * power for s in (5.0, 2.0, 1.0) if value >= s * power * (1 - 1e-9))
