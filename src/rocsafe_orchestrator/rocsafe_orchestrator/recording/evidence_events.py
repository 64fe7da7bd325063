# SPDX-License-Identifier: Apache-2.0
"""What the evidence log of a run keeps of its messages.

Each event has the SHA-256 of the message as it is recorded in ``mission.mcap``, and what it says;
of long lists only the number of their elements. Readings are many: of those of some seconds the
log has their number, the hash of all of them, and the highest.
"""

import hashlib
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from rocsafe_geo.storage.evidence_log import Event
from rocsafe_ros import topics
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.topics import TopicSpec

DATUM = 'WGS84, heights above the ellipsoid'
# Time of the vehicles between two entries of their readings.
READINGS_NS = 10_000_000_000
MOST_ELEMENTS = 20

EACH: Mapping[str, str] = {
    topics.DECISIONS.name: 'decision',
    topics.RECEIPTS.name: 'photograph',
    topics.DOSE_ALARM.name: 'alarm',
    topics.EVENTS.name: 'event',
    **dict.fromkeys(
        (
            spec.name
            for spec in (
                topics.REGION, topics.PLAN, topics.HAZARD_SOURCES, topics.DOSE_MAP,
                topics.CORDONS, topics.RELEASES, topics.PLUME, topics.THREAT_ZONES,
                topics.AGENT, topics.AGENT_REPORTS, topics.EVIDENCE, topics.GROUND_ROUTE,
                topics.MOSAIC,
            )
        ),
        'product',
    ),
}  # fmt: skip
"""Kinds of events by topics of which each message is kept."""

ON_CHANGE: Mapping[str, tuple[str, tuple[str, ...]]] = {
    topics.MISSION_STATE.name: ('phase', ('mission_id', 'phase')),
    topics.STATE.name: ('state', ('state', 'ending', 'taken_by', 'plan_id')),
    topics.CONTROL.name: ('lease', ('lease', 'holder', 'text')),
    topics.AGENTS.name: ('agreement', ('epoch', 'coordinator', 'plan_hash', 'members', 'text')),
}
"""Kinds and the fields whose change is kept."""

READINGS: Mapping[str, str] = {
    topics.RADIATION.name: 'dose_rate_usvh',
    topics.GAS.name: 'raw',
    topics.BIO.name: 'particles_per_l',
    topics.ANEMOMETER.name: 'std_mps',
}
"""Fields by which the highest reading is found."""

KEPT = frozenset({*EACH, *ON_CHANGE, *READINGS})


@dataclass(slots=True)
class _Heard:
    """Readings of one sensor since the last entry."""

    by: str
    digest: Any
    first_ns: int
    last_ns: int = 0
    count: int = 0
    highest: Any = None


class EvidenceEvents:
    """Turns messages into events of the log.

    Parameters
    ----------
    clock
        Returns the time on the wall, seconds since 1970.
    told
        Hashes of messages that are in the log already: late subscribers hear them again.
    """

    def __init__(self, clock: Callable[[], float], told: set[str]) -> None:
        self._clock = clock
        self._told = told
        self._before: dict[tuple[str, str], list[Any]] = {}
        self._heard: dict[tuple[str, str], _Heard] = {}

    def of(self, spec: TopicSpec, vehicle: str, message: Any, data: bytes) -> Iterator[Event]:
        """Yield the events of a message; `data` is what is recorded of it."""
        if spec.name in READINGS:
            yield from self._of_reading(spec.name, vehicle, message, data)
            return
        digest = hashlib.sha256(data).hexdigest()
        kind = self._kind(spec.name, vehicle, message, digest)
        if kind:
            by = vehicle or getattr(message, 'by', '') or getattr(message, 'vehicle', '')
            what = {'datum': DATUM, 'recorded_sha256': digest, 'message': plain_of(message)}
            yield self._event(kind, by or 'mission', spec.name, what)

    def rest(self) -> Iterator[Event]:
        """Yield the events of the readings that wait for more."""
        for (topic, _), heard in self._heard.items():
            yield self._of_heard(topic, heard)
        self._heard.clear()

    def _kind(self, topic: str, vehicle: str, message: Any, digest: str) -> str:
        """Return the kind of a message that is kept, empty for one that is not."""
        if topic in EACH:
            if digest in self._told:
                return ''
            self._told.add(digest)
            return EACH[topic]
        kind, names = ON_CHANGE[topic]
        sender = vehicle or getattr(message, 'vehicle', '')
        now = [plain_of(getattr(message, name)) for name in names]
        before = self._before.get((topic, sender))
        self._before[topic, sender] = now
        return kind if now != before else ''

    def _of_reading(self, topic: str, vehicle: str, message: Any, data: bytes) -> Iterator[Event]:
        stamp_ns = ns_of_stamp(message.header.stamp)
        key = (topic, vehicle)
        heard = self._heard.get(key)
        if heard is not None and not 0 <= stamp_ns - heard.first_ns < READINGS_NS:
            yield self._of_heard(topic, heard)
            heard = None
        if heard is None:
            heard = self._heard[key] = _Heard(vehicle, hashlib.sha256(), stamp_ns)
        heard.count += 1
        heard.last_ns = stamp_ns
        heard.digest.update(data)
        field = READINGS[topic]
        if heard.highest is None or getattr(message, field) > getattr(heard.highest, field):
            heard.highest = message

    def _of_heard(self, topic: str, heard: _Heard) -> Event:
        what = {
            'datum': DATUM,
            'count': heard.count,
            'first_s': heard.first_ns / 1e9,
            'last_s': heard.last_ns / 1e9,
            'recorded_sha256': heard.digest.hexdigest(),
            'highest': plain_of(heard.highest),
        }
        return self._event('readings', heard.by, topic, what)

    def _event(self, kind: str, by: str, topic: str, what: Mapping[str, Any]) -> Event:
        return Event(time_s=self._clock(), kind=kind, by=by, what={'topic': topic, **what})


def plain_of(value: Any) -> Any:
    """Return a message as dictionaries fit for JSON; a long list as its number of elements."""
    if hasattr(value, 'get_fields_and_field_types'):
        return {
            name: plain_of(getattr(value, name)) for name in value.get_fields_and_field_types()
        }
    if isinstance(value, (str, bool)):
        return value
    if isinstance(value, (Sequence, bytes)) or hasattr(value, 'tolist'):
        if len(value) > MOST_ELEMENTS:
            return {'count': len(value)}
        return [plain_of(each) for each in value]
    return value if isinstance(value, (int, float)) else str(value)
