# SPDX-License-Identifier: Apache-2.0
"""What the readings of gas detectors in the same air say for and against each agent."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from statistics import median

from rocsafe_dispersion.agents.agent_table import Agent, agents
from rocsafe_dispersion.detection.gas_sensor import GasSensor
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_geo.limits import require_between, require_not_negative

# A detector misses what it can see, or shows what is not there, with these probabilities.
MISS, FALSE_ALARM = 0.05, 0.02
# A silent detector could have seen what would have read so many times its limit of detection.
CLEAR_LIMITS = 2.0
# Concentrations that several detectors say differ by this standard deviation of their natural
# logarithms (a factor of 2); before, any concentration in six decades is as good as another.
SPREAD, DECADES = math.log(2.0), math.log(1e6)


@dataclass(frozen=True, slots=True, kw_only=True)
class SensorReport:
    """What one detector showed in the air that all detectors of the evidence were in.

    Attributes
    ----------
    sensor
        Kind of detector, as in scenarios.
    reading
        Highest reading, in the unit of the kind; below its limit of detection it is silent.
    is_in_gas
        Whether the detector was in the gas for certain; otherwise its silence counts only where
        the reading of another detector says that there was gas enough.
    """

    sensor: str
    reading: float
    is_in_gas: bool = False

    def __post_init__(self) -> None:
        if self.sensor not in GAS_SENSORS:
            known = ', '.join(sorted(GAS_SENSORS))
            raise ValueError(f'sensor {self.sensor!r} is not known; known: {known}')
        require_not_negative(f'{self.sensor}: reading', self.reading)
        require_between(f'{self.sensor}: reading', self.reading, 0.0, 1e9, self.kind.unit)

    @property
    def kind(self) -> GasSensor:
        """The kind of detector."""
        return GAS_SENSORS[self.sensor]

    @property
    def is_seen(self) -> bool:
        """Whether the detector shows gas."""
        return self.reading >= self.kind.limit


def sensor_likelihood(reports: Sequence[SensorReport], agent: Agent | None) -> float:
    """Return how probable it is that detectors show what they show, some or nothing.

    Parameters
    ----------
    reports
        One of each detector.
    agent
        What was released; None: a substance that no table has.
    """
    amounts = _concentrations_mg_m3(reports, agent) if agent is not None else []
    likelihood = _agreement(amounts)
    for report in reports:
        likelihood *= _one(report, agent, median(amounts) if amounts else None)
    return likelihood


def clean_air_likelihood(reports: Sequence[SensorReport]) -> float:
    """Return how probable it is that detectors show what they show in air without an agent."""
    likelihood = 1.0
    for report in reports:
        likelihood *= _false(report) if report.is_seen else 1.0 - FALSE_ALARM
    return likelihood


def _one(report: SensorReport, agent: Agent | None, mg_m3: float | None) -> float:
    sees = None if agent is None else report.kind.sees(agent)
    share = seen_share(report.sensor) if sees is None else float(sees)
    if report.is_seen:
        return _mixed(share, (1.0 - MISS) / DECADES, _false(report))
    if not report.is_in_gas and not _is_enough(report, agent, mg_m3):
        # Nothing says that there was anything to see: the same for all agents.
        return 1.0 - FALSE_ALARM
    return _mixed(share, MISS, 1.0 - FALSE_ALARM)


def _false(report: SensorReport) -> float:
    """Return the density of the logarithm of a reading that is a false alarm.

    It decreases from the limit of detection on: noise and drift are seldom far above it.
    """
    excess = math.log(report.reading / report.kind.limit)
    return FALSE_ALARM / SPREAD * math.exp(-excess / SPREAD)


@lru_cache(maxsize=len(GAS_SENSORS))
def seen_share(sensor: str) -> float:
    """Return how probable it is that a kind of detector sees a substance of which it is unknown.

    The rule of succession (Laplace 1774) over the agents of which it is known: a selective cell
    sees few substances that no table has, a metal oxide most.
    """
    known = [GAS_SENSORS[sensor].sees(one) for one in agents().values()]
    return (known.count(True) + 1.0) / (len(known) - known.count(None) + 2.0)


def _mixed(share: float, seeing: float, blind: float) -> float:
    """Return the value for a detector that sees the agent with the probability `share`."""
    return share * seeing + (1.0 - share) * blind


def _is_enough(report: SensorReport, agent: Agent | None, mg_m3: float | None) -> bool:
    """Return whether another detector says that this one had enough to see."""
    if agent is None or mg_m3 is None or report.kind.is_open_path:
        return False
    expected = _in_unit(report.kind, agent, mg_m3) * report.kind.response(agent)
    return expected >= CLEAR_LIMITS * report.kind.limit


def _agreement(amounts: Sequence[float]) -> float:
    """Return how much more probable readings are as those of one concentration.

    The ratio of the density of log-normal readings about one unknown concentration to that of
    readings that have nothing to do with each other.
    """
    count = len(amounts)
    if count < 2:
        return 1.0
    logs = [math.log(amount) for amount in amounts]
    middle = sum(logs) / count
    squares = sum((value - middle) ** 2 for value in logs)
    share = (DECADES / (math.sqrt(2.0 * math.pi) * SPREAD)) ** (count - 1) / math.sqrt(count)
    return share * math.exp(-squares / (2.0 * SPREAD**2))


def _concentrations_mg_m3(reports: Sequence[SensorReport], agent: Agent) -> list[float]:
    """Return how much of the agent each detector says that shows gas and sees it.

    An open path does not say how much: nobody knows how long its way through the gas is.
    """
    if agent.molar_mass_g_mol is None:
        return []
    return [
        report.reading / report.kind.response(agent) / _in_unit(report.kind, agent, 1.0)
        for report in reports
        if report.is_seen and report.kind.sees(agent) and not report.kind.is_open_path
    ]


def _in_unit(kind: GasSensor, agent: Agent, mg_m3: float) -> float:
    return mg_m3 if kind.unit == 'mg_m3' else agent.ppm(mg_m3 / 1000.0)
