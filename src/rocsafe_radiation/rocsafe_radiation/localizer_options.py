# SPDX-License-Identifier: Apache-2.0
"""Options of the node ``localizer``."""

from collections.abc import Set
from dataclasses import dataclass
from typing import ClassVar

from rocsafe_geo.option import option
from rocsafe_geo.origin_options import OriginOptions
from rocsafe_geo.solids.ground_heights import read_heights
from rocsafe_radiation.decision.stopping import StoppingRule
from rocsafe_radiation.detection.detector import DETECTOR_NAMES, IDEAL, response_of
from rocsafe_radiation.detection.dosimeter import (
    DEFAULT_DOSE_RATES_USVH,
    DEFAULT_DOSES_USV,
    DEFAULT_TURN_BACK_USVH,
    DEFAULT_VEHICLE_BUDGET_USV,
    AlarmLevels,
)
from rocsafe_radiation.localization.estimates import METHODS, ML_METHOD
from rocsafe_radiation.localization.localize import LocalizationOptions
from rocsafe_radiation.localization.source_count import LARGEST_ORDER
from rocsafe_radiation.physics.field import AIR_MODEL, PAPER_MODEL
from rocsafe_radiation.physics.kernel import Kernel
from rocsafe_radiation.physics.nuclide import DEFAULT_NUCLIDE, nuclide
from rocsafe_radiation.products.assessment import AssessmentOptions
from rocsafe_radiation.products.cordon import DEFAULT_LEVELS_USVH
from rocsafe_radiation.readings.reading_log import ReadingLog

AUTO_MODEL = 'auto'
MODELS = (AUTO_MODEL, PAPER_MODEL, AIR_MODEL)


@dataclass(frozen=True, slots=True, kw_only=True)
class LocalizerOptions(OriginOptions):
    """Options of the localizer."""

    MOVED_PARAMETERS: ClassVar = {
        'terrain_provider': 'terrain_file',
        'terrain_seed': 'terrain_file',
        'terrain_latitudes_deg': 'terrain_shift_m',
        'terrain_longitudes_deg': 'terrain_shift_m',
        'terrain_altitudes_m': 'terrain_shift_m',
    }

    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles that carry a detector')
    model: str = option(
        AUTO_MODEL, 'law of the dose rate: paper, air, or auto: that of the readings'
    )
    nuclide: str = option(DEFAULT_NUCLIDE, 'nuclide whose photons air attenuates')
    detector: str = option(
        IDEAL,
        'kind of detector, which counts scattered photons, too: ' + ', '.join(DETECTOR_NAMES),
    )
    origin_latitude_deg: float = option(
        0.0, 'latitude of the mission origin, deg; 0, 0: the first reading', -90.0, 90.0
    )
    terrain_file: str = option(
        '', 'heights of the ground: GeoTIFF or file of rocsafe scene solids; empty: level'
    )
    terrain_shift_m: float = option(
        0.0, 'added to these heights so that they count from the ellipsoid, metres', -1e4, 1e4
    )
    source_height_m: float = option(
        0.5, 'expected height of sources above the ground, metres', -100.0
    )
    source_height_std_m: float = option(1.0, 'standard deviation of that height, metres', 0.0, 1e3)
    position_std_m: float = option(
        1.5, 'standard deviation of each coordinate of fixes, metres', 0.0, 100.0
    )
    sensitivity_cps_per_usvh: float = option(
        0.0, 'counts a second for 1 uSv/h; 0: from counts and dose rate of each reading', 0.0, 1e7
    )
    method: str = option(ML_METHOD, f'method to find sources: {", ".join(METHODS)}')
    false_alarm: float = option(
        0.01, 'probability of deciding for a source that is not there', 1e-6, 0.49
    )
    missed: float = option(
        0.01, 'probability of deciding against a source that is there', 1e-6, 0.49
    )
    ellipse_95_m: float = option(
        5.0, 'longest half axis of a 95 % ellipse that is precise enough, metres', 1e-3, 1e4
    )
    smallest_source_usvh: float = option(
        92.0,
        'dose rate at 1 m of the weakest source that matters, uSv/h: 1 GBq of Cs-137',
        1e-3,
        1e9,
    )
    cordon_levels_usvh: tuple[float, ...] = option(
        DEFAULT_LEVELS_USVH, 'dose rates of cordons at 1 m, uSv/h; 100: inner cordon of the IAEA'
    )
    alarm_dose_rates_usvh: tuple[float, ...] = option(
        DEFAULT_DOSE_RATES_USVH, 'dose rates of alarms of vehicles, uSv/h; 100000: turn back'
    )
    alarm_doses_usv: tuple[float, ...] = option(
        DEFAULT_DOSES_USV, 'doses of alarms of vehicles, uSv; 1000: a year of the public'
    )
    turn_back_usvh: float = option(
        DEFAULT_TURN_BACK_USVH,
        'dose rate at which a vehicle is to return, uSv/h; 0: never',
        0.0,
        1e12,
    )
    vehicle_budget_usv: float = option(
        DEFAULT_VEHICLE_BUDGET_USV,
        'dose at which a vehicle is to return, uSv; 0: never',
        0.0,
        1e12,
    )
    largest_gap_s: float = option(
        5.0, 'longest time between readings over which a dose is added, seconds', 0.0, 3600.0
    )
    spool_directory: str = option(
        '', 'where readings are kept for a restart; empty: in memory only'
    )
    export_directory: str = option(
        '', 'folder for sources and dose map after each fit; empty: none'
    )
    largest_order: int = option(LARGEST_ORDER, 'most sources looked for', 0, LARGEST_ORDER)
    period_s: float = option(5.0, 'wall time between two fits, seconds', 0.1, 3600.0)

    def __post_init__(self) -> None:
        if self.model not in MODELS:
            raise ValueError(f'model = {self.model!r} must be one of: {", ".join(MODELS)}')
        nuclide(self.nuclide)
        self.origin()
        self.levels()
        self.assessment(frozenset())
        if len(set(self.vehicles)) < len(self.vehicles) or '' in self.vehicles:
            raise ValueError(f'vehicles = {list(self.vehicles)} must be named, all differently')

    def log(self) -> ReadingLog:
        """Return an empty log of readings.

        Raises
        ------
        ValueError
            In one line, if the origin or the terrain is wrong.
        """
        file = self.terrain_file
        heights = read_heights(file, self.terrain_shift_m) if file else None
        return ReadingLog(self.origin(), self.sensitivity_cps_per_usvh, heights)

    def levels(self) -> AlarmLevels:
        """Return the levels of alarms.

        Raises
        ------
        ValueError
            Naming the level that is not valid.
        """
        return AlarmLevels(
            dose_rates_usvh=self.alarm_dose_rates_usvh,
            doses_usv=self.alarm_doses_usv,
            turn_back_usvh=self.turn_back_usvh,
            vehicle_budget_usv=self.vehicle_budget_usv,
            largest_gap_s=self.largest_gap_s,
        )

    def assessment(self, models: Set[str]) -> AssessmentOptions:
        """Return the options by which readings of the laws `models` are assessed."""
        is_paper = self.model == PAPER_MODEL or (
            self.model == AUTO_MODEL and models == {PAPER_MODEL}
        )
        known = LocalizationOptions(
            kernel=Kernel(
                is_lossy=not is_paper,
                nuclide=self.nuclide,
                response=response_of(self.detector),
            ),
            source_up_m=self.source_height_m,
            source_up_std_m=self.source_height_std_m,
            position_std_m=self.position_std_m,
            largest_order=self.largest_order,
        )
        rule = StoppingRule(
            false_alarm=self.false_alarm,
            missed=self.missed,
            ellipse_95_m=self.ellipse_95_m,
            smallest_usvh=self.smallest_source_usvh,
        )
        return AssessmentOptions(
            known=known, method=self.method, rule=rule, levels_usvh=self.cordon_levels_usvh
        )
