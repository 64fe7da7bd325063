# SPDX-License-Identifier: Apache-2.0
"""Other nodes in the ROS domain that use the names of a mission."""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

from rocsafe_interfaces.msg import GimbalCommand
from rocsafe_orchestrator.processes.process_table import Endpoint, ProcessSpec
from rocsafe_orchestrator.recording.recorded_topics import recorded_topics
from rocsafe_ros import topics
from rocsafe_ros.domain.mission_identity import BOUND, MissionIdentity
from rocsafe_scenario.scenario import Scenario

ELSEWHERE = 'wait for its end, or choose another domain, for instance ROS_DOMAIN_ID=1'
# Programs of others publish these to a mission, as they do commands of gimbals.
BY_OTHERS = (topics.CMD_VEL, topics.DRAWINGS)
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
    return frozenset(end.name for end in _own_ends(scenario, table))


def own_names(scenario: Scenario, table: Iterable[ProcessSpec]) -> Iterator[tuple[str, str]]:
    """Yield kind and name of what a mission in flight hears from its own processes only.

    These are the needed names without what programs beside a mission may give it.
    """
    for end in _own_ends(scenario, table):
        if end.spec not in BY_OTHERS and not _is_for_gimbal(end):
            yield end.kind, end.name


def _own_ends(scenario: Scenario, table: Iterable[ProcessSpec]) -> Iterator[Endpoint]:
    yield from (end for spec in table for end in spec.readiness if end.spec not in BOUND)
    for call in topics.CALLS:
        if call.scope is topics.Scope.VEHICLE:
            yield from (Endpoint(spec=call, vehicle=vehicle) for vehicle in scenario.all_names)
    others = [camera.name for camera in scenario.other_cameras]
    simulated = set(scenario.metered_names)
    for spec, vehicle in recorded_topics(scenario.all_names, others):
        # Names that begin with a slash are everybody's, such as /diagnostics.
        is_ours = spec not in DETECTOR_TOPICS or vehicle in simulated
        if is_ours and not spec.name.startswith('/'):
            yield Endpoint(spec=spec, vehicle=vehicle)


def _is_for_gimbal(end: Endpoint) -> bool:
    return isinstance(end.spec, topics.TopicSpec) and end.spec.message_type is GimbalCommand


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
