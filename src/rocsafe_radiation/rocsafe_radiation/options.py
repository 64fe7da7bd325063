# SPDX-License-Identifier: Apache-2.0
"""Options of the nodes of this package."""

from dataclasses import dataclass, field

from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.field import MODELS, PAPER_MODEL, SMALLEST_SOURCE_RADIUS_M, RadiationField
from rocsafe_radiation.source import RadiationSource

GROUND_TRUTH = 'ground_truth'
FIX = 'fix'
POSITION_SOURCES = (GROUND_TRUTH, FIX)


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldOptions:
    """Options of the field node; the source lists run in parallel."""

    model: str = field(
        default=PAPER_MODEL, metadata={'doc': 'law of the dose rate; paper: sigma / d^2'}
    )
    vehicles: tuple[str, ...] = field(
        default=(), metadata={'doc': 'namespaces of the vehicles that carry a detector'}
    )
    source_names: tuple[str, ...] = field(
        default=(), metadata={'doc': 'names of the sources, all different'}
    )
    source_latitudes_deg: tuple[float, ...] = field(
        default=(), metadata={'doc': 'WGS84 latitudes of the sources, degrees'}
    )
    source_longitudes_deg: tuple[float, ...] = field(
        default=(), metadata={'doc': 'WGS84 longitudes of the sources, degrees'}
    )
    source_altitudes_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'altitudes of the sources above the ellipsoid, metres'}
    )
    source_sigmas_usvps: tuple[float, ...] = field(
        default=(), metadata={'doc': 'dose rates of the sources at 1 m, microsievert per second'}
    )
    source_radius_m: float = field(
        default=0.1,
        metadata={
            'doc': 'distance below which the dose rate grows no further, metres',
            'min': SMALLEST_SOURCE_RADIUS_M,
            'max': 1e3,
        },
    )
    position_source: str = field(
        default=GROUND_TRUTH,
        metadata={'doc': 'where a dose rate is taken: at the ground_truth or at the fix'},
    )
    lock_step: bool = field(
        default=True, metadata={'doc': 'take part in lock-step simulation as radiation_field'}
    )

    def __post_init__(self) -> None:
        _require_choice('model', self.model, MODELS)
        _require_choice('position_source', self.position_source, POSITION_SOURCES)
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')
        for name in ('latitudes_deg', 'longitudes_deg', 'altitudes_m', 'sigmas_usvps'):
            count = len(getattr(self, f'source_{name}'))
            if count != len(self.source_names):
                raise ValueError(
                    f'source_{name} has {count} values, but source_names has '
                    f'{len(self.source_names)}'
                )
        self.radiation_field()

    def radiation_field(self) -> RadiationField:
        """Return the field of the sources described.

        Raises
        ------
        ValueError: naming the source, the value and the limit.
        """
        sources = tuple(self._source(index) for index in range(len(self.source_names)))
        return RadiationField(sources=sources, source_radius_m=self.source_radius_m)

    def _source(self, index: int) -> RadiationSource:
        name = self.source_names[index]
        try:
            position = GeoPosition(
                latitude_deg=self.source_latitudes_deg[index],
                longitude_deg=self.source_longitudes_deg[index],
                altitude_m=self.source_altitudes_m[index],
            )
        except ValueError as error:
            raise ValueError(f'source {name}: {error}') from error
        return RadiationSource(
            name=name, position=position, sigma_usvps=self.source_sigmas_usvps[index]
        )


def _require_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f'{name} = {value!r} must be one of: {", ".join(choices)}')
