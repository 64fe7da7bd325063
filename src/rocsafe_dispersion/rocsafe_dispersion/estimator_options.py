# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``estimator``."""

from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import yaml

from rocsafe_dispersion.atmosphere.stability import CLASSES, StabilityClass
from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_dispersion.mission_gas.gas_log import GasLog, Sampling
from rocsafe_dispersion.mission_gas.release_assessment import AssessmentOptions
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_geo.origin_options import OriginOptions


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatorOptions(OriginOptions):
    """Options of the node ``estimator``, which is not told of the releases."""

    vehicles: tuple[str, ...] = field(
        default=(), metadata={'doc': 'namespaces of the vehicles that carry gas sensors'}
    )
    agent: str = field(
        default='',
        metadata={'doc': 'chemical that is released; empty: that which the sensor is made for'},
    )
    stability: str = field(
        default='D', metadata={'doc': f'Pasquill class of the air: {", ".join(CLASSES)}'}
    )
    roughness_m: float = field(
        default=0.03,
        metadata={'doc': 'roughness length of the ground, metres', 'min': 1e-3, 'max': 0.5},
    )
    release_height_m: float = field(
        default=1.0,
        metadata={'doc': 'height of releases above the ground, metres', 'min': 0.0, 'max': 30.0},
    )
    dilution: float = field(
        default=0.7,
        metadata={'doc': 'share of the gas that arrives at the sensors', 'min': 0.01, 'max': 1.0},
    )
    intake_delay_s: float = field(
        default=1.0,
        metadata={'doc': 'time that air takes to the sensors, seconds', 'min': 0.0, 'max': 60.0},
    )
    smallest_g_s: float = field(
        default=0.5,
        metadata={'doc': 'weakest release that matters, g/s', 'min': 1e-9, 'max': 1e9},
    )
    region_m: float = field(
        default=10.0,
        metadata={
            'doc': 'radius of a region of 95 % that is precise enough, metres',
            'min': 0.1,
            'max': 1e4,
        },
    )
    hidden_share: float = field(
        default=0.05,
        metadata={
            'doc': 'share of the ground where the weakest release may remain unseen',
            'min': 1e-3,
            'max': 0.9,
        },
    )
    period_s: float = field(
        default=5.0,
        metadata={'doc': 'wall time between two estimates, seconds', 'min': 0.1, 'max': 3600.0},
    )
    spool_directory: str = field(
        default='', metadata={'doc': 'folder in which readings are kept; empty: nowhere'}
    )

    def __post_init__(self) -> None:
        if self.stability not in CLASSES:
            raise ValueError(
                f'stability = {self.stability!r} must be one of: {", ".join(CLASSES)}'
            )

    def log(self) -> GasLog:
        """Return an empty log of readings."""
        sampling = Sampling(dilution=self.dilution, delay_s=self.intake_delay_s, agent=self.agent)
        return GasLog(self.frame(), sampling)

    def assessment(self) -> AssessmentOptions:
        """Return how readings are assessed."""
        stability: StabilityClass = next(one for one in CLASSES if one == self.stability)
        return AssessmentOptions(
            stability=stability,
            roughness_m=self.roughness_m,
            release_height_m=self.release_height_m,
            locate=replace(LocateOptions(), smallest_g_s=self.smallest_g_s),
            rule=ReleaseRule(region_m=self.region_m, hidden_share=self.hidden_share),
        )


def estimator_options(path: Path) -> EstimatorOptions:
    """Return the options of a flown ``estimator`` from its ROS parameter file.

    Raises
    ------
    ValueError
        If it is not the parameter file of an estimator.
    """
    try:
        content = yaml.safe_load(path.read_text(encoding='utf-8'))
        values = content['/estimator']['ros__parameters']
        given: dict[str, Any] = {
            key: tuple(value) if isinstance(value, list) else value
            for key, value in values.items()
        }
        return EstimatorOptions(**given)
    except (OSError, UnicodeDecodeError, yaml.YAMLError, KeyError, TypeError, AttributeError) as e:
        raise ValueError(f'{path}: is no parameter file of an estimator: {e}') from e
