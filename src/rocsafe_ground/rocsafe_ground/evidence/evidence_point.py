# SPDX-License-Identifier: Apache-2.0
"""A place at which a ground vehicle takes evidence."""

from dataclasses import dataclass

from rocsafe_geo.limits import require_between
from rocsafe_geo.position import GeoPosition

SOURCE, RELEASE, OBJECT, MARK = 'source', 'release', 'object', 'mark'
# How far from the place the vehicle may stand, metres: sources are photographed from afar, where
# the dose rate is lowest; a mark is where somebody wants the vehicle.
REACH_M = {SOURCE: 15.0, RELEASE: 15.0, OBJECT: 5.0, MARK: 2.0}
DEFAULT_DWELL_S = 30.0


@dataclass(frozen=True, slots=True, kw_only=True)
class EvidencePoint:
    """A place at which evidence is taken.

    Attributes
    ----------
    id
        Unique within a mission.
    position
        Of the evidence.
    kind
        One of `REACH_M`.
    priority
        Weight against the other points.
    dwell_s
        How long the vehicle stands there.
    found_in
        What it comes from: a photograph, label, source or reading; empty: an operator.
    """

    id: str
    position: GeoPosition
    kind: str = MARK
    priority: float = 1.0
    dwell_s: float = DEFAULT_DWELL_S
    found_in: str = ''

    def __post_init__(self) -> None:
        if not self.id:
            raise ValueError('id is empty: must name the evidence point')
        if self.kind not in REACH_M:
            raise ValueError(f'kind = {self.kind!r} must be one of: {", ".join(REACH_M)}')
        require_between('priority', self.priority, 1e-3, 1e3)
        require_between('dwell_s', self.dwell_s, 0.0, 3600.0, 's')

    @property
    def reach_m(self) -> float:
        """How far from the place the vehicle may stand."""
        return REACH_M[self.kind]
