# SPDX-License-Identifier: Apache-2.0
"""The block of a scenario file that says what a ground vehicle drives to after the survey."""

from typing import Annotated, Literal

from pydantic import Field

from rocsafe_scenario.blocks.block import Block, LatLon, VehicleName
from rocsafe_scenario.blocks.vehicles import DroneBlock

EvidenceName = Annotated[str, Field(pattern=r'^[A-Za-z0-9][A-Za-z0-9_-]*$', max_length=64)]


class EvidenceBlock(Block):
    """A place at which evidence is taken.

    A mark is driven to; what is a source, release or object is photographed from some metres.
    """

    name: EvidenceName
    position: LatLon
    kind: Literal['mark', 'source', 'release', 'object'] = 'mark'
    priority: float = Field(default=1.0, ge=1e-3, le=1e3)
    dwell_s: float = Field(default=30.0, ge=0.0, le=3600.0)


class GroundVehicleBlock(Block):
    """A ground vehicle that takes evidence when the drones have landed and the map is written.

    Attributes
    ----------
    dose_budget_usv
        Dose that it may take on its whole drive.
    turn_back_usvh
        No part of its way is planned to reach this dose rate, at which it turns back.
    turn_back_ppm
        No part of its way is planned to reach this concentration of a gas that was found, by its
        upper 95 %, and it turns back at a reading of it by one of its own sensors that read in
        ppm; None: no limit.
    load_budget
        Toxic load of gas along its way by the upper 95 %, times that of level 2; None: no limit.
    evidence, to_sources, to_releases, to_marks
        Named places, and whether it goes to each source and each release of gas that was found,
        and to each place that operators marked on the console before the drive is planned, for
        `dwell_s`.
    labels_file
        GeoTIFF of classes of ground and things that somebody made, names in the ``.json`` beside
        it; they count instead of colours. Empty: none.
    to_objects
        Whether it also goes to the drums, flasks, wagons and markers of the labels.
    link, drone
        Of a real ground vehicle, an ArduPilot Rover, as of a drone; an empty link: it is
        simulated.
    """

    name: VehicleName
    home: LatLon
    dose_budget_usv: float = Field(gt=0.0, le=1e9)
    load_budget: float | None = Field(default=None, gt=0.0, le=1e9)
    turn_back_usvh: float = Field(default=1e5, ge=1e-3, le=1e9)
    turn_back_ppm: float | None = Field(default=None, gt=0.0, le=1e6)
    endurance_s: float = Field(default=7200.0, gt=0.0, le=604_800.0)
    reserve_fraction: float = Field(default=0.1, ge=0.0, le=0.9)
    width_m: float = Field(default=0.7, ge=0.1, le=10.0)
    to_sources: bool = True
    to_releases: bool = True
    to_marks: bool = False
    labels_file: str = ''
    to_objects: bool = True
    dwell_s: float = Field(default=30.0, ge=0.0, le=3600.0)
    link: str = ''
    drone: DroneBlock = DroneBlock()
    evidence: tuple[EvidenceBlock, ...] = Field(default=(), max_length=60)
