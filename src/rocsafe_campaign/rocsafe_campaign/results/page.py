# SPDX-License-Identifier: Apache-2.0
"""The page of a campaign, ``campaign.html``."""

from collections.abc import Sequence
from pathlib import Path

from rocsafe_campaign.design.campaign import Campaign
from rocsafe_campaign.results.intervals import Interval, bootstrap_mean
from rocsafe_campaign.results.metrics import METRICS
from rocsafe_campaign.results.row import COMPLETE, Row
from rocsafe_campaign.results.sensitivity import Influence, influences
from rocsafe_geo.storage.durable import write_whole
from rocsafe_view.formats import figures
from rocsafe_view.pages import render

FILE = 'campaign.html'
# Combinations and failures that are listed; the rest is in the table.
MOST_LISTED = 200


def write_page(folder: Path, campaign: Campaign, rows: Sequence[Row], revision: str) -> Path:
    """Write the page and return its path."""
    path = folder / FILE
    write_whole(path, page_text(campaign, rows, revision).encode())
    return path


def page_text(campaign: Campaign, rows: Sequence[Row], revision: str) -> str:
    """Return the page: figures with intervals, groups, what moves the result, failures."""
    complete = [row for row in rows if row.outcome == COMPLETE]
    failures = [row for row in rows if row.outcome != COMPLETE]
    return render(
        'campaign.html',
        'rocsafe_campaign.results',
        data={},
        block=campaign.block,
        revision=revision,
        run_count=len(rows),
        planned_count=len(campaign.runs()),
        complete_count=len(complete),
        cpu_s=sum(row.cpu_s for row in rows),
        result=result_of(complete, campaign.block.result),
        metrics=[
            (name, *interval_cells(found))
            for name in METRICS
            if (found := result_of(complete, name)).count
        ],
        groups=_groups(campaign, complete),
        influences=[
            (one.key, figures(one.share, 2), figures(one.correlation, 2), _p_text(one.p_value))
            for one in moving(campaign, complete)
        ],
        failures=[(row.number, row.seed, row.outcome, row.text) for row in failures[:MOST_LISTED]],
        failure_count=len(failures),
    )


def moving(campaign: Campaign, rows: Sequence[Row]) -> tuple[Influence, ...]:
    """Return how much each key moves the campaign's result."""
    results = [getattr(row.metrics, campaign.block.result) for row in rows]
    return influences([row.inputs for row in rows], results)


def result_of(rows: Sequence[Row], name: str) -> Interval:
    """Return the mean of a figure and its interval."""
    return bootstrap_mean([getattr(row.metrics, name) for row in rows])


def interval_cells(found: Interval) -> tuple[str, str, str, str]:
    """Return mean, bounds and number of values as text."""
    return figures(found.mean), figures(found.low), figures(found.high), str(found.count)


def _groups(campaign: Campaign, rows: Sequence[Row]) -> list[tuple[str, ...]]:
    """Return the mean of the result for each combination of the values of `vary`."""
    keys = tuple(campaign.block.vary)
    if not keys:
        return []
    groups: dict[str, list[Row]] = {}
    for row in rows:
        groups.setdefault(', '.join(f'{key} = {row.inputs[key]}' for key in keys), []).append(row)
    name = campaign.block.result
    listed = list(groups.items())[:MOST_LISTED]
    return [(text, *interval_cells(result_of(group, name))) for text, group in listed]


def _p_text(value: float) -> str:
    return '< 0.001' if value < 0.001 else figures(value, 2)
