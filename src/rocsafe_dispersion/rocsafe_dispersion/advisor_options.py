# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``advisor``."""

from dataclasses import dataclass
from pathlib import Path

from rocsafe_dispersion.identification.procedures import SHIPPED
from rocsafe_geo.option import option


@dataclass(frozen=True, slots=True, kw_only=True)
class AdvisorOptions:
    """Options of the node ``advisor``."""

    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles that carry gas sensors')
    procedures_directory: str = option(
        '',
        'folder of procedures in Markdown, used from when it is there; '
        'until then, or empty: the examples that are supplied',
    )
    most_procedures: int = option(5, 'largest number of sections told', 1, 100)
    period_s: float = option(
        5.0, 'least wall time between two pieces of advice, seconds', 0.1, 3600.0
    )
    spool_directory: str = option(
        '',
        'folder in which reports are kept, beside the readings of the estimator; empty: nowhere',
    )

    def procedures(self) -> Path:
        """Return the folder of procedures that is there now."""
        own = Path(self.procedures_directory)
        return own if self.procedures_directory and own.is_dir() else SHIPPED
