# SPDX-License-Identifier: Apache-2.0
"""Gas sensors: what they see, how fast they follow, what they read."""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from rocsafe_dispersion.agents.agent_table import Agent
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between, require_not_negative, require_positive

# A sensor forgets what it saw so many time constants ago.
CONSTANTS_KEPT = 8.0
# Unit of a sensor that looks down through the air instead of taking it in.
OPEN_PATH = 'ppm_m'


@dataclass(frozen=True, slots=True, kw_only=True)
class Intake:
    """What the airframe does to the sample.

    Attributes
    ----------
    dilution
        Share of the concentration that arrives: clean air from the rotors dilutes it.
    delay_s
        Time from the air beside the vehicle to the sensor, seconds.
    """

    dilution: float = 1.0
    delay_s: float = 0.0

    def __post_init__(self) -> None:
        require_between('dilution', self.dilution, 0.01, 1.0)
        require_between('delay_s', self.delay_s, 0.0, 60.0, 's')


@dataclass(frozen=True, slots=True, kw_only=True)
class GasSensor:
    """A kind of gas sensor with one channel.

    Attributes
    ----------
    name, technology
        Name of the kind and its physical principle.
    unit
        What it reads: ``ppm`` or ``mg_m3`` of its calibration gas, or ``ppm_m``, the sum along a
        beam from the vehicle straight down to the ground, ppm times metres.
    calibration_gas
        Gas whose concentration it would read right.
    responses
        Reading for one unit of each gas, by name of the agent.
    lamp_ev
        Energy of a lamp that ionises, eV: it sees agents below it, with the response 1 where
        `responses` has none; 0: no lamp.
    rise_s, fall_s
        Time constants, seconds.
    limit
        Limit of detection, in its unit.
    noise
        Standard deviation of a reading in clean air, in its unit.
    relative_noise
        Standard deviation as a share of the reading.
    ceiling
        Largest reading, in its unit.
    drift, drift_s
        Standard deviation of its zero, in its unit, and time in which it wanders, seconds.
    overload, clear_down_s
        Reading beyond which it stays at its ceiling for a time, and that time, seconds; an
        infinite overload: never.
    bars
        Readings at which it shows one bar more, ascending; none: it shows numbers.
    is_selective
        Whether it is blind to all gases without a response; otherwise that is unknown.
    """

    name: str
    technology: str
    unit: str = 'ppm'
    calibration_gas: str
    responses: Mapping[str, float] = field(default_factory=dict)
    lamp_ev: float = 0.0
    rise_s: float
    fall_s: float
    limit: float
    noise: float
    relative_noise: float = 0.0
    ceiling: float
    drift: float = 0.0
    drift_s: float = 1800.0
    overload: float = math.inf
    clear_down_s: float = 0.0
    bars: tuple[float, ...] = ()
    is_selective: bool = False

    def __post_init__(self) -> None:
        if self.unit not in ('ppm', 'mg_m3', OPEN_PATH):
            raise ValueError(f'{self.name}: unit is {self.unit!r}: must be ppm, mg_m3 or ppm_m')
        for name in ('rise_s', 'fall_s', 'limit', 'noise', 'ceiling', 'drift_s', 'overload'):
            value = getattr(self, name)
            if value != math.inf:
                require_positive(f'{self.name}: {name}', value)
        for name in ('relative_noise', 'drift', 'clear_down_s', 'lamp_ev'):
            require_not_negative(f'{self.name}: {name}', getattr(self, name))
        if list(self.bars) != sorted(set(self.bars)):
            raise ValueError(f'{self.name}: bars must ascend')

    @property
    def is_open_path(self) -> bool:
        """Whether it looks down to the ground: rotors neither dilute nor delay what it sees."""
        return self.unit == OPEN_PATH

    @property
    def memory_s(self) -> float:
        """How long what it saw has an effect, seconds."""
        return CONSTANTS_KEPT * max(self.rise_s, self.fall_s) + self.clear_down_s

    def response(self, agent: Agent) -> float:
        """Return the reading for one unit of an agent; 0: it is blind to it."""
        if self.lamp_ev:
            energy = agent.ionisation_ev
            if energy is None or energy >= self.lamp_ev:
                return 0.0
            return self.responses.get(agent.name, 1.0)
        return self.responses.get(agent.name, 0.0)

    def sees(self, agent: Agent) -> bool | None:
        """Return whether silence of the sensor speaks against an agent; None: unknown."""
        if self.lamp_ev:
            return None if agent.ionisation_ev is None else self.response(agent) > 0.0
        if agent.name not in self.responses and not self.is_selective:
            return None
        return self.response(agent) > 0.0

    def bar_count(self, reading: float) -> int:
        """Return how many bars it shows."""
        return sum(reading >= bar for bar in self.bars)

    def follow(self, times_s: Sequence[float], inputs: Sequence[float]) -> FloatArray:
        """Return the response to an input at its times, from rest, (n,).

        Parameters
        ----------
        times_s
            Ascending, seconds; an input holds from the time before to its own.
        inputs
            What the sensor would read in the long run.
        """
        values = np.zeros(len(times_s))
        value = 0.0
        for index in range(1, len(times_s)):
            change = inputs[index] - value
            constant = self.rise_s if change > 0.0 else self.fall_s
            value += change * -math.expm1(-(times_s[index] - times_s[index - 1]) / constant)
            values[index] = value
        return values
