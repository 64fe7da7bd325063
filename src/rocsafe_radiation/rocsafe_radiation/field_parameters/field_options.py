# SPDX-License-Identifier: Apache-2.0
"""Options of the nodes of this package."""

from dataclasses import dataclass, field

from rocsafe_radiation.detection.detector import DETECTOR_NAMES, IDEAL
from rocsafe_radiation.detection.survey_field import SurveyField
from rocsafe_radiation.field_parameters.field_assembly import (
    SHAPES,
    TRACK,
    SourceLists,
    places_of,
    sources_of,
)
from rocsafe_radiation.field_parameters.shield_options import ShieldOptions
from rocsafe_radiation.physics.background import Background
from rocsafe_radiation.physics.field import (
    MODELS,
    PAPER_MODEL,
    SHIELDED_MODEL,
    SMALLEST_SOURCE_RADIUS_M,
    RadiationField,
)

GROUND_TRUTH = 'ground_truth'
FIX = 'fix'
POSITION_SOURCES = (GROUND_TRUTH, FIX)
# Parallel lists by what they describe: that which says how many there are, those that must be as
# long, those that may also be empty.
PARALLEL_LISTS = {
    'source_names': (
        ('latitudes_deg', 'longitudes_deg', 'altitudes_m', 'sigmas_usvps'),
        ('nuclides', 'activities_gbq', 'ages_s', 'shapes', 'corner_counts'),
    ),
    'corner_latitudes_deg': (('longitudes_deg', 'altitudes_m'), ('times_s',)),
    'box_materials': (
        ('latitudes_deg', 'longitudes_deg', 'altitudes_m', 'lengths_m', 'widths_m', 'heights_m'),
        ('headings_deg', 'walls_m'),
    ),
}


@dataclass(frozen=True, slots=True, kw_only=True)
class FieldOptions(ShieldOptions):
    """Options of the field node; the source lists run in parallel."""

    model: str = field(
        default=PAPER_MODEL,
        metadata={
            'doc': 'law of the dose rate; paper: sigma / d^2, air: attenuated, '
            'shielded: behind boxes and things of a scene, too'
        },
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
    source_shapes: tuple[str, ...] = field(
        default=(),
        metadata={'doc': f'shapes of the sources: {", ".join(SHAPES)}; none: all points'},
    )
    source_corner_counts: tuple[int, ...] = field(
        default=(), metadata={'doc': 'how many corners describe each source that is no point'}
    )
    corner_latitudes_deg: tuple[float, ...] = field(
        default=(),
        metadata={'doc': 'WGS84 latitudes of all corners, source after source, degrees'},
    )
    corner_longitudes_deg: tuple[float, ...] = field(
        default=(), metadata={'doc': 'WGS84 longitudes of the corners, degrees'}
    )
    corner_altitudes_m: tuple[float, ...] = field(
        default=(), metadata={'doc': 'altitudes of the corners above the ellipsoid, metres'}
    )
    corner_times_s: tuple[float, ...] = field(
        default=(),
        metadata={'doc': 'when a track is at its corner, seconds after start_time_s; others: 0'},
    )
    start_time_s: float = field(
        default=0.0,
        metadata={
            'doc': 'start of the mission, seconds since 1970; tracks count from it',
            'min': 0.0,
        },
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
    background_cosmic: bool = field(
        default=True,
        metadata={'doc': 'cosmic rays, which grow with altitude, are part of a background'},
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
    vehicles_at_their_fix: tuple[str, ...] = field(
        default=(),
        metadata={'doc': 'vehicles of which nobody publishes the truth: real ones'},
    )
    lock_step: bool = field(
        default=True, metadata={'doc': 'take part in lock-step simulation as radiation_field'}
    )

    def __post_init__(self) -> None:
        _require_choice('model', self.model, MODELS)
        _require_choice('detector', self.detector, DETECTOR_NAMES)
        _require_choice('position_source', self.position_source, POSITION_SOURCES)
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')
        for leader, (required, optional) in PARALLEL_LISTS.items():
            prefix = leader.partition('_')[0]
            for name in (*required, *optional):
                self._require_parallel(leader, f'{prefix}_{name}', may_be_empty=name in optional)
        if TRACK in self.source_shapes and not self.corner_times_s:
            raise ValueError('corner_times_s must be given with a track')
        self.survey_field()

    def uses_truth(self, vehicle: str) -> bool:
        """Whether the dose rates of `vehicle` are those at its true place."""
        is_real = vehicle in self.vehicles_at_their_fix
        return self.position_source == GROUND_TRUTH and not is_real

    def _require_parallel(self, leader: str, name: str, *, may_be_empty: bool) -> None:
        count, wanted = len(getattr(self, name)), len(getattr(self, leader))
        if count != wanted and (count or not may_be_empty):
            raise ValueError(f'{name} has {count} values, but {leader} has {wanted}')

    @property
    def start_time_ns(self) -> int:
        """Start of the mission, nanoseconds since 1970."""
        return round(self.start_time_s * 1e9)

    def survey_field(self) -> SurveyField:
        """Return sources, shields, background and detector described.

        Raises
        ------
        ValueError: naming the source or box, the value and the limit.
        """
        return SurveyField(
            field=RadiationField(
                sources=sources_of(self._source_lists()),
                source_radius_m=self.source_radius_m,
                model=self.model,
                shielding=self.shield(self.seed) if self.model == SHIELDED_MODEL else None,
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
            is_cosmic=self.background_cosmic,
            seed=self.seed,
            ground=self.heights(),
        )

    def _source_lists(self) -> SourceLists:
        return SourceLists(
            names=self.source_names,
            places=self.on_ground(
                places_of(
                    [f'source {name}' for name in self.source_names],
                    self.source_latitudes_deg,
                    self.source_longitudes_deg,
                    self.source_altitudes_m,
                )
            ),
            sigmas_usvps=self.source_sigmas_usvps,
            nuclides=self.source_nuclides,
            activities_gbq=self.source_activities_gbq,
            ages_s=self.source_ages_s,
            shapes=self.source_shapes,
            corner_counts=self.source_corner_counts,
            corners=self.on_ground(
                places_of(
                    [f'corner {index}' for index in range(len(self.corner_latitudes_deg))],
                    self.corner_latitudes_deg,
                    self.corner_longitudes_deg,
                    self.corner_altitudes_m,
                )
            ),
            corner_times_s=self.corner_times_s,
        )


def _require_choice(name: str, value: str, choices: tuple[str, ...]) -> None:
    if value not in choices:
        raise ValueError(f'{name} = {value!r} must be one of: {", ".join(choices)}')
