# SPDX-License-Identifier: Apache-2.0
"""Other nodes in the ROS domain that use the names of a mission."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rocsafe_orchestrator.process_table.table import ProcessSpec
from rocsafe_orchestrator.recording.recorded_topics import recorded_topics
from rocsafe_ros.domain.mission_identity import BOUND, MissionIdentity
from rocsafe_ros.interfaces import calls, topics
from rocsafe_ros.interfaces.interface_spec import Scope, name_of, of_camera
from rocsafe_scenario.scenario import Scenario

ELSEWHERE = 'wait for its end, or choose another domain, for instance ROS_DOMAIN_ID=1'
# The user's own detector publishes these.
DETECTOR_TOPICS = (topics.RADIATION, topics.ACCUMULATED_DOSE, topics.DOSE_ALARM)


@dataclass(frozen=True, slots=True, kw_only=True)
class Speaker:
    """A node in the domain.

    Attributes
    ----------
    node
        Its full name.
    place
        Process and machine, as far as they are known, as text.
    mission
        The mission that it is part of, None for a node that stands alone.
    names
        What it publishes or serves of the names that were asked for, relative to the suite.
    """

    node: str
    place: str = ''
    mission: MissionIdentity | None = None
    names: tuple[str, ...] = ()

    def is_of(self, mission: MissionIdentity) -> bool:
        """Return whether it is part of `mission`."""
        return self.mission is not None and self.mission.token == mission.token


def needed_names(scenario: Scenario, table: Iterable[ProcessSpec]) -> frozenset[str]:
    """Return the topics, services and actions that only the mission's own processes may have."""
    names = {end.name for spec in table for end in spec.readiness if end.spec not in BOUND}
    names |= {
        name_of(call, vehicle)
        for call in calls.CALLS
        if call.scope is Scope.VEHICLE
        for vehicle in scenario.all_names
    }
    # Names that begin with a slash are everybody's, such as /diagnostics.
    return frozenset(names | {name for name in _topics(scenario) if not name.startswith('/')})


def open_topics(scenario: Scenario) -> Iterator[str]:
    """Yield the topics that programs of others may publish to a mission in flight."""
    others = [camera.name for camera in scenario.other_cameras]
    simulated = set(scenario.metered_names)
    gimbals = [of_camera(topics.GIMBAL_COMMAND, camera) for camera in others]
    for spec, vehicle in recorded_topics(scenario.all_names, others):
        is_detector = spec in DETECTOR_TOPICS and vehicle not in simulated
        if is_detector or spec in (*topics.FROM_ANYBODY, *gimbals):
            yield name_of(spec, vehicle)


def _topics(scenario: Scenario) -> Iterator[str]:
    others = [camera.name for camera in scenario.other_cameras]
    simulated = set(scenario.metered_names)
    for spec, vehicle in recorded_topics(scenario.all_names, others):
        if spec not in DETECTOR_TOPICS or vehicle in simulated:
            yield name_of(spec, vehicle)


def objections(mission: MissionIdentity, speakers: Iterable[Speaker]) -> list[str]:
    """Return why `mission` must not start among `speakers`: one line each, none if it may."""
    strangers = [one for one in speakers if not one.is_of(mission)]
    rivals = {one.mission: one for one in strangers if one.mission is not None}
    lines = [_rival_text(rival) for rival in rivals.values()]
    alone = [one for one in strangers if one.names and one.mission is None]
    return lines + [_stranger_text(one) for one in alone]


def company_text(who: str) -> str:
    """Return that another mission has the domain, and whose it is."""
    whose = f' ({who})' if who else ''
    return f'another mission is running in this ROS domain{whose}: {ELSEWHERE}'


def _rival_text(one: Speaker) -> str:
    name = one.mission.mission if one.mission is not None else ''
    return company_text(', '.join(filter(None, (name, f'node {one.node}', one.place))))


def _stranger_text(one: Speaker) -> str:
    place = f' ({one.place})' if one.place else ''
    first, rest = one.names[0], len(one.names) - 1
    more = f' and {rest} more names' if rest else ''
    return f'node {one.node}{place} already speaks for /{first}{more}: {ELSEWHERE}'
