# SPDX-License-Identifier: Apache-2.0
"""Options of the nodes of this package."""

from dataclasses import dataclass, field
from typing import TypeVar

from rocsafe_geo.position import GeoPosition
from rocsafe_radiation.background import Background
from rocsafe_radiation.detector import DETECTOR_NAMES, IDEAL
from rocsafe_radiation.field import (
    AIR_MODEL,
    PAPER_MODEL,
    SMALLEST_SOURCE_RADIUS_M,
    RadiationField,
)
from rocsafe_radiation.nuclide import DEFAULT_NUCLIDE
from rocsafe_radiation.source import RadiationSource, decayed_sigma_usvps
from rocsafe_radiation.survey_field import SurveyField

Value = TypeVar('Value')
GROUND_TRUTH = 'ground_truth'
FIX = 'fix'
POSITION_SOURCES = (GROUND_TRUTH, FIX)
# Models of which a node knows all that they need.
NODE_MODELS = (PAPER_MODEL, AIR_MODEL)
REQUIRED_LISTS = ('latitudes_deg', 'longitudes_deg', 'altitudes_m', 'sigmas_usvps')
OPTIONAL_LISTS = ('nuclides', 'activities_gbq', 'ages_s')


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldOptions:
    """Options of the field node; the source lists run in parallel."""

    model: str = field(
        default=PAPER_MODEL,
        metadata={'doc': 'law of the dose rate; paper: sigma / d^2, air: with attenuation'},
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
        default=(),
        metadata={
            'doc': 'dose rates of the sources at 1 m, microsievert per second; 0: by activity'
        },
    )
    source_nuclides: tuple[str, ...] = field(
        default=(), metadata={'doc': 'nuclides of the sources, for instance Cs-137; none: Cs-137'}
    )
    source_activities_gbq: tuple[float, ...] = field(
        default=(), metadata={'doc': 'activities of the sources without a dose rate, GBq'}
    )
    source_ages_s: tuple[float, ...] = field(
        default=(), metadata={'doc': 'seconds for which the activities have decayed'}
    )
    source_radius_m: float = field(
        default=0.1,
        metadata={
            'doc': 'distance below which the dose rate grows no further, metres',
            'min': SMALLEST_SOURCE_RADIUS_M,
            'max': 1e3,
        },
    )
    background_usvh: float = field(
        default=0.0,
        metadata={
            'doc': 'mean terrestrial dose rate at the ground, uSv/h; 0: no background at all',
            'min': 0.0,
            'max': 1e6,
        },
    )
    background_variation: float = field(
        default=0.0,
        metadata={
            'doc': 'standard deviation of the logarithm of the background from place to place',
            'min': 0.0,
            'max': 2.0,
        },
    )
    background_length_m: float = field(
        default=60.0,
        metadata={'doc': 'over which the background varies, metres', 'min': 1.0, 'max': 1e5},
    )
    ground_altitude_m: float = field(
        default=0.0,
        metadata={'doc': 'altitude of the ground above the ellipsoid, metres', 'max': 1e4},
    )
    detector: str = field(
        default=IDEAL,
        metadata={'doc': f'kind of detector: {", ".join(DETECTOR_NAMES)}'},
    )
    window_s: float = field(
        default=1.0,
        metadata={
            'doc': 'time over which a detector counts, seconds; the ideal one has none',
            'min': 1e-3,
            'max': 3600.0,
        },
    )
    seed: int = field(
        default=0,
        metadata={'doc': 'seed of counts and background', 'min': 0, 'max': 2**31 - 1},
    )
    position_source: str = field(
        default=GROUND_TRUTH,
        metadata={'doc': 'where a dose rate is taken: at the ground_truth or at the fix'},
    )
    lock_step: bool = field(
        default=True, metadata={'doc': 'take part in lock-step simulation as radiation_field'}
    )

    def __post_init__(self) -> None:
        _require_choice('model', self.model, NODE_MODELS)
        _require_choice('detector', self.detector, DETECTOR_NAMES)
        _require_choice('position_source', self.position_source, POSITION_SOURCES)
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')
        for name in (*REQUIRED_LISTS, *OPTIONAL_LISTS):
            self._require_parallel(name)
        self.survey_field()

    def _require_parallel(self, name: str) -> None:
        count = len(getattr(self, f'source_{name}'))
        if count != len(self.source_names) and (count or name in REQUIRED_LISTS):
            raise ValueError(
                f'source_{name} has {count} values, but source_names has {len(self.source_names)}'
            )

    def survey_field(self) -> SurveyField:
        """Return sources, background and detector described.

        Raises
        ------
        ValueError: naming the source, the value and the limit.
        """
        sources = tuple(self._source(index) for index in range(len(self.source_names)))
        return SurveyField(
            field=RadiationField(
                sources=sources, source_radius_m=self.source_radius_m, model=self.model
            ),
            background=self._background(),
            detector=self.detector,
        )

    def _background(self) -> Background:
        if self.background_usvh == 0.0:
            return Background()
        return Background(
            terrestrial_usvh=self.background_usvh,
            variation=self.background_variation,
            length_m=self.background_length_m,
            ground_altitude_m=self.ground_altitude_m,
            is_cosmic=True,
            seed=self.seed,
        )

    def _source(self, index: int) -> RadiationSource:
        name = self.source_names[index]
        nuclide = _entry(self.source_nuclides, index, '') or DEFAULT_NUCLIDE
        try:
            position = GeoPosition(
                latitude_deg=self.source_latitudes_deg[index],
                longitude_deg=self.source_longitudes_deg[index],
                altitude_m=self.source_altitudes_m[index],
            )
        except ValueError as error:
            raise ValueError(f'source {name}: {error}') from error
        sigma_usvps = self.source_sigmas_usvps[index]
        if sigma_usvps == 0.0 and self.source_activities_gbq:
            activity_gbq = self.source_activities_gbq[index]
            age_s = _entry(self.source_ages_s, index, 0.0)
            sigma_usvps = decayed_sigma_usvps(name, nuclide, activity_gbq, age_s)
        return RadiationSource(
            name=name, position=position, sigma_usvps=sigma_usvps, nuclide=nuclide
        )


def _entry(values: tuple[Value, ...], index: int, default: Value) -> Value:
    return values[index] if values else default


def _require_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f'{name} = {value!r} must be one of: {", ".join(choices)}')
