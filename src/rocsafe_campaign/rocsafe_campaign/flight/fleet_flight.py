# SPDX-License-Identifier: Apache-2.0
"""The flight of all vehicles of a scenario by its plan, in the steps of the simulated world."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

from rocsafe_campaign.errors import CampaignError
from rocsafe_campaign.flight.planned_route import planned_route
from rocsafe_geo.frame import LocalFrame
from rocsafe_geo.motion.autopilot import Autopilot
from rocsafe_geo.motion.performance import Performance
from rocsafe_geo.position import GeoPosition
from rocsafe_geo.time_units import NS_PER_S
from rocsafe_planner.plan.plan import SurveyPlan
from rocsafe_scenario.blocks.vehicles import VehicleBlock
from rocsafe_scenario.scenario import Scenario
from rocsafe_sim.clock.cadence import Cadence, period_ns
from rocsafe_sim.flight.airframe import Airframe
from rocsafe_sim.options import WorldOptions
from rocsafe_sim.rav.rav import Fix, Rav, RavParts
from rocsafe_sim.sensors.sensing_noise import SensorNoise
from rocsafe_sim.vehicle.free_vehicle import FreeVehicle
from rocsafe_sim.vehicle.snapshot import FlightSummary

# A fleet that is so many times later than its plan never lands.
LATEST_TIMES, LATEST_S = 3.0, 600.0


@dataclass(frozen=True, slots=True, kw_only=True)
class TimedFix:
    """A fix of a vehicle, with its simulated time in nanoseconds since 1970."""

    vehicle: str
    time_ns: int
    fix: Fix


@dataclass(frozen=True, slots=True, kw_only=True)
class FleetFlight:
    """A flown plan.

    Attributes
    ----------
    fixes
        All fixes in the order of time, from the start to the step in which all have landed.
    summaries
        How the flight of each vehicle ended, of those that had a route.
    duration_s
        From the first take-off to the last touch-down, seconds; 0 if nobody flew.
    """

    fixes: tuple[TimedFix, ...]
    summaries: Mapping[str, FlightSummary]
    duration_s: float


def fly(scenario: Scenario, plan: SurveyPlan) -> FleetFlight:
    """Fly a plan with simulated vehicles and return their fixes and how their flights ended.

    The same steps, fixes and noise as those of the processes `world` and `rav`.

    Raises
    ------
    CampaignError
        If a vehicle refuses its route or does not land.
    """
    frame = LocalFrame(scenario.origin_position())
    world = WorldOptions(
        step_s=scenario.clock.step_s, start_time_s=scenario.clock.start.timestamp()
    )
    ravs = [_rav(scenario, block, frame) for block in scenario.vehicles]
    clock = _Clock(scenario, world, ravs)
    clock.step()
    for rav, route in zip(ravs, plan.routes, strict=True):
        if route.viewpoints:
            rav.vehicle.fly_route(planned_route(plan, route, frame))
    limit_s = LATEST_TIMES * plan.makespan_s + LATEST_S
    while not all(rav.vehicle.is_idle for rav in ravs):
        if clock.elapsed_s > limit_s:
            raise CampaignError(f'not all vehicles have landed after {limit_s:.0f} s')
        clock.step()
    found = {rav.parts.name: rav.vehicle.summary() for rav in ravs}
    return FleetFlight(
        fixes=tuple(clock.fixes),
        summaries={name: one for name, one in found.items() if one is not None},
        duration_s=_duration_s(ravs),
    )


class _Clock:
    """Steps all vehicles and collects their fixes."""

    def __init__(self, scenario: Scenario, world: WorldOptions, ravs: list[Rav]) -> None:
        self._ravs = ravs
        self._start_ns = self._time_ns = world.start_ns
        self._step_ns = world.step_ns
        self._due = Cadence(period_ns(scenario.simulation.fix_rate_hz))
        self.fixes: list[TimedFix] = []

    @property
    def elapsed_s(self) -> float:
        """Simulated seconds since the start."""
        return (self._time_ns - self._start_ns) / NS_PER_S

    def step(self) -> None:
        """Advance all vehicles to the present time, take the fixes that are due, and go on."""
        is_due = self._due.is_due(self._time_ns)
        for rav in self._ravs:
            seen = rav.vehicle.step(self._time_ns)
            if is_due:
                fix = rav.fix(self._time_ns, seen.pose.position_enu)
                self.fixes.append(TimedFix(vehicle=rav.parts.name, time_ns=self._time_ns, fix=fix))
        self._time_ns += self._step_ns


def _rav(scenario: Scenario, block: VehicleBlock, frame: LocalFrame) -> Rav:
    """Return a vehicle without cameras on level ground, or on that of its home."""
    simulation = scenario.simulation
    # At altitude 0, as the process `rav` places it: half a millimetre away from the ground.
    east, north, _ = frame.enu_of(GeoPosition(*block.home, 0.0)).tolist()
    parts = RavParts(
        name=block.name,
        frame=frame,
        noise=SensorNoise(
            seed=scenario.seed,
            vehicle=block.name,
            gps_horizontal_std_m=simulation.gps_horizontal_std_m,
            gps_vertical_std_m=simulation.gps_vertical_std_m,
            tilt_std_rad=math.radians(simulation.tilt_std_deg),
            attitude_std_rad=math.radians(simulation.attitude_std_deg),
        ),
        cameras=(),
    )
    return Rav(parts, FreeVehicle(_airframe(scenario, block), (east, north, 0.0)))


def _airframe(scenario: Scenario, block: VehicleBlock) -> Airframe:
    return Airframe(
        performance=Performance(
            cruise_speed_mps=block.cruise_speed_mps,
            acceleration_mps2=block.acceleration_mps2,
            climb_rate_mps=block.climb_rate_mps,
            descent_rate_mps=block.descent_rate_mps,
            autopilot=Autopilot(**block.autopilot.model_dump()),
            wind_mps=scenario.survey.airspace.wind_mps,
        ),
        hover_s=block.hover_s,
        endurance_s=block.endurance_s,
        reserve_fraction=block.reserve_fraction,
        collision_radius_m=scenario.simulation.collision_radius_m,
        hover_power_w=block.hover_power_w,
    )


def _duration_s(ravs: list[Rav]) -> float:
    flights = [rav.vehicle.flight for rav in ravs]
    ends = [(one.take_off_ns, one.ended_ns) for one in flights if one and one.ended_ns]
    if not ends:
        return 0.0
    return (max(end for _, end in ends) - min(start for start, _ in ends)) / NS_PER_S
