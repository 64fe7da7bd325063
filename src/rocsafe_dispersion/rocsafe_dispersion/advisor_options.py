# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``advisor``."""

from dataclasses import dataclass, field
from pathlib import Path

from rocsafe_dispersion.identification.procedures import SHIPPED


@dataclass(frozen=True, slots=True, kw_only=True)
class AdvisorOptions:
    """Options of the node ``advisor``."""

    vehicles: tuple[str, ...] = field(
        default=(), metadata={'doc': 'namespaces of the vehicles that carry gas sensors'}
    )
    procedures_directory: str = field(
        default='',
        metadata={
            'doc': 'folder of procedures in Markdown, used from when it is there; '
            'until then, or empty: the examples that are supplied'
        },
    )
    most_procedures: int = field(
        default=5, metadata={'doc': 'largest number of sections told', 'min': 1, 'max': 100}
    )
    period_s: float = field(
        default=5.0,
        metadata={
            'doc': 'least wall time between two pieces of advice, seconds',
            'min': 0.1,
            'max': 3600.0,
        },
    )
    spool_directory: str = field(
        default='',
        metadata={
            'doc': 'folder in which reports are kept, beside the readings of the estimator; '
            'empty: nowhere'
        },
    )

    def procedures(self) -> Path:
        """Return the folder of procedures that is there now."""
        own = Path(self.procedures_directory)
        return own if self.procedures_directory and own.is_dir() else SHIPPED
