# SPDX-License-Identifier: Apache-2.0
"""What the evidence log keeps of each message: all types of them, with what is in their lists."""

import pytest

from rocsafe_geo.evidence.code_version import version_text
from rocsafe_geo.evidence.evidence_log import Event, EvidenceLog, read_log

MESSAGE_ROOM = 3
HASH_LETTERS = 64


def filled(message_type: type, depth: int = MESSAGE_ROOM) -> object:
    """Return a message of which each list has two elements."""
    from rosidl_parser.definition import AbstractSequence, NamespacedType

    message = message_type()
    kinds = message_type.SLOT_TYPES
    for name, kind in zip(message.get_fields_and_field_types(), kinds, strict=True):
        if isinstance(kind, AbstractSequence) and depth:
            if isinstance(kind.value_type, NamespacedType):
                module = __import__('.'.join(kind.value_type.namespaces), fromlist=['x'])
                part = getattr(module, kind.value_type.name)
                setattr(message, name, [filled(part, depth - 1) for _ in range(2)])
            elif not getattr(message, name):
                value = 'x' if 'String' in type(kind.value_type).__name__ else 1
                for one in (value, 1.0, b'1', True):
                    try:
                        setattr(message, name, [one, one])
                        break
                    except AssertionError:
                        continue
    return message


def kept_topics() -> list:
    """Return the topics that the log keeps."""
    from rocsafe_orchestrator.recording.evidence_events import KEPT
    from rocsafe_ros.interfaces import topics

    return [spec for spec in topics.TOPICS if spec.name in KEPT]


def test_every_kept_message_can_be_written_and_read(tmp_path):
    """Empty ones and full ones of all types: what cannot be written would end the recorder."""
    from rclpy.serialization import serialize_message

    from rocsafe_orchestrator.recording.evidence_events import KEPT, EvidenceEvents
    from rocsafe_ros.interfaces.interface_spec import Scope

    events: list[Event] = []
    made = EvidenceEvents(lambda: 1.0, set())
    specs = kept_topics()
    assert {spec.name for spec in specs} == KEPT
    for spec in specs:
        vehicle = 'rav1' if spec.scope is Scope.VEHICLE else ''
        for message in (spec.message_type(), filled(spec.message_type)):
            events.extend(made.of(spec, vehicle, message, serialize_message(message)))
    events.extend(made.rest())
    log = EvidenceLog(tmp_path / 'log')
    log.add(events)
    log.close()
    entries = read_log(tmp_path / 'log')
    told = {entry['topic'].removeprefix('rav1/') for entry in entries}
    for entry in entries:
        assert entry['datum'].startswith('WGS84')
        assert entry['code'] == version_text()
        assert len(entry['recorded_sha256']) == HASH_LETTERS
    assert told == KEPT


def test_a_photograph_is_told_with_place_and_uncertainty(tmp_path):
    """A line stands by itself: nobody needs the picture, or its side file, to judge it."""
    from rclpy.serialization import serialize_message

    from rocsafe_interfaces.msg import ShotReceipt
    from rocsafe_orchestrator.recording.evidence_events import EvidenceEvents
    from rocsafe_ros.interfaces import topics

    receipt = ShotReceipt(vehicle='rav1', shot_id='rav1-00007', sha256='ab' * 32, viewpoint_id=12)
    receipt.fix.latitude, receipt.fix.longitude, receipt.fix.altitude = 53.0, -9.0, 98.5
    receipt.fix.position_covariance = [0.04, 0.0, 0.0, 0.0, 0.04, 0.0, 0.0, 0.0, 0.09]
    receipt.taken.sec, receipt.orientation_covariance[8] = 1748772070, 0.01
    made = EvidenceEvents(lambda: 1.0, set())
    log = EvidenceLog(tmp_path / 'log')
    log.add(list(made.of(topics.RECEIPTS, '', receipt, serialize_message(receipt))))
    log.close()
    (line,) = read_log(tmp_path / 'log')
    told = line['message']
    assert (line['kind'], line['by'], told['sha256']) == ('photograph', 'rav1', 'ab' * 32)
    assert (told['fix']['latitude'], told['fix']['altitude']) == (53.0, 98.5)
    assert told['fix']['position_covariance'][8] == 0.09
    assert told['orientation_covariance'][8] == 0.01
    assert (told['taken']['sec'], told['viewpoint_id']) == (1748772070, 12)


@pytest.mark.parametrize(('count', 'told'), [(3, [1.0] * 3), (21, {'count': 21})])
def test_long_lists_are_told_by_their_length(count, told):
    """Their content is in the recording, whose hash the log has."""
    import numpy

    from rocsafe_orchestrator.recording.evidence_events import plain_of

    assert plain_of(numpy.ones(count)) == told


def test_a_reading_that_is_no_number_hides_no_other():
    """Neither as the first nor between others; alone, it is told as what it is."""
    from rclpy.serialization import serialize_message

    from rocsafe_interfaces.msg import RadiationReading
    from rocsafe_orchestrator.recording.evidence_events import EvidenceEvents
    from rocsafe_ros.interfaces import topics

    for values, highest in (
        ((float('nan'), 3.0, 2.0), 3.0),
        ((3.0, float('nan'), 2.0), 3.0),
        ((float('nan'),), None),
    ):
        made = EvidenceEvents(lambda: 1.0, set())
        for value in values:
            message = RadiationReading(dose_rate_usvh=value)
            list(made.of(topics.RADIATION, 'rav1', message, serialize_message(message)))
        (event,) = made.rest()
        told = event.what['highest']['dose_rate_usvh']
        assert told == highest if highest else told != told
