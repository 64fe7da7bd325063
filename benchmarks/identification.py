# SPDX-License-Identifier: Apache-2.0
"""Agents named from drawn evidence: top 3, Brier score, and what an exact reasoner could reach.

    python benchmarks/identification.py [--cases 2000] [--seed 1]

A case draws an agent of the seed's table and the truth of each observation from that table. Each
witness reports each observation with probability 0.7, and wrongly with probability 0.1. The
posterior is the exact one for cases drawn like this, so no other method can be right more often:
the line of one witness is the bound of the seed's table itself.

Cases of detectors draw a chemical that a detector sees, 1 to 100 ppm of it (even in the
logarithm), and one to four detectors in it, one of which sees it. Each is missing with
probability 0.3 (not all of them), reads within 20 % with its noise and drift, and lies with
probability 0.1: silent, or up to ten limits of detection without cause.
"""

import argparse
import time

import numpy as np

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_dispersion.detection.sensor_kinds import GAS_SENSORS
from rocsafe_dispersion.identification.evidence import Evidence, Report
from rocsafe_dispersion.identification.posterior import IdentificationOptions, identify
from rocsafe_dispersion.identification.sensor_report import SensorReport
from rocsafe_dispersion.identification.signatures import (
    NO_AGENT,
    SOMETHING_ELSE,
    Signatures,
    signatures,
)

TOP = 3


def main() -> None:
    """Draw, identify, print one line a setting."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--cases', type=int, default=2000)
    parser.add_argument('--seed', type=int, default=1)
    options = parser.parse_args()
    names = [name for name, one in agents().items() if one.is_of_seed]
    table = signatures().of(names)
    print('witnesses missing wrong | in the top 3  Brier (sum)  Brier (mean)  CPU-s')
    for witnesses, missing, wrong in (
        (1, 0.0, 0.0), (1, 0.3, 0.0), (1, 0.3, 0.1), (3, 0.3, 0.1), (5, 0.3, 0.1), (8, 0.3, 0.1)
    ):  # fmt: skip
        began = time.process_time()
        rng = np.random.default_rng(options.seed)
        rows = [_case(rng, table, witnesses, missing, wrong) for _ in range(options.cases)]
        top, brier = np.mean(rows, axis=0).tolist()
        spent = time.process_time() - began
        print(
            f'{witnesses:9d} {missing:7.1f} {wrong:5.1f} | {top:12.3f} {brier:12.3f} '
            f'{brier / len(names):13.4f} {spent:6.1f}'
        )
    _of_detectors(options.cases, options.seed)


def _of_detectors(cases: int, seed: int) -> None:
    """Draw cases of detectors and print one line."""
    rng = np.random.default_rng([seed, 1])
    rows = [_detector_case(rng) for _ in range(cases)]
    top, first, other, brier = np.mean(rows, axis=0).tolist()
    print(
        f'detectors: in the top {TOP} {top:.3f}, first {first:.3f}, called something else or none '
        f'{other:.3f}, Brier (sum) {brier:.3f}, (mean) {brier / len(signatures().hypotheses):.4f}'
    )


def _detector_case(rng: np.random.Generator) -> tuple[bool, bool, bool, float]:
    """Return whether the chemical is in the top 3 and first, whether none is, the Brier score."""
    kinds = [one for one in GAS_SENSORS.values() if one.unit == 'ppm']
    seen = [one for one in agents().values() if any(kind.response(one) > 0.0 for kind in kinds)]
    agent = seen[int(rng.integers(len(seen)))]
    ppm = 10.0 ** rng.uniform(0.0, 2.0)
    able = [kind for kind in kinds if kind.response(agent) > 0.0]
    chosen = {able[int(rng.integers(len(able)))].name}
    chosen |= {kinds[int(at)].name for at in rng.integers(len(kinds), size=3)}
    kept = [name for name in sorted(chosen) if rng.random() >= 0.3] or sorted(chosen)[:1]
    reports = []
    for kind in (GAS_SENSORS[name] for name in kept):
        true = max(kind.response(agent), 0.0) * ppm * float(np.exp(0.2 * rng.standard_normal()))
        if rng.random() < 0.1:
            true = 0.0 if true >= kind.limit else kind.limit * 10.0 ** rng.random()
        reading = true + float(np.hypot(kind.noise, kind.drift)) * rng.standard_normal()
        shown = float(np.clip(reading, 0.0, kind.ceiling))
        reports.append(SensorReport(sensor=kind.name, reading=shown))
    found = identify(Evidence(sensors=tuple(reports))).probabilities
    names = [name for name, _ in found]
    brier = sum((probability - (name == agent.name)) ** 2 for name, probability in found)
    is_none = names[0] in (SOMETHING_ELSE, NO_AGENT)
    return agent.name in names[:TOP], names[0] == agent.name, is_none, brier


def _case(
    rng: np.random.Generator, table: Signatures, witnesses: int, missing: float, wrong: float
) -> tuple[bool, float]:
    """Return whether the agent of a drawn case is in the top 3, and the Brier score."""
    row = int(rng.integers(len(table.hypotheses)))
    of_seed = [name for name in table.observations if not name.startswith('sign_')]
    truth = rng.random(len(of_seed)) < table.probabilities[row, : len(of_seed)]
    reports = []
    for _ in range(witnesses):
        is_said = rng.random(len(of_seed)) >= missing
        said = truth ^ (rng.random(len(of_seed)) < wrong)
        reports += [
            Report(observation=name, is_true=bool(said[at]))
            for at, name in enumerate(of_seed)
            if is_said[at]
        ]
    options = IdentificationOptions(no_agent=0.0, something_else=0.0, wrong_report=wrong)
    found = identify(Evidence(reports=tuple(reports)), options, table).probabilities
    true = table.hypotheses[row]
    brier = sum((probability - (name == true)) ** 2 for name, probability in found)
    return true in [name for name, _ in found[:TOP]], brier


if __name__ == '__main__':
    main()
