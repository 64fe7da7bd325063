# SPDX-License-Identifier: Apache-2.0
"""A finished run: values as read from its files."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from rocsafe_geo.arrays import FloatArray
from rocsafe_geo.pinhole import PinholeCamera
from rocsafe_geo.position import GeoPosition
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.products.agent_advice import AgentAdvice
from rocsafe_orchestrator.products.release_estimates import ReleaseEstimates
from rocsafe_orchestrator.products.source_estimates import SourceEstimates
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_scenario.scenario import Scenario

IntArray = NDArray[np.int64]
# States of VehicleState.msg in which a vehicle is in the air.
AIRBORNE_STATES = frozenset({3, 4, 5, 6, 7})
STATE_NAMES = (
    'unknown', 'disarmed', 'armed', 'taking off', 'flying', 'holding', 'returning', 'landing',
    'landed', 'lost', 'crashed', 'waiting',
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Reading:
    """One dose-rate reading; the fields mean what those of ``RadiationReading.msg`` do."""

    time_ns: int
    vehicle: str
    latitude_deg: float
    longitude_deg: float
    altitude_m: float
    dose_rate_usvh: float
    dose_rate_std_usvh: float
    counts: int
    live_time_s: float
    model: str
    saturated: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class GasSample:
    """One reading of a gas sensor; the fields mean what those of ``GasReading.msg`` do."""

    time_ns: int
    vehicle: str
    sensor: str
    unit: str
    raw: float
    limit: float
    saturated: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class ParticleSample:
    """One window of a particle counter; the fields mean what those of ``ParticleReading.msg`` do.

    The position is NaN where the vehicle did not know it.
    """

    time_ns: int
    vehicle: str
    fluorescent: int
    particles_per_l: float
    triggered: bool
    latitude_deg: float
    longitude_deg: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Track:
    """Places of a vehicle over time.

    Attributes
    ----------
    time_ns
        Shape (n,), increasing.
    latitude_deg, longitude_deg, altitude_m
        Shape (n,), WGS84, above the ellipsoid.
    is_truth
        Whether these are the true positions of a simulated vehicle, not its fixes.
    """

    time_ns: IntArray
    latitude_deg: FloatArray
    longitude_deg: FloatArray
    altitude_m: FloatArray
    is_truth: bool


@dataclass(frozen=True, slots=True, kw_only=True)
class VehicleSample:
    """A vehicle's state at a time; the fields mean what those of ``VehicleState.msg`` do."""

    time_ns: int
    state: int
    plan_id: str
    viewpoint_count: int
    viewpoints_visited: int
    shots_taken: int
    battery_fraction: float
    distance_flown_m: float
    text: str
    taken_by: str = ''

    @property
    def is_airborne(self) -> bool:
        """Whether the vehicle is off the ground."""
        return self.state in AIRBORNE_STATES


@dataclass(frozen=True, slots=True, kw_only=True)
class MissionSample:
    """The mission at a time; the fields mean what those of ``MissionState.msg`` do."""

    phase: Phase
    text: str
    images_stored: int
    images_expected: int
    mission_time_s: float
    wall_time_s: float


@dataclass(frozen=True, slots=True, kw_only=True)
class Alarm:
    """A level of dose rate or dose that a vehicle reached or left, as in ``DoseAlarm.msg``."""

    time_ns: int
    vehicle: str
    is_reached: bool
    is_dose: bool
    threshold_usv: float
    value_usv: float
    name: str
    turns_back: bool = False


@dataclass(frozen=True, slots=True, kw_only=True)
class Notice:
    """A single report of a node: a decision, or an event of a vehicle.

    Attributes
    ----------
    time_ns
        Stamp; 0: before the vehicles were heard.
    severity
        0 for information, 1 for a warning, 2 for an error.
    vehicles
        Vehicles that it is about; empty: the mission.
    """

    time_ns: int
    severity: int
    kind: str
    by: str
    vehicles: tuple[str, ...]
    text: str
    reason: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class AgentSample:
    """What an agent knew at a time; the fields mean what those of ``AgentState.msg`` do."""

    time_ns: int
    vehicle: str
    epoch: int
    coordinator: str
    heard: tuple[str, ...]
    members: tuple[str, ...]
    unable: tuple[str, ...]
    duplicates: int
    bytes_sent: int
    alarms: int
    search_round: int = 0
    search_by: str = ''
    search_places: int = 0
    search_text: str = ''


@dataclass(frozen=True, slots=True, kw_only=True)
class Aim:
    """What a photograph shows: `orientation_xyzw` takes the optical frame to east, north, up."""

    camera: PinholeCamera
    height_agl_m: float
    orientation_xyzw: tuple[float, ...]


@dataclass(frozen=True, slots=True, kw_only=True)
class Photograph:
    """A stored photograph; `path` is that of its JPEG file, `position` the camera's.

    `aim` is None where the record does not tell it.
    """

    shot_id: str
    vehicle: str
    viewpoint_id: int
    time_ns: int
    position: GeoPosition
    path: Path
    aim: Aim | None = None


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordingFacts:
    """Number of messages of the recording, and its start."""

    message_count: int
    start_ns: int


@dataclass(frozen=True, slots=True, kw_only=True)
class FlightLog:
    """The content of the recording of a run."""

    facts: RecordingFacts
    readings: tuple[Reading, ...] = ()
    gases: tuple[GasSample, ...] = ()
    particles: tuple[ParticleSample, ...] = ()
    tracks: Mapping[str, Track] = field(default_factory=dict)
    samples: Mapping[str, tuple[VehicleSample, ...]] = field(default_factory=dict)
    mission: tuple[MissionSample, ...] = ()
    alarms: tuple[Alarm, ...] = ()
    notices: tuple[Notice, ...] = ()
    agents: tuple[AgentSample, ...] = ()


@dataclass(frozen=True, slots=True, kw_only=True)
class RunRecord:
    """The content of the files of a run; None or empty if it could not be read.

    Attributes
    ----------
    path
        The run directory.
    info
        Content of ``run.json``.
    plan, further
        The first plan, and those that followed it, in the order in which they were flown.
    missing
        One line for each part that is missing or cannot be read.
    estimates
        Sources estimated from the readings.
    releases
        Releases of gas estimated from the readings.
    advice
        The agent named from readings and evidence.
    """

    path: Path
    info: Mapping[str, object]
    scenario: Scenario | None
    plan: SurveyPlan | None
    log: FlightLog | None
    photographs: tuple[Photograph, ...]
    missing: tuple[str, ...]
    estimates: SourceEstimates | None = None
    releases: ReleaseEstimates | None = None
    advice: AgentAdvice | None = None
    further: tuple[SurveyPlan, ...] = ()

    @property
    def plans(self) -> tuple[SurveyPlan, ...]:
        """All plans, the first one first."""
        return ((self.plan,) if self.plan else ()) + self.further

    @property
    def has_radiation(self) -> bool:
        """Whether dose rates were read, or might have been."""
        if self.log is not None and self.log.readings:
            return True
        return self.scenario is None or self.scenario.has_radiation

    @property
    def has_cameras(self) -> bool:
        """Whether vehicles took photographs; without a scenario they did."""
        return self.scenario is None or self.scenario.has_cameras

    @property
    def driver(self) -> str:
        """Name of the ground vehicle, empty if there is none."""
        return self.scenario.driver_name if self.scenario is not None else ''

    @property
    def vehicles(self) -> tuple[str, ...]:
        """Names of all vehicles, in the order of the scenario where there is one."""
        names: dict[str, None] = {}
        if self.scenario is not None:
            names.update(dict.fromkeys(self.scenario.vehicle_names))
        if self.plan is not None:
            names.update(dict.fromkeys(route.vehicle.name for route in self.plan.routes))
        if self.log is not None:
            names.update(dict.fromkeys(sorted({*self.log.tracks, *self.log.samples})))
        return tuple(names)
