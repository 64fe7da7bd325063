# SPDX-License-Identifier: Apache-2.0
"""Reader of the recording of a run; it uses the message definitions in the recording."""

from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import numpy as np
from mcap.exceptions import McapError
from mcap.reader import McapReader, make_reader
from mcap_ros2.decoder import DecoderFactory

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.mission_state.phase import Phase
from rocsafe_orchestrator.products.run_record import (
    AgentSample,
    Alarm,
    FlightLog,
    GasSample,
    MissionSample,
    Notice,
    ParticleSample,
    Reading,
    RecordingFacts,
    Track,
    VehicleSample,
)

READING = 'rocsafe_interfaces/msg/RadiationReading'
_GAS = 'rocsafe_interfaces/msg/GasReading'
_PARTICLES = 'rocsafe_interfaces/msg/ParticleReading'
_FIX = 'sensor_msgs/msg/NavSatFix'
_STATE = 'rocsafe_interfaces/msg/VehicleState'
_MISSION = 'rocsafe_interfaces/msg/MissionState'
_ALARM = 'rocsafe_interfaces/msg/DoseAlarm'
_EVENT = 'rocsafe_interfaces/msg/VehicleEvent'
_DECISION = 'rocsafe_interfaces/msg/Decision'
_AGENT = 'rocsafe_interfaces/msg/AgentState'
_TRUTH_SUFFIX = '/ground_truth/fix'


class RecordingError(ValueError):
    """A file is no recording that can be read."""


def read_flight_log(path: Path) -> FlightLog:
    """Read the recording at `path`.

    Raises
    ------
    RecordingError
        If it cannot be read.
    """
    try:
        with path.open('rb') as stream:
            return _Log(make_reader(stream, decoder_factories=[DecoderFactory()])).read()
    except (McapError, OSError) as error:
        raise RecordingError(f'{path.name} cannot be read: {error}') from error


class _Log:
    """Collects the messages of a recording."""

    def __init__(self, reader: McapReader) -> None:
        self._reader = reader
        self._readings: dict[tuple[int, str], Reading] = {}
        self._gases: dict[tuple[int, str, str], GasSample] = {}
        self._particles: dict[tuple[int, str], ParticleSample] = {}
        self._fixes: dict[str, dict[int, tuple[float, float, float]]] = {}
        self._samples: dict[str, list[VehicleSample]] = {}
        self._mission: list[MissionSample] = []
        self._alarms: list[Alarm] = []
        self._notices: list[Notice] = []
        self._agents: list[AgentSample] = []

    def read(self) -> FlightLog:
        """Read all messages of interest."""
        handlers: dict[str, Callable[[str, Any], None]] = {
            READING: self._on_reading,
            _GAS: self._on_gas,
            _PARTICLES: self._on_particles,
            _FIX: self._on_fix,
            _STATE: self._on_state,
            _MISSION: self._on_mission,
            _ALARM: self._on_alarm,
            _EVENT: self._on_event,
            _DECISION: self._on_decision,
            _AGENT: self._on_agent,
        }
        for kind, topic, message in self._messages(frozenset(handlers)):
            handlers[kind](topic, message)
        return FlightLog(
            facts=self._facts(),
            readings=tuple(self._readings[key] for key in sorted(self._readings)),
            gases=tuple(self._gases[key] for key in sorted(self._gases)),
            particles=tuple(self._particles[key] for key in sorted(self._particles)),
            tracks=dict(self._tracks()),
            samples={name: tuple(samples) for name, samples in sorted(self._samples.items())},
            mission=tuple(self._mission),
            alarms=tuple(self._alarms),
            notices=tuple(self._notices),
            agents=tuple(self._agents),
        )

    def _messages(self, kinds: frozenset[str]) -> Iterator[tuple[str, str, Any]]:
        summary = self._reader.get_summary()
        if summary is None:
            raise RecordingError('the recording has no summary: it was not closed properly')
        topics = {
            channel.topic
            for channel in summary.channels.values()
            if summary.schemas[channel.schema_id].name in kinds
        }
        # The fix is needed only where true positions are not recorded.
        topics -= {topic.replace(_TRUTH_SUFFIX, '/fix') for topic in topics if _is_truth(topic)}
        if not topics:
            return
        # The recording is sorted already.
        for decoded in self._reader.iter_decoded_messages(
            topics=sorted(topics), log_time_order=False
        ):
            yield decoded.schema.name, decoded.channel.topic, decoded.decoded_message

    def _facts(self) -> RecordingFacts:
        counts = self._reader.get_summary().statistics
        return RecordingFacts(
            message_count=counts.message_count, start_ns=counts.message_start_time
        )

    def _on_reading(self, topic: str, message: Any) -> None:
        vehicle, time_ns = _vehicle_of(topic), _stamp_ns(message)
        self._readings[time_ns, vehicle] = Reading(
            time_ns=time_ns,
            vehicle=vehicle,
            latitude_deg=message.position.latitude,
            longitude_deg=message.position.longitude,
            altitude_m=message.position.altitude,
            dose_rate_usvh=message.dose_rate_usvh,
            dose_rate_std_usvh=message.dose_rate_std_usvh,
            counts=message.counts,
            live_time_s=message.live_time_s,
            model=message.model,
            saturated=message.saturated,
        )

    def _on_gas(self, topic: str, message: Any) -> None:
        sample = GasSample(
            time_ns=_stamp_ns(message),
            vehicle=_vehicle_of(topic),
            sensor=message.sensor,
            unit=message.unit,
            raw=message.raw,
            limit=message.limit,
            saturated=message.saturated,
        )
        self._gases[sample.time_ns, sample.vehicle, sample.sensor] = sample

    def _on_particles(self, topic: str, message: Any) -> None:
        sample = ParticleSample(
            time_ns=_stamp_ns(message),
            vehicle=_vehicle_of(topic),
            fluorescent=message.fluorescent,
            particles_per_l=message.particles_per_l,
            triggered=message.triggered,
            latitude_deg=message.position.latitude,
            longitude_deg=message.position.longitude,
        )
        self._particles[sample.time_ns, sample.vehicle] = sample

    def _on_fix(self, topic: str, message: Any) -> None:
        if message.status.status >= 0:
            place = (message.latitude, message.longitude, message.altitude)
            self._fixes.setdefault(topic, {})[_stamp_ns(message)] = place

    def _on_state(self, topic: str, message: Any) -> None:
        self._samples.setdefault(_vehicle_of(topic), []).append(
            VehicleSample(
                time_ns=_stamp_ns(message),
                state=message.state,
                plan_id=message.plan_id,
                viewpoint_count=message.viewpoint_count,
                viewpoints_visited=message.viewpoints_visited,
                shots_taken=message.shots_taken,
                battery_fraction=message.battery_fraction,
                distance_flown_m=message.distance_flown_m,
                text=message.text,
                # Recordings of earlier versions lack it.
                taken_by=getattr(message, 'taken_by', ''),
            )
        )

    def _on_mission(self, _topic: str, message: Any) -> None:
        self._mission.append(
            MissionSample(
                phase=Phase(message.phase),
                text=message.text,
                images_stored=message.images_stored,
                images_expected=message.images_expected,
                mission_time_s=message.mission_time_s,
                wall_time_s=message.wall_time_s,
            )
        )

    def _on_alarm(self, topic: str, message: Any) -> None:
        self._alarms.append(
            Alarm(
                time_ns=_stamp_ns(message),
                vehicle=_vehicle_of(topic),
                is_reached=message.triggered,
                is_dose=bool(message.quantity),
                threshold_usv=message.threshold_usv,
                value_usv=message.value_usv,
                name=message.name,
                # Recordings of earlier versions lack it.
                turns_back=getattr(message, 'turns_back', False),
            )
        )

    def _on_event(self, topic: str, message: Any) -> None:
        vehicle = _vehicle_of(topic)
        self._notices.append(
            Notice(
                time_ns=_stamp_ns(message),
                # Those of an event begin with one for debugging.
                severity=max(message.severity - 1, 0),
                kind=message.kind,
                by=vehicle,
                vehicles=(vehicle,),
                text=message.text,
            )
        )

    def _on_decision(self, _topic: str, message: Any) -> None:
        self._notices.append(
            Notice(
                time_ns=_stamp_ns(message),
                severity=message.severity,
                kind=message.kind,
                by=message.by,
                vehicles=tuple(message.vehicles),
                text=message.text,
                reason=message.reason,
            )
        )

    def _on_agent(self, _topic: str, message: Any) -> None:
        self._agents.append(
            AgentSample(
                time_ns=_stamp_ns(message),
                vehicle=message.vehicle,
                epoch=message.epoch,
                coordinator=message.coordinator,
                heard=tuple(message.heard),
                members=tuple(message.members),
                unable=tuple(message.unable),
                duplicates=message.duplicates,
                bytes_sent=message.bytes_sent,
                alarms=message.alarms,
                # Recordings of 0.2.0 know no rounds.
                search_round=getattr(message, 'search_round', 0),
                search_by=getattr(message, 'search_by', ''),
                search_places=getattr(message, 'search_places', 0),
                search_text=getattr(message, 'search_text', ''),
            )
        )

    def _tracks(self) -> Iterator[tuple[str, Track]]:
        """Yield the track of each vehicle: its true one where a simulation recorded it."""
        for topic, fixes in sorted(self._fixes.items()):
            times = sorted(fixes)
            places = np.array([fixes[time] for time in times])
            track = Track(
                time_ns=np.array(times, dtype=np.int64),
                latitude_deg=places[:, 0],
                longitude_deg=places[:, 1],
                altitude_m=places[:, 2],
                is_truth=_is_truth(topic),
            )
            yield _vehicle_of(topic), track


def _is_truth(topic: str) -> bool:
    return topic.endswith(_TRUTH_SUFFIX)


def _vehicle_of(topic: str) -> str:
    return topic.strip('/').partition('/')[0]


def _stamp_ns(message: Any) -> int:
    stamp = message.header.stamp
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)
