# SPDX-License-Identifier: Apache-2.0
"""The flight of a recorded run: where each vehicle was, one place a second."""

from pathlib import Path

import pytest
from mcap_ros2.writer import Writer

from rocsafe_console.runs.recorded_flight import tracks_of

FIX = """\
std_msgs/Header header
float64 latitude
float64 longitude
================================================================================
MSG: std_msgs/Header
builtin_interfaces/Time stamp
string frame_id
================================================================================
MSG: builtin_interfaces/Time
int32 sec
uint32 nanosec
"""


@pytest.fixture
def recording(tmp_path) -> Path:
    """Return a recording of two vehicles at 5 Hz, one of which has no fix at first."""
    path = tmp_path / 'mission.mcap'
    with path.open('wb') as stream:
        writer = Writer(stream)
        schema = writer.register_msgdef('sensor_msgs/msg/NavSatFix', FIX)
        for step in range(16):
            stamp = {'sec': 100 + step // 5, 'nanosec': step % 5 * 200_000_000}
            header = {'stamp': stamp, 'frame_id': ''}
            for name, latitude in (('rav1', 53.0), ('rav2', float('nan') if step < 5 else 54.0)):
                message = {'header': header, 'latitude': latitude, 'longitude': -9.0 + step / 100}
                for topic in (f'/{name}/fix', f'/{name}/ground_truth/fix'):
                    writer.write_message(
                        topic=topic, schema=schema, message=message,
                        log_time=stamp['sec'] * 10**9 + stamp['nanosec'],
                    )  # fmt: skip
        writer.finish()
    return path


def test_each_vehicle_has_a_place_a_second(recording):
    """By its own fixes, not by the true ones; a vehicle without a fix has no place."""
    tracks = tracks_of(recording)
    assert tracks.keys() == {'rav1', 'rav2'}
    assert tracks['rav1']['time_s'] == [100.0, 101.0, 102.0, 103.0]
    assert tracks['rav1']['longitude_deg'] == pytest.approx([-9.0, -8.95, -8.9, -8.85])
    assert tracks['rav2']['time_s'] == [101.0, 102.0, 103.0]


@pytest.mark.parametrize('part', [0, 7, 200, 1000])
def test_a_torn_recording_has_no_tracks(recording, part):
    """A run that is being recorded, or was killed, is replayed without it."""
    recording.write_bytes(recording.read_bytes()[:part])
    assert tracks_of(recording) == {}
    recording.unlink()
    assert tracks_of(recording) == {}
