# SPDX-License-Identifier: Apache-2.0
"""What was observed: reports of people, readings of detectors, a placard."""

from dataclasses import dataclass

from rocsafe_dispersion.identification.sensor_report import SensorReport
from rocsafe_dispersion.identification.signatures import signatures

UN_FIRST, UN_LAST = 4, 3999


@dataclass(frozen=True, slots=True, kw_only=True)
class Report:
    """Somebody's word on one observation.

    Attributes
    ----------
    observation
        Its name in the table of signatures.
    is_true
        Whether it was seen, smelled or found.
    witness
        Who says so.
    time
        When, in words or ISO 8601.
    place_deg
        Where: WGS84 latitude and longitude, degrees; None: unknown.
    """

    observation: str
    is_true: bool
    witness: str = ''
    time: str = ''
    place_deg: tuple[float, float] | None = None

    def __post_init__(self) -> None:
        signatures().column(self.observation)
        if self.place_deg is None:
            return
        for name, value, limit in zip(
            ('latitude_deg', 'longitude_deg'), self.place_deg, (90.0, 180.0), strict=True
        ):
            if not -limit <= value <= limit:
                raise ValueError(f'{name} = {value:g} must be between -{limit:g} and {limit:g}')


@dataclass(frozen=True, slots=True, kw_only=True)
class Evidence:
    """All that is known about a release.

    Attributes
    ----------
    reports
        Of people. Two reports of the same observation are taken as independent of each other.
    sensors
        Of detectors in the same air, one of each kind.
    un_number
        On a placard; None: none was read.
    """

    reports: tuple[Report, ...] = ()
    sensors: tuple[SensorReport, ...] = ()
    un_number: int | None = None

    @property
    def is_positive(self) -> bool:
        """Whether anything was seen, smelled, read or detected at all."""
        seen = [report.is_seen for report in self.sensors]
        said = [report.is_true for report in self.reports]
        return any((*seen, *said, self.un_number is not None))

    def __post_init__(self) -> None:
        kinds = [report.sensor for report in self.sensors]
        if len(set(kinds)) < len(kinds):
            raise ValueError('sensors: each kind may be given once, with its highest reading')
        if self.un_number is not None and not UN_FIRST <= self.un_number <= UN_LAST:
            raise ValueError(
                f'un_number = {self.un_number} must be between {UN_FIRST} and {UN_LAST}'
            )
