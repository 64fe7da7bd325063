# SPDX-License-Identifier: Apache-2.0
"""What the evidence log of a run keeps of its messages.

Each event has the SHA-256 of the message as it is recorded in ``mission.mcap``, and what it says;
of long lists only the number of their elements. Readings are many: of those of some seconds the
log has their number, the hash of all of them, and the highest.
"""

import hashlib
import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from typing import Any

from rocsafe_geo.evidence.evidence_log import Event
from rocsafe_ros.conversions import ns_of_stamp
from rocsafe_ros.interfaces import topics
from rocsafe_ros.interfaces.interface_spec import TopicSpec, name_of

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
    topics.AGENTS.name: (
        'agreement',
        ('epoch', 'coordinator', 'plan_hash', 'members', 'search_round', 'text'),
    ),
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
        Topics and hashes of messages in the log: late subscribers hear them again.
    """

    def __init__(self, clock: Callable[[], float], told: set[tuple[str, str]]) -> None:
        self._clock = clock
        self._told = told
        self._before: dict[tuple[str, str], list[Any]] = {}
        self._heard: dict[str, _Heard] = {}

    def of(self, spec: TopicSpec, vehicle: str, message: Any, data: bytes) -> Iterator[Event]:
        """Yield the events of a message; `data` is what is recorded of it."""
        topic = name_of(spec, vehicle)
        if spec.name in READINGS:
            yield from self._of_reading(topic, vehicle, message, data)
            return
        digest = hashlib.sha256(data).hexdigest()
        kind = self._kind(spec.name, topic, message, digest)
        if kind:
            by = vehicle or getattr(message, 'by', '') or getattr(message, 'vehicle', '')
            what = {'datum': DATUM, 'recorded_sha256': digest, 'message': plain_of(message)}
            yield self._event(kind, by or 'mission', topic, what)

    def rest(self) -> Iterator[Event]:
        """Yield the events of the readings that wait for more."""
        for topic, heard in self._heard.items():
            yield self._of_heard(topic, heard)
        self._heard.clear()

    def _kind(self, name: str, topic: str, message: Any, digest: str) -> str:
        """Return the kind of a message that is kept, empty for one that is not."""
        if name in EACH:
            if (topic, digest) in self._told:
                return ''
            self._told.add((topic, digest))
            return EACH[name]
        kind, fields = ON_CHANGE[name]
        sender = (topic, getattr(message, 'vehicle', ''))
        now = [plain_of(getattr(message, field)) for field in fields]
        before = self._before.get(sender)
        self._before[sender] = now
        return kind if now != before else ''

    def _of_reading(self, topic: str, vehicle: str, message: Any, data: bytes) -> Iterator[Event]:
        stamp_ns = ns_of_stamp(message.header.stamp)
        heard = self._heard.get(topic)
        if heard is not None and not 0 <= stamp_ns - heard.first_ns < READINGS_NS:
            yield self._of_heard(topic, heard)
            heard = None
        if heard is None:
            heard = self._heard[topic] = _Heard(vehicle, hashlib.sha256(), stamp_ns)
        heard.count += 1
        heard.last_ns = stamp_ns
        heard.digest.update(data)
        field = READINGS[topic.removeprefix(f'{vehicle}/')]
        highest = math.nan if heard.highest is None else getattr(heard.highest, field)
        # What is no number is the highest only while there is none.
        if heard.highest is None or math.isnan(highest) or getattr(message, field) > highest:
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
    # Arrays and numbers of numpy, and the arrays of Python.
    plain = value.tolist() if hasattr(value, 'tolist') else value
    if isinstance(plain, (str, bool, int, float)):
        return plain
    if len(plain) > MOST_ELEMENTS:
        return {'count': len(plain)}
    return [plain_of(each) for each in plain]
