# SPDX-License-Identifier: Apache-2.0
"""ROS parameters of the node ``estimator``."""

from dataclasses import dataclass
from pathlib import Path

from rocsafe_dispersion.estimation.release_options import LocateOptions
from rocsafe_dispersion.mission_gas.gas_log import GasLog, Sampling
from rocsafe_dispersion.mission_gas.release_assessment import AssessmentOptions
from rocsafe_dispersion.mission_gas.stopping import ReleaseRule
from rocsafe_dispersion.plume.losses import Losses
from rocsafe_geo.option import option
from rocsafe_geo.origin_options import OriginOptions
from rocsafe_geo.storage.value_file import values_of
from rocsafe_geo.storage.yaml_source import read_yaml
from rocsafe_geo.wind.stability import CLASSES, StabilityClass


@dataclass(frozen=True, slots=True, kw_only=True)
class EstimatorOptions(OriginOptions):
    """Options of the node ``estimator``, which is not told of the releases."""

    vehicles: tuple[str, ...] = option((), 'namespaces of the vehicles that carry gas sensors')
    agent: str = option(
        '', 'what is released: a chemical or particles; empty: what the sensor is made for'
    )
    stability: str = option('D', f'Pasquill class of the air: {", ".join(CLASSES)}')
    roughness_m: float = option(0.03, 'roughness length of the ground, metres', 1e-3, 0.5)
    release_height_m: float = option(1.0, 'height of releases above the ground, metres', 0.0, 30.0)
    dilution: float = option(0.7, 'share of the gas that arrives at the sensors', 0.01, 1.0)
    intake_delay_s: float = option(1.0, 'time that air takes to the sensors, seconds', 0.0, 60.0)
    smallest_g_s: float = option(0.5, 'weakest release that matters, g/s', 1e-9, 1e9)
    smallest_per_s: float = option(1e8, 'the same of particles, particles/s', 1.0, 1e15)
    settling_mps: float = option(0.0, 'speed at which what is released falls, m/s', 0.0, 10.0)
    decay_per_s: float = option(0.0, 'share of it that decays in a second, 1/s', 0.0, 1.0)
    region_m: float = option(
        10.0, 'radius of a region of 95 % that is precise enough, metres', 0.1, 1e4
    )
    hidden_share: float = option(
        0.05, 'share of the ground where the weakest release may remain unseen', 1e-3, 0.9
    )
    period_s: float = option(5.0, 'wall time between two estimates, seconds', 0.1, 3600.0)
    spool_directory: str = option('', 'folder in which readings are kept; empty: nowhere')
    export_directory: str = option(
        '', 'folder for plume.tif and threat_zones.geojson of each estimate; empty: none'
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
            losses=Losses(settling_mps=self.settling_mps, decay_per_s=self.decay_per_s),
            locate=LocateOptions(
                smallest_g_s=self.smallest_g_s, smallest_per_s=self.smallest_per_s
            ),
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
        values = read_yaml(path)['/estimator']['ros__parameters']
        return values_of(values, EstimatorOptions, 'parameter')
    except (KeyError, TypeError, ValueError) as error:
        reason = str(error).partition('\n')[0]
        raise ValueError(f'{path}: is no parameter file of an estimator: {reason}') from error
