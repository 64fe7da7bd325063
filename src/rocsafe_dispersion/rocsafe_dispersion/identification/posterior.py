# SPDX-License-Identifier: Apache-2.0
"""The probability of each agent given what was observed, and what to observe next.

Observations are independent of each other given the agent. A report is wrong with the same
probability whatever is true. With priors of 0.001, no wrong reports and the agents of the seed
alone this is the model of the seed without two agents at once, computed exactly.
"""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_dispersion.identification.evidence import UN_FIRST, UN_LAST, Evidence
from rocsafe_dispersion.identification.sensor_report import (
    clean_air_likelihood,
    sensor_likelihood,
)
from rocsafe_dispersion.identification.signatures import (
    NO_AGENT,
    SOMETHING_ELSE,
    Signatures,
    placards,
    signatures,
)
from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.limits import require_between

_LEAST = 1e-300


@dataclass(frozen=True, slots=True, kw_only=True)
class IdentificationOptions:
    """How evidence is weighed.

    Attributes
    ----------
    no_agent, something_else
        Probabilities, before any evidence, that nothing was released, and that it is a substance
        that the table does not have. The listed agents share the rest alike. The values are
        choices: who asks has reason to think of a release.
    wrong_report
        Probability that a report of a person is wrong.
    wrong_placard
        Probability that a placard does not name what was released.
    """

    no_agent: float = 0.1
    something_else: float = 0.1
    wrong_report: float = 0.1
    wrong_placard: float = 0.02

    def __post_init__(self) -> None:
        require_between('no_agent', self.no_agent, 0.0, 0.999999)
        require_between('something_else', self.something_else, 0.0, 0.999999)
        require_between('no_agent + something_else', self.no_agent + self.something_else, 0.0, 1.0)
        require_between('wrong_report', self.wrong_report, 0.0, 0.5)
        require_between('wrong_placard', self.wrong_placard, 0.0, 1.0)


@dataclass(frozen=True, slots=True, kw_only=True)
class NextObservation:
    """An observation that nobody has reported, and what knowing it would bring on average, bit."""

    observation: str
    gain_bit: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Identification:
    """What was released.

    Attributes
    ----------
    probabilities
        Name and probability, the most probable first; with `NO_AGENT` and `SOMETHING_ELSE`.
    entropy_bit
        What is not known yet; 0: certain.
    next_observations
        The most telling first.
    """

    probabilities: tuple[tuple[str, float], ...]
    entropy_bit: float
    next_observations: tuple[NextObservation, ...]

    @property
    def categories(self) -> dict[str, float]:
        """The probability of each category of agents, the most probable first."""
        found: dict[str, float] = {}
        for name, probability in self.probabilities:
            category = agents()[name].category if name in agents() else name
            found[category] = found.get(category, 0.0) + probability
        return dict(sorted(found.items(), key=lambda item: -item[1]))


def identify(
    evidence: Evidence,
    options: IdentificationOptions | None = None,
    table: Signatures | None = None,
) -> Identification:
    """Return the probability of each hypothesis of `table`, by default of all agents."""
    options, table = options or IdentificationOptions(), table or signatures()
    logs = np.log(np.maximum(prior(table, options), _LEAST))
    logs += _log_reports(evidence, table, options.wrong_report)
    logs += np.log(np.maximum(_placard(evidence.un_number, table, options), _LEAST))
    if evidence.sensors:
        logs += np.log([_sensors(evidence, name) for name in table.hypotheses])
    weights = np.exp(logs - logs.max())
    posterior = weights / weights.sum()
    order = np.argsort(-posterior, kind='stable')
    reported = {report.observation for report in evidence.reports}
    return Identification(
        probabilities=tuple((table.hypotheses[at], float(posterior[at])) for at in order),
        entropy_bit=_entropy_bit(posterior),
        next_observations=_next(posterior, table, reported, options.wrong_report),
    )


def prior(table: Signatures, options: IdentificationOptions) -> FloatArray:
    """Return the probabilities before any evidence, (hypotheses,)."""
    others = {NO_AGENT: options.no_agent, SOMETHING_ELSE: options.something_else}
    listed = sum(name not in others for name in table.hypotheses)
    rest = 1.0 - sum(others.values())
    values = np.array([others.get(name, rest / max(listed, 1)) for name in table.hypotheses])
    return np.asarray(values / values.sum())


def _log_reports(evidence: Evidence, table: Signatures, wrong: float) -> FloatArray:
    """Return the logarithm of the likelihood of all reports, (hypotheses,).

    Reports of one observation share whether it is true: several witnesses of one smell say no
    more than that smell can say.
    """
    if_true: dict[str, float] = {}
    if_false: dict[str, float] = {}
    for report in evidence.reports:
        name = report.observation
        right, other = (1.0 - wrong, wrong) if report.is_true else (wrong, 1.0 - wrong)
        if_true[name] = if_true.get(name, 1.0) * right
        if_false[name] = if_false.get(name, 1.0) * other
    return _log_of_shared(if_true, if_false, table)


def _log_of_shared(
    if_true: Mapping[str, float], if_false: Mapping[str, float], table: Signatures
) -> FloatArray:
    logs = np.zeros(len(table.hypotheses))
    for name, weight in if_true.items():
        share = table.probabilities[:, table.column(name)]
        logs += np.log(np.maximum(share * weight + (1.0 - share) * if_false[name], _LEAST))
    return logs


def _placard(number: int | None, table: Signatures, options: IdentificationOptions) -> FloatArray:
    """Return the likelihood of a UN number, (hypotheses,)."""
    if number is None:
        return np.ones(len(table.hypotheses))
    by_chance = 1.0 / (UN_LAST - UN_FIRST + 1)
    known = placards()
    found = []
    for name in table.hypotheses:
        if name not in known:
            # Its number is unknown, or it has none: any number is as good as another.
            found.append(by_chance)
        else:
            right = 1.0 - options.wrong_placard if known[name] == number else 0.0
            found.append(right + options.wrong_placard * by_chance)
    return np.array(found)


def _sensors(evidence: Evidence, hypothesis: str) -> float:
    if hypothesis == NO_AGENT:
        return clean_air_likelihood(evidence.sensors)
    return sensor_likelihood(evidence.sensors, agents().get(hypothesis))


def _next(
    posterior: FloatArray, table: Signatures, reported: set[str], wrong: float
) -> tuple[NextObservation, ...]:
    """Return what the reports to come would tell: mutual information with the agent, bit."""
    said = table.probabilities * (1.0 - wrong) + (1.0 - table.probabilities) * wrong
    inside = posterior @ _binary_entropy_bit(said)
    gains = _binary_entropy_bit(posterior @ said) - inside
    found = [
        NextObservation(observation=name, gain_bit=max(0.0, float(gain)))
        for name, gain in zip(table.observations, gains, strict=True)
        if name not in reported
    ]
    return tuple(sorted(found, key=lambda one: -one.gain_bit))


def _binary_entropy_bit(share: FloatArray) -> FloatArray:
    inside = np.clip(share, 1e-15, 1.0 - 1e-15)
    return np.asarray(-(inside * np.log2(inside) + (1.0 - inside) * np.log2(1.0 - inside)))


def _entropy_bit(posterior: FloatArray) -> float:
    return -sum(float(p) * math.log2(p) for p in posterior if p > 0.0)
