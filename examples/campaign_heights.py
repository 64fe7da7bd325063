# SPDX-License-Identifier: Apache-2.0
"""How does the height of a survey change how well a source is placed? A campaign in Python.

python examples/campaign_heights.py config/campaigns/one_source.yaml

Every mission is planned, flown, measured and localised without processes: about a second of one
core each. ``rocsafe campaign`` does the same with a table, a page and a journal that survives.
"""

import sys
from collections import defaultdict
from pathlib import Path
from statistics import median

from rocsafe_campaign.design.campaign import read_campaign
from rocsafe_campaign.execution.local_workers import rows_here
from rocsafe_campaign.execution.one_run import Task
from rocsafe_campaign.results.row import COMPLETE

HEIGHT = 'survey.height_agl_m'


def main(file: str, workers: int = 2) -> dict[float, float]:
    """Fly the campaign; return the median error (m) at each height."""
    campaign = read_campaign(Path(file))
    errors = defaultdict(list)
    for row in rows_here(Task(campaign=campaign), campaign.runs(), workers):
        if row.outcome == COMPLETE and row.metrics.error_m is not None:
            errors[row.inputs[HEIGHT]].append(row.metrics.error_m)
    found = {height: median(values) for height, values in sorted(errors.items())}
    for height, error_m in found.items():
        print(f'{height:g} m above the ground: {error_m:.2f} m beside the source')
    return found


if __name__ == '__main__':
    main(*sys.argv[1:2])
