# SPDX-License-Identifier: Apache-2.0
"""The row of a run in the table of its campaign."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from rocsafe_campaign.results.metrics import METRICS, Metrics
from rocsafe_geo.storage.json_values import finite

COMPLETE, FAILED, FAULT = 'complete', 'failed', 'fault'


@dataclass(frozen=True, slots=True, kw_only=True)
class Row:
    """The result of a run.

    Attributes
    ----------
    key
        Hash of all that it depends on.
    outcome, text
        ``complete``; ``failed`` with the reason; ``fault`` with an error of the software.
    metrics
        Figures of a complete run.
    cpu_s
        CPU time that it took, which is no result.
    """

    number: int
    key: str
    seed: int
    repeat: int
    inputs: Mapping[str, Any]
    outcome: str
    text: str = ''
    metrics: Metrics = dataclasses.field(default_factory=Metrics)
    cpu_s: float = 0.0

    def to_plain(self) -> dict[str, Any]:
        """Return values that JSON can hold; unknown figures become None."""
        return dict(finite(dataclasses.asdict(self)))

    @classmethod
    def of_plain(cls, content: Mapping[str, Any]) -> 'Row':
        """Return the row that `to_plain` gave."""
        known = {name: content['metrics'][name] for name in METRICS}
        metrics = Metrics(**{k: v for k, v in known.items() if v is not None})
        return cls(**{**content, 'metrics': metrics})
