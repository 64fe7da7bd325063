# SPDX-License-Identifier: Apache-2.0
"""Estimates of whole families of surveys, beside what they state of themselves.

    python benchmarks/radiation_unseen.py --split validate --trials 60
    python benchmarks/radiation_unseen.py --split validate --without 'the wall'

Surveys are drawn by ``radiation_families`` from three seeds: ``develop`` to work on, ``validate``
to decide what stays, ``opened`` to look at once. The estimator knows the nuclide and the ground,
and has its own defaults otherwise. The uncollided counts of the weakest source at its nearest
reading are 30 or more, sources lie two heights apart or more.

Targets: right number >= 0.95, false alarms <= 0.02, ellipses and strengths within 0.92 to 0.98,
error over bound <= 1.15; beside steel the ellipse covers >= 0.90 of the answers that are enough.
"""

import argparse
import json
import math
import sys
import time
from collections.abc import Iterator, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from radiation_families import FAMILIES, SPLITS, Drawn, drawn
from radiation_peers import PEERS

from rocsafe_geo.arrays import FloatArray
from rocsafe_radiation.decision.sequential_decision import sequential_evidence
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.localization import source_count, starts
from rocsafe_radiation.localization.estimates import Localization, SourceEstimate
from rocsafe_radiation.localization.fit_setting import Setting
from rocsafe_radiation.localization.localize import LocalizationOptions, localize
from rocsafe_radiation.localization.search_options import SearchOptions
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.readings.survey import RadiationSurvey

# Number of sources of trial i, in turn; beside steel there is one.
ORDERS = (0, 1, 2, 3)
QUANTILE_95 = 5.991


@dataclass(frozen=True, slots=True)
class Ablation:
    """A rule or a constant taken away: options changed, names of modules replaced."""

    options: dict[str, Any]
    names: tuple[tuple[Any, str, Any], ...] = ()


ABLATIONS = {
    'nothing': Ablation({}),
    'other spacings': Ablation(
        {'background_spacings': (2.0,)}, ((source_count, 'FIRST', (2, 0, 0, 0, 0, 0)),)
    ),
    'other stds of the field': Ablation(
        {'background_slopes': (0.0, 0.05)}, ((source_count, 'FIRST', (1, 1, 0, 0, 0, 0)),)
    ),
    'other errors of fixes': Ablation(
        {'position_factors': (1.0,)}, ((source_count, 'FIRST', (2, 1, 0, 0, 0, 0)),)
    ),
    'rareness of steep fields': Ablation({'background_slope_std': 1e9}),
    'rho': Ablation({'rhos': (0.0,)}),
    'the wall': Ablation({'are_shades_tried': False}),
    'spikes': Ablation({'outlier_share': 1e-30}),
    'starts without spikes': Ablation(
        {}, ((starts, '_weightings', lambda likelihood, _: [np.ones(likelihood.survey.size)]),)
    ),
    'mirror images': Ablation({'line_readings': 10**9}),
    'largest ellipse': Ablation({'largest_ellipse_share': 1e9}),
    'more candidates': Ablation({'tried_candidates': 2}),
    'odds of a source': Ablation({'log_odds_of_source': 0.0}),
    'near evidence 2': Ablation({'near_evidence': 2.0}),
    'widening': Ablation({'largest_dispersion': 1e9}),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class Outcome:
    """What became of one survey.

    Attributes
    ----------
    family, order, found
        What it is of, true and stated number of sources.
    probability
        Stated probability of the true number.
    errors, widths, covered
        For each source, if the number is right: distance to the nearest found over the bound,
        longest half axis in metres, and whether it lies in the ellipse.
    strengths, intervals
        Whether the strength lies in its interval, and the upper over the lower end of this.
    is_enough
        Whether the evidence was stated to be enough.
    seconds
        Processor time.
    peers
        Errors over bounds of each of the peers, which are told the number of sources.
    """

    family: str
    order: int
    found: int
    probability: float
    errors: list[float]
    widths: list[float]
    covered: list[bool]
    strengths: list[bool]
    intervals: list[float]
    is_enough: bool
    seconds: float
    peers: dict[str, list[float]]


def outcome(one: Drawn, search: SearchOptions) -> Outcome:
    """Return what the estimator makes of a survey."""
    survey = RadiationSurvey(
        positions_enu_m=one.stated_m, counts=one.counts, exposures=one.exposures
    )
    options = LocalizationOptions(kernel=Kernel(nuclide=one.nuclide), search=search)
    begin = time.process_time()
    found = localize(survey, options)
    rule = StoppingRule()
    setting = Setting(kernel=options.kernel, source_up_m=options.source_up_m)
    evidence = sequential_evidence(survey, setting, rule.smallest_usvh)
    seconds = time.process_time() - begin
    pairs = _pairs(one, found) if len(found.sources) == len(one.sources) else []
    chances = [*found.order_probabilities, *[0.0] * 4]
    return Outcome(
        family=one.family,
        order=len(one.sources),
        found=len(found.sources),
        probability=chances[len(one.sources)],
        errors=[_error(one, *pair) for pair in pairs],
        widths=[estimate.ellipse_95()[0] for _, estimate in pairs],
        covered=[_is_covered(one.sources[k], estimate) for k, estimate in pairs],
        strengths=[_is_within(one.sources[k], estimate) for k, estimate in pairs],
        intervals=[math.exp(3.92 * estimate.log_std) for _, estimate in pairs],
        is_enough=rule.verdict(found, evidence).is_enough,
        seconds=seconds,
        peers={},
    )


def _peer_errors(one: Drawn, places: FloatArray) -> list[float]:
    return [
        float(np.hypot(*(places - source[:2]).T).min() / math.sqrt(np.trace(bound[:2, :2])))
        for source, bound in zip(one.sources, one.bound_m2, strict=True)
    ]


def _pairs(one: Drawn, found: Localization) -> list[tuple[int, SourceEstimate]]:
    places = [source.position_enu_m[:2] for source in found.sources]
    return [
        (k, found.sources[int(np.argmin([np.hypot(*(p - source[:2])) for p in places]))])
        for k, source in enumerate(one.sources)
    ]


def _error(one: Drawn, index: int, estimate: SourceEstimate) -> float:
    miss = estimate.position_enu_m[:2] - one.sources[index, :2]
    return float(np.hypot(*miss) / math.sqrt(np.trace(one.bound_m2[index, :2, :2])))


def _is_covered(source: FloatArray, estimate: SourceEstimate) -> bool:
    miss = estimate.position_enu_m[:2] - source[:2]
    plane = estimate.covariance_m2[:2, :2]
    return bool(miss @ np.linalg.solve(plane, miss) < QUANTILE_95)


def _is_within(source: FloatArray, estimate: SourceEstimate) -> bool:
    low, high = estimate.interval_95_usvh()
    return bool(low < source[3] < high)


def outcomes(
    split: str, families: Sequence[str], trials: int, first: int, without: Ablation
) -> Iterator[Outcome]:
    """Yield the outcomes of `trials` surveys, families and numbers of sources in turn."""
    search = replace(SearchOptions(), **without.options)
    for module, name, value in without.names:
        setattr(module, name, value)
    for index in range(first, first + trials):
        family = families[index % len(families)]
        order = 1 if family == 'steel' else ORDERS[index // len(families) % len(ORDERS)]
        one = drawn(split, index, family, order)
        found = {name: find(one) for name, find in PEERS.items()} if order else {}
        peers = {name: _peer_errors(one, places) for name, places in found.items()}
        yield replace(outcome(one, search), peers=peers)


def summary(name: str, rows: Sequence[Outcome]) -> str:
    """Return one line of the table."""
    right = [row.order == row.found for row in rows]
    sure = [r for r, row in zip(right, rows, strict=True) if max(_chances(row)) > 0.99]
    errors = [v for row in rows for v in row.errors]
    return (
        f'{name:10} {len(rows):4} {_mean(right):6.3f} '
        f'{math.sqrt(_mean([v * v for v in errors])):7.2f} {_median(errors):6.2f} '
        f'{_mean([v for row in rows for v in row.covered]):8.3f} '
        f'{_median([v for row in rows for v in row.widths]):7.2f} '
        f'{_mean([v for row in rows for v in row.strengths]):8.3f} '
        f'{_median([v for row in rows for v in row.intervals]):6.2f} '
        f'{_mean([row.is_enough for row in rows]):6.2f} '
        f'{_mean([r for r, row in zip(right, rows, strict=True) if row.is_enough]):7.3f} '
        f'{_mean(sure):6.3f} {_mean([row.seconds for row in rows]):6.2f}'
    )


def _chances(row: Outcome) -> tuple[float, float]:
    return row.probability, 1.0 - row.probability


def _mean(values: Sequence[float]) -> float:
    return float(np.mean(values)) if len(values) else math.nan


def _median(values: Sequence[float]) -> float:
    return float(np.median(values)) if len(values) else math.nan


HEAD = (
    f'{"of":10} {"n":>4} {"right":>6} {"rms/bnd":>7} {"median":>6} {"ellipse":>8} {"axis m":>7} '
    f'{"strength":>8} {"ratio":>6} {"enough":>6} {"&right":>7} {"sure":>6} {"CPU s":>6}'
)


def table(rows: Sequence[Outcome]) -> str:
    """Return the table of families, of numbers of sources without steel, and of both."""
    lines = [HEAD]
    for family in FAMILIES:
        own = [row for row in rows if row.family == family]
        lines += [summary(family, own)] if own else []
    plain = [row for row in rows if row.family != 'steel']
    for order in ORDERS:
        own = [row for row in plain if row.order == order]
        lines += [summary(f'K = {order}', own)] if own else []
    lines.append(summary('all', plain))
    for name in PEERS:
        errors = [v for row in plain for v in row.peers.get(name, [])]
        lines.append(
            f'{name:10} told the number: error/bound '
            f'{math.sqrt(_mean([v * v for v in errors])):.2f}, median {_median(errors):.2f}'
        )
    return '\n'.join(lines)


def main() -> None:
    """Print the table; write each outcome to a file of JSON lines."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument('--split', choices=SPLITS, default='develop')
    parser.add_argument('--trials', type=int, default=48)
    parser.add_argument('--first', type=int, default=0, help='number of the first survey')
    parser.add_argument('--families', nargs='+', choices=FAMILIES, default=list(FAMILIES))
    parser.add_argument('--without', choices=ABLATIONS, default='nothing')
    parser.add_argument('--out', type=Path, help='file of JSON lines, appended to')
    parser.add_argument('--table', type=Path, nargs='+', help='only the table of such files')
    options = parser.parse_args()
    if options.table:
        lines = [line for path in options.table for line in path.read_text().splitlines()]
        sys.stdout.write(table([Outcome(**json.loads(line)) for line in lines]) + '\n')
        return
    rows = []
    for row in outcomes(
        options.split,
        options.families,
        options.trials,
        options.first,
        ABLATIONS[options.without],
    ):
        rows.append(row)
        if options.out:
            with options.out.open('a') as stream:
                stream.write(json.dumps(asdict(row)) + '\n')
    sys.stdout.write(table(rows) + '\n')


if __name__ == '__main__':
    main()
