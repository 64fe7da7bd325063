# SPDX-License-Identifier: Apache-2.0
"""Evidence points that releases of gas propose: `release.json`."""

import json
import math
from pathlib import Path
from typing import Any

from rocsafe_geo.position import GeoPosition
from rocsafe_ground.errors import NoMapError
from rocsafe_ground.evidence.evidence_point import RELEASE, EvidencePoint

LEAST_PRIORITY = 0.1


def found_releases(path: Path) -> list[EvidencePoint]:
    """Return a point for each release that a survey found, the stronger the higher its priority.

    Raises
    ------
    NoMapError
        If the file cannot be read.
    """
    try:
        document = json.loads(path.read_text(encoding='utf-8'))
        rows, agent = document['releases'], str(document['agent'])
        strongest = max((float(row['rate']) for row in rows), default=1.0)
        return [_point(row, number, strongest, agent) for number, row in enumerate(rows, 1)]
    except OSError as error:
        raise NoMapError(f'{path}: {error.strerror}') from error
    except (KeyError, TypeError, ValueError) as error:
        raise NoMapError(f'{path}: is no file of releases of ROCSAFE: {error!r}') from error


def _point(row: dict[str, Any], number: int, strongest: float, agent: str) -> EvidencePoint:
    rate, unit = float(row['rate']), str(row['rate_unit'])
    radius = math.sqrt(float(row['region_95_m2']) / math.pi)
    return EvidencePoint(
        id=f'release-{number}',
        position=GeoPosition(row['latitude_deg'], row['longitude_deg']),
        kind=RELEASE,
        priority=max(LEAST_PRIORITY, rate / strongest),
        found_in=f'release {number}: {rate:.3g} {unit} of {agent}, within {radius:.0f} m (95 %)',
    )
