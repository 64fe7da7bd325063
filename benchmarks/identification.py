# SPDX-License-Identifier: Apache-2.0
"""Agents named from drawn evidence: top 3, Brier score, and what an exact reasoner could reach.

    python benchmarks/identification.py [--cases 2000] [--seed 1]

A case draws an agent of the seed's table and the truth of each observation from that table. Each
witness reports each observation with probability 0.7, and wrongly with probability 0.1. The
posterior is the exact one for cases drawn like this, so no other method can be right more often:
the line of one witness is the bound of the seed's table itself.
"""

import argparse
import time

import numpy as np

from rocsafe_dispersion.agents.agent_table import agents
from rocsafe_dispersion.identification.evidence import Evidence, Report
from rocsafe_dispersion.identification.posterior import IdentificationOptions, identify
from rocsafe_dispersion.identification.signatures import Signatures, signatures

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
