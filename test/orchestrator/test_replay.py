# SPDX-License-Identifier: Apache-2.0
"""A replay publishes every input once, and never more than is taken in."""

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rocsafe_orchestrator.replay.feed import (
    MOST_READINGS,
    MOST_SHOTS,
    RESEND_S,
    Feed,
    RecordedReading,
    StoredShot,
)

readings = st.builds(
    RecordedReading, st.integers(1, 500), st.sampled_from(['rav1', 'rav2']), st.just(b'')
)
shots = st.builds(StoredShot, st.integers(1, 500), st.just('rav1'), st.text('abc', min_size=1))


def unique(inputs):
    """Return inputs without those of equal names."""
    return list({(g.vehicle, getattr(g, 'shot_id', g.time_ns)): g for g in inputs}.values())


@pytest.mark.slow
@given(st.lists(st.one_of(readings, shots), max_size=150))
def test_all_inputs_are_fed_in_order_and_within_limits(inputs):
    """Whatever their order, and however late they are taken in."""
    given_ = unique(inputs)
    feed, seen = Feed(given_), []
    while feed.left:
        due = list(feed.due(0.0))
        seen += due
        waiting = [g for g in due if isinstance(g, StoredShot)]
        assert len(waiting) <= MOST_SHOTS
        assert sum(isinstance(g, RecordedReading) for g in due) <= 2 * MOST_READINGS
        assert due
        for taken in due:
            if isinstance(taken, StoredShot):
                feed.on_receipt(taken.shot_id)
            else:
                feed.on_dose_rate(taken.vehicle, taken.time_ns)
    assert sorted(seen, key=repr) == sorted(given_, key=repr)
    assert [g.time_ns for g in seen] == sorted(g.time_ns for g in seen)


def test_photograph_without_receipt_is_sent_again():
    """The collector may start late; a reading is kept by its publisher."""
    shot = StoredShot(1, 'rav1', 'rav1-00000')
    feed = Feed([shot, RecordedReading(2, 'rav1', b'')])
    assert len(list(feed.due(0.0))) == 2
    assert list(feed.due(RESEND_S - 0.1)) == []
    assert list(feed.due(RESEND_S)) == [shot]
    feed.on_receipt('rav1-00000')
    assert list(feed.due(2 * RESEND_S)) == []
    assert feed.left == 1
    feed.on_dose_rate('rav1', 2)
    assert feed.left == 0


def test_stored_photograph_becomes_the_message_that_was_stored():
    """All that the collector reads of it is in the message again."""
    pytest.importorskip('rocsafe_interfaces', reason='no ROS 2 here: source it or run make setup')
    from rocsafe_mapping.conversions import record_of_message
    from rocsafe_mapping.photographs.shot import Intrinsics, ShotRecord, plain_of_record
    from rocsafe_orchestrator.replay.shot_conversions import shot_message

    jpeg = b'\xff\xd8 a picture'
    record = ShotRecord(
        shot_id='rav1-00007', vehicle='rav1', sequence=7, viewpoint_id=3, time_ns=5,
        latitude_deg=53.28, longitude_deg=-9.06, altitude_m=98.0,
        position_covariance_m2=(0.01, 0.0, 0.0, 0.0, 0.01, 0.0, 0.0, 0.0, 0.04),
        height_agl_m=float('nan'), orientation_xyzw=(-1.0, 0.0, 0.0, 0.0),
        orientation_covariance_rad2=(1e-6,) * 9,
        camera=Intrinsics(
            width_px=64, height_px=48, fx_px=55.4, fy_px=55.4, cx_px=31.5, cy_px=23.5,
            distortion_model='plumb_bob', distortion=(0.1, 0.0, 0.0, 0.0, 0.0),
        ),
        sha256='0' * 64,
    )  # fmt: skip
    message = shot_message(plain_of_record(record), jpeg)
    again = plain_of_record(record_of_message(message))
    wanted = plain_of_record(record)
    assert again.pop('sha256') != wanted.pop('sha256')
    assert again == wanted
    with pytest.raises(ValueError, match='not the record of a photograph'):
        shot_message({}, jpeg)
