# SPDX-License-Identifier: Apache-2.0
"""Recorded inputs of the nodes that are replayed, and their recorded results."""

import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from mcap.exceptions import McapError
from mcap.reader import make_reader

from rocsafe_geo.time_units import NS_PER_S
from rocsafe_orchestrator.errors import OrchestratorError
from rocsafe_orchestrator.products.photographs import read_photographs
from rocsafe_orchestrator.products.run_record import Photograph
from rocsafe_orchestrator.recording.segments import stamp_ns
from rocsafe_orchestrator.replay.feed import RecordedReading, StoredShot
from rocsafe_orchestrator.run_directory import RunDirectory

_REGION, _READINGS = '/region', '/radiation'


class ReplayError(OrchestratorError):
    """A run cannot be replayed, or a replay did not get to its end."""


@dataclass(frozen=True, slots=True, kw_only=True)
class RecordedInputs:
    """Inputs of a run.

    Attributes
    ----------
    region
        The region as serialised message, None if it was not recorded.
    readings, shots
        All readings, and the photographs of the image store.
    sources
        Position and strength of each source among the products: degrees, degrees, uSv/h at 1 m.
        The last estimate of the localizer in flight may lack the last readings.
    photographs
        Records of the photographs by shot id.
    """

    region: bytes | None
    readings: tuple[RecordedReading, ...]
    shots: tuple[StoredShot, ...]
    sources: tuple[tuple[float, float, float], ...]
    photographs: dict[str, Photograph]


def read_inputs(run: RunDirectory) -> RecordedInputs:
    """Return the inputs of a run.

    Raises
    ------
    ReplayError
        If the recording cannot be read.
    """
    photographs = {shot.shot_id: shot for shot in read_photographs(run.images)}
    try:
        with run.recording.open('rb') as stream:
            region, readings = _messages(stream)
    except (McapError, OSError) as error:
        raise ReplayError(f'{run.recording}: cannot be read: {error}') from error
    return RecordedInputs(
        region=region,
        readings=tuple(readings),
        shots=tuple(
            StoredShot(time_ns=shot.time_ns, vehicle=shot.vehicle, shot_id=shot.shot_id)
            for shot in photographs.values()
        ),
        sources=_sources(run.path / 'sources.json'),
        photographs=photographs,
    )


def _messages(stream: Any) -> tuple[bytes | None, list[RecordedReading]]:
    region: bytes | None = None
    readings = []
    for _, channel, message in make_reader(stream).iter_messages(log_time_order=False):
        if channel.topic == _REGION:
            region = message.data
        elif channel.topic.endswith(_READINGS):
            vehicle = channel.topic.strip('/').partition('/')[0]
            readings.append(
                RecordedReading(time_ns=stamp_ns(message.data), vehicle=vehicle, data=message.data)
            )
    return region, readings


def _sources(path: Path) -> tuple[tuple[float, float, float], ...]:
    """Return the sources of a product, none without the file."""
    if not path.is_file():
        return ()
    try:
        rows = json.loads(path.read_text(encoding='utf-8'))['sources']
        return tuple(
            (
                float(row['place']['latitude_deg']),
                float(row['place']['longitude_deg']),
                float(row['dose_rate_at_1m_usvh']),
            )
            for row in rows
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise ReplayError(f'{path}: cannot be read: {error!r}') from error


def sources_of(message: Any) -> tuple[tuple[float, float, float], ...]:
    """Return latitude, longitude and strength of each source of a ``HazardSourceArray``."""
    return tuple(
        (s.position.latitude, s.position.longitude, s.dose_rate_at_1m_usvh)
        for s in message.sources
    )


def time_of(message: Any) -> int:
    """Return the stamp of a message in nanoseconds."""
    stamp = message.header.stamp
    return int(stamp.sec) * NS_PER_S + int(stamp.nanosec)


def record_of(photograph: Photograph) -> dict[str, Any]:
    """Return the record of a photograph as the image store wrote it.

    Raises
    ------
    ReplayError
        If it cannot be read.
    """
    path = photograph.path.with_suffix('.json')
    try:
        record: dict[str, Any] = json.loads(path.read_text(encoding='utf-8'))
    except (OSError, ValueError) as error:
        raise ReplayError(f'{path}: cannot be read: {error}') from error
    return record
